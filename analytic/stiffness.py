"""Time-variant meshing stiffness, Eqs. 7-8."""

from __future__ import annotations

import numpy as np
from numba import vectorize


def square_wave_series(
    cycle: np.ndarray, k_min: float, k_max: float, contact_ratio: float, harmonics: int
) -> np.ndarray:
    """k [N/m] of Eq. 7 with the given number of harmonics.

    cycle: t / T, any shape; contact_ratio: the paper's e, between 1 and 2.
    """
    swing = k_max - k_min
    overlap = contact_ratio - 1
    i = np.arange(1, harmonics + 1)
    turn = 2 * np.pi * i * np.asarray(cycle)[..., None]
    waves = np.sin(2 * np.pi * i * overlap - turn) + np.sin(turn)
    return k_min + swing * overlap + (waves * swing / (i * np.pi)).sum(axis=-1)


def square_wave(cycle: np.ndarray, k_min: float, k_max: float, contact_ratio: float) -> np.ndarray:
    """The wave of Fig. 5 [N/m]: k_max while two pairs of teeth carry, else k_min."""
    return np.where(np.mod(cycle, 1.0) < contact_ratio - 1, k_max, k_min)


@vectorize(cache=True)
def fundamental(sine: float, k_m: float, k_a: float) -> float:
    """k of Eq. 8 [N/m]; sine: that of the mesh phase."""
    return k_m + k_a * sine

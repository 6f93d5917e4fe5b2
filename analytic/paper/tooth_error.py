"""Tooth profile error, Eq. 14."""

from __future__ import annotations

import numpy as np


def tooth_error(sine: np.ndarray | float, E: np.ndarray | float) -> np.ndarray:
    """e of Eq. 14 [m]; sine: that of the mesh phase; E: its magnitude [m]."""
    return np.multiply(E, sine)


def total_error(
    phase: np.ndarray | float,
    E: np.ndarray | float,
    error_phase: np.ndarray | float,
    static_error: np.ndarray | float,
) -> np.ndarray:
    """e [m] where it has a phase of its own, by so much lead [rad], and a constant part [m]."""
    return static_error + tooth_error(np.sin(np.add(phase, error_phase)), E)

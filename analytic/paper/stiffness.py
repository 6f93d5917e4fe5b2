"""Time-variant meshing stiffness, Eqs. 7-8, and laws that the paper has not."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.polynomial.polynomial import polyval

from crosscheck.models.arm import stiffness as stiffness_laws

SINE, WAVES, TABLE = range(3)
TURN = 2 * np.pi
SAMPLES = 4096  # samples of a period, for the peak of a law


class StiffnessData(NamedTuple):
    """Laws of several meshes, flat.

    code (meshes,): SINE is Eq. 8, WAVES a Fourier series about the mean, TABLE cubic pieces.
    first (meshes + 1,): where a mesh's rows begin. rows (rows, 5): of a series n, the coefficients
    of cos(n phi) and sin(n phi) [N/m], 0, 0; of a table where a piece begins, in cycles, and its
    coefficients, the cubic one first.
    """

    code: np.ndarray
    first: np.ndarray
    rows: np.ndarray


def stiffness_data(laws: Sequence[stiffness_laws.StiffnessLaw]) -> StiffnessData:
    """The laws as flat arrays."""
    rows = [_rows(law) for law in laws]
    return StiffnessData(
        np.array([_code(law) for law in laws], dtype=np.int64),
        np.cumsum([0, *map(len, rows)]),
        np.concatenate([*rows, np.zeros((0, 5))]),
    )


def _code(law: stiffness_laws.StiffnessLaw) -> int:
    if isinstance(law, stiffness_laws.SineStiffness):
        return SINE
    return TABLE if isinstance(law, stiffness_laws.TableStiffness) else WAVES


def _rows(law: stiffness_laws.StiffnessLaw) -> np.ndarray:
    if isinstance(law, stiffness_laws.SineStiffness):
        return np.zeros((0, 5))
    if isinstance(law, stiffness_laws.TableStiffness):
        return _pieces(law)
    cosines, sines = _waves(law)
    orders = np.arange(1, len(cosines) + 1)
    return np.column_stack([orders, cosines, sines, 0 * cosines, 0 * cosines])


def _waves(
    law: stiffness_laws.FourierStiffness | stiffness_laws.SquareStiffness,
) -> tuple[np.ndarray, np.ndarray]:
    """Coefficients [N/m] of cos(n phi) and sin(n phi), n = 1, 2, ...; of Eq. 7 by its two sines."""
    if isinstance(law, stiffness_laws.FourierStiffness):
        count = max(len(law.cosine_N_per_m), len(law.sine_N_per_m))
        cosines, sines = np.zeros((2, count))
        cosines[: len(law.cosine_N_per_m)] = law.cosine_N_per_m
        sines[: len(law.sine_N_per_m)] = law.sine_N_per_m
        return cosines, sines
    i = np.arange(1, law.harmonics + 1)
    size = (law.largest_N_per_m - law.least_N_per_m) / (i * np.pi)
    lag = TURN * i * (law.contact_ratio - 1)
    return size * np.sin(lag), size * (1 - np.cos(lag))


def _pieces(law: stiffness_laws.TableStiffness) -> np.ndarray:
    """Pieces (pieces, 5) of the periodic cubic spline through the table, by SciPy."""
    from scipy.interpolate import CubicSpline  # a third of a second, for tables alone

    spline = CubicSpline(law.phase_cycles, law.stiffness_N_per_m, bc_type="periodic")
    return np.column_stack([spline.x[:-1], spline.c.T])


def mean_stiffness(law: stiffness_laws.StiffnessLaw) -> float:
    """Mean stiffness over a period [N/m]; of Eq. 7 its constant part."""
    if isinstance(law, stiffness_laws.TableStiffness):
        begin, a, b, c, d = _pieces(law).T
        width = np.diff(begin, append=1.0)
        return float((width * (d + width * (c / 2 + width * (b / 3 + width * a / 4)))).sum())
    if isinstance(law, stiffness_laws.SquareStiffness):
        return law.least_N_per_m + (law.largest_N_per_m - law.least_N_per_m) * (
            law.contact_ratio - 1
        )
    return law.mean_N_per_m


def square_wave_series(
    cycle: np.ndarray, k_min: float, k_max: float, contact_ratio: float, harmonics: int
) -> np.ndarray:
    """k [N/m] of Eq. 7 with the given number of harmonics.

    cycle: t / T, any shape; contact_ratio: the paper's e, between 1 and 2. Its waves
    sin(i a - i u) + sin(i u), a = 2 pi (e - 1), u = 2 pi t / T, are the imaginary part of
    (1 - exp(-j i a)) z**i, z = exp(j u): a polynomial in z.
    """
    swing = k_max - k_min
    overlap = contact_ratio - 1
    i = np.arange(1, harmonics + 1)
    factors = swing / (i * np.pi) * (1 - np.exp(-2j * np.pi * i * overlap))
    waves = polyval(np.exp(2j * np.pi * np.asarray(cycle)), [0.0, *factors]).imag
    return k_min + swing * overlap + waves


def square_wave(cycle: np.ndarray, k_min: float, k_max: float, contact_ratio: float) -> np.ndarray:
    """The wave of Fig. 5 [N/m]: k_max while two pairs of teeth carry, else k_min."""
    return np.where(np.mod(cycle, 1.0) < contact_ratio - 1, k_max, k_min)


def fundamental_stiffness(
    sine: np.ndarray | float, k_m: np.ndarray | float, k_a: np.ndarray | float
) -> np.ndarray:
    """k of Eq. 8 [N/m]; sine: that of the mesh phase."""
    return k_m + np.multiply(k_a, sine)


def stiffness(
    law: StiffnessData, i: int, phase: np.ndarray | float, k_m: float, k_a: float
) -> np.ndarray:
    """k [N/m] of mesh i at its phase (...,) [rad]."""
    if law.code[i] == SINE:
        return fundamental_stiffness(np.sin(phase), k_m, k_a)
    rows = law.rows[law.first[i] : law.first[i + 1]]
    if law.code[i] == WAVES:
        turns = np.multiply.outer(phase, rows[:, 0])
        return k_m + np.cos(turns) @ rows[:, 1] + np.sin(turns) @ rows[:, 2]
    c3, c2, c1, c0, s = _piece_at(rows, phase)
    return c0 + s * (c1 + s * (c2 + s * c3))


def stiffness_slope(
    law: StiffnessData, i: int, phase: np.ndarray | float, k_a: float
) -> np.ndarray:
    """dk/dphi [N/m per rad] of mesh i at its phase (...,) [rad]."""
    if law.code[i] == SINE:
        return np.multiply(k_a, np.cos(phase))
    rows = law.rows[law.first[i] : law.first[i + 1]]
    if law.code[i] == WAVES:
        turns, orders = np.multiply.outer(phase, rows[:, 0]), rows[:, 0]
        return np.cos(turns) @ (orders * rows[:, 2]) - np.sin(turns) @ (orders * rows[:, 1])
    c3, c2, c1, _, s = _piece_at(rows, phase)
    return (c1 + s * (2 * c2 + s * 3 * c3)) / TURN


def _piece_at(rows: np.ndarray, phase: np.ndarray | float) -> tuple[np.ndarray, ...]:
    """Coefficients of the table's piece at a phase [rad], and how far into it [cycles]."""
    cycle = np.mod(np.divide(phase, TURN), 1.0)
    row = np.searchsorted(rows[:, 0], cycle, side="right") - 1
    return (*rows[row, 1:].T, cycle - rows[row, 0])


def peak_stiffness(law: StiffnessData, k_m: np.ndarray, k_a: np.ndarray) -> np.ndarray:
    """Largest k [N/m] of every mesh, shape (meshes,); of laws other than Eq. 8 by samples."""
    peaks, phases = k_m + k_a, TURN * np.arange(SAMPLES) / SAMPLES
    for i in map(int, np.flatnonzero(law.code != SINE)):
        peaks[i] = max(peaks[i], stiffness(law, i, phases, k_m[i], k_a[i]).max())
    return peaks

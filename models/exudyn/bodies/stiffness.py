"""Stiffness laws of the contacts between Exudyn's separate bodies, each evaluated as it is stated.

A table is the periodic cubic spline by its slopes, every interval a Hermite cubic.
"""

from __future__ import annotations

from itertools import zip_longest
from typing import NamedTuple

import numpy as np

from crosscheck.models.arm import stiffness as stiffness_laws
from crosscheck.models.numba_cache import njit

SINE, FOURIER, SQUARE, TABLE = 0.0, 1.0, 2.0, 3.0
PASSES = 70  # each at least halves the slopes' error: the rest is rounding


class Spring(NamedTuple):
    """A law as numbers, all but the kind [N/m] unless stated otherwise.

    numbers (rows, columns): of a sine law its amplitude; of a Fourier law cosine, sine, order by
    order; of a square law least, largest less least, contact ratio - 1 [-], harmonics [-]; of a
    table phase [cycles], stiffness, slope [N/m per cycle], row by row.
    """

    kind: float
    mean: float
    numbers: np.ndarray


def build_spring(law: stiffness_laws.StiffnessLaw) -> Spring:
    """A stiffness law as the numbers of a Spring."""
    if isinstance(law, stiffness_laws.SineStiffness):
        return Spring(SINE, law.mean_N_per_m, np.array([[law.amplitude_N_per_m]]))
    if isinstance(law, stiffness_laws.FourierStiffness):
        waves = list(zip_longest(law.cosine_N_per_m, law.sine_N_per_m, fillvalue=0.0))
        return Spring(FOURIER, law.mean_N_per_m, np.array(waves).reshape(-1, 2))
    if isinstance(law, stiffness_laws.SquareStiffness):
        return _square_spring(law)
    return _table_spring(law)


def _square_spring(law: stiffness_laws.SquareStiffness) -> Spring:
    rise, overlap = law.largest_N_per_m - law.least_N_per_m, law.contact_ratio - 1
    numbers = np.array([[law.least_N_per_m, rise, overlap, float(law.harmonics)]])
    return Spring(SQUARE, law.least_N_per_m + overlap * rise, numbers)


def _table_spring(law: stiffness_laws.TableStiffness) -> Spring:
    """Spring of a table, its slopes found pass by pass.

    Second derivatives of neighbouring cubics are equal at every row. On the interval's two slopes
    m_0, m_1 and mean slope d they are (6 d - 4 m_0 - 2 m_1) / h at its beginning and (2 m_0 + 4 m_1
    - 6 d) / h at its end.
    """
    cycles, stiffness = np.array(law.phase_cycles), np.array(law.stiffness_N_per_m)
    width = np.diff(cycles)
    rise, inverse = np.diff(stiffness) / width**2, 1 / width
    before = np.roll(inverse, 1)
    pull, slopes = 3 * (np.roll(rise, 1) + rise), np.zeros(len(width))
    for _ in range(PASSES):
        beside = before * np.roll(slopes, 1) + inverse * np.roll(slopes, -1)
        slopes = (pull - beside) / (2 * (before + inverse))
    slopes = np.append(slopes, slopes[0])
    means = (stiffness[:-1] + stiffness[1:]) / 2 + width * (slopes[:-1] - slopes[1:]) / 12
    return Spring(TABLE, float(width @ means), np.stack([cycles, stiffness, slopes], axis=1))


@njit(cache=True)
def stiffness_at(kind: float, mean: float, numbers: np.ndarray, phase: float) -> float:
    """k [N/m] at a mesh phase [rad]; the other arguments are fields of a Spring."""
    if kind == SINE:
        return mean + numbers[0, 0] * np.sin(phase)
    if kind == FOURIER:
        return mean + waves(numbers, phase)
    if kind == SQUARE:
        return square_wave(numbers, phase)
    return hermite_cubic(numbers, phase)


@njit(cache=True)
def waves(numbers: np.ndarray, phase: float) -> float:
    """Sum of cosines and sines [N/m] over their orders 1, 2, ..."""
    total = 0.0
    for row in range(len(numbers)):
        turned = (row + 1) * phase
        total += numbers[row, 0] * np.cos(turned) + numbers[row, 1] * np.sin(turned)
    return total


@njit(cache=True)
def square_wave(numbers: np.ndarray, phase: float) -> float:
    """Eq. 7 up to its last harmonic [N/m]; the phase is 2 pi t / T."""
    least, rise, overlap, harmonics = numbers[0]
    share = overlap
    for order in range(1, int(harmonics) + 1):
        falls = np.sin(order * (2 * np.pi * overlap - phase))
        share += (falls + np.sin(order * phase)) / (order * np.pi)
    return least + rise * share


@njit(cache=True)
def interval(numbers: np.ndarray, phase: float) -> tuple[int, float]:
    """Last row of a table's interval that the phase falls into, and how far into it, 0 to 1."""
    cycle = (phase / (2 * np.pi)) % 1.0
    right = min(int(np.searchsorted(numbers[:, 0], cycle, side="right")), len(numbers) - 1)
    return right, (cycle - numbers[right - 1, 0]) / (numbers[right, 0] - numbers[right - 1, 0])


@njit(cache=True)
def hermite_cubic(numbers: np.ndarray, phase: float) -> float:
    """Stiffness [N/m] by the Hermite cubic of the interval that the phase falls into."""
    right, s = interval(numbers, phase)
    begin, end = numbers[right - 1], numbers[right]
    width = end[0] - begin[0]
    from_begin = (1 - s) ** 2 * ((1 + 2 * s) * begin[1] + s * width * begin[2])
    return from_begin + s**2 * ((3 - 2 * s) * end[1] - (1 - s) * width * end[2])


@njit(cache=True)
def slope_at(kind: float, numbers: np.ndarray, phase: float) -> float:
    """dk/d phase [N/m per rad] at a mesh phase [rad]; the others are fields of a Spring."""
    if kind == SINE:
        return numbers[0, 0] * np.cos(phase)
    if kind == FOURIER:
        return waves_slope(numbers, phase)
    if kind == SQUARE:
        return square_wave_slope(numbers, phase)
    return hermite_cubic_slope(numbers, phase) / (2 * np.pi)


@njit(cache=True)
def waves_slope(numbers: np.ndarray, phase: float) -> float:
    """Derivative of ``waves`` [N/m per rad]."""
    total = 0.0
    for row in range(len(numbers)):
        order = row + 1
        turned = order * phase
        total += order * (numbers[row, 1] * np.cos(turned) - numbers[row, 0] * np.sin(turned))
    return total


@njit(cache=True)
def square_wave_slope(numbers: np.ndarray, phase: float) -> float:
    """Derivative of ``square_wave`` [N/m per rad]."""
    _, rise, overlap, harmonics = numbers[0]
    share = 0.0
    for order in range(1, int(harmonics) + 1):
        share += np.cos(order * phase) - np.cos(order * (2 * np.pi * overlap - phase))
    return rise * share / np.pi


@njit(cache=True)
def hermite_cubic_slope(numbers: np.ndarray, phase: float) -> float:
    """Derivative of ``hermite_cubic`` [N/m per cycle]: between rows a parabola of rise and two
    slopes.
    """
    right, s = interval(numbers, phase)
    begin, end = numbers[right - 1], numbers[right]
    rise = (end[1] - begin[1]) / (end[0] - begin[0])
    return 6 * s * (1 - s) * rise + (1 - s) * (1 - 3 * s) * begin[2] + s * (3 * s - 2) * end[2]

"""Stiffness laws of the Exudyn tree's meshes as flat numbers, and compiled.

Fourier series and square wave are one sum of waves here; a table is the periodic cubic spline by
its second derivatives.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from crosscheck.models.arm import stiffness as stiffness_laws
from crosscheck.models.numba_cache import njit

SINE, WAVES, SPLINE = 0.0, 1.0, 2.0
KIND, MEAN, AMPLITUDE, ROWS, FIRST = range(
    5
)  # places in StiffnessCurve.array; FIRST that of the columns
SAMPLES_PER_WAVE, SAMPLES_PER_ROW = 64, 16
Number = Any  # float, or complex for a slope: numba compiles both, mypy sees no such choice


class StiffnessCurve(NamedTuple):
    """k [N/m] over the mesh phase; ``array`` lays it out for the compiled functions.

    columns: of waves their cosines and sines [N/m]; of a spline its phases [cycles], stiffnesses
    [N/m] and second derivatives [N/m per cycle^2], the first row again at the end.
    """

    kind: float
    mean: float
    amplitude: float = 0.0
    columns: tuple[np.ndarray, ...] = ()

    @property
    def array(self) -> np.ndarray:
        """float64: kind, mean, amplitude, length of a column, and column after column."""
        rows = len(self.columns[0]) if self.columns else 0
        return np.concatenate([[self.kind, self.mean, self.amplitude, rows], *self.columns])

    @property
    def largest_stiffness(self) -> float:
        """Largest stiffness [N/m]; of waves and splines the largest of fine samples."""
        if self.kind == SINE:
            return self.mean + self.amplitude
        array = self.array
        return max(stiffness_at(array, 0, phase, np.sin(phase)) for phase in self._phases())

    def _phases(self) -> np.ndarray:
        if self.kind == WAVES:
            count = SAMPLES_PER_WAVE * max(len(self.columns[0]), 1)
            return 2 * np.pi * np.arange(count) / count
        cycles = self.columns[0]
        along = np.arange(SAMPLES_PER_ROW) / SAMPLES_PER_ROW
        return 2 * np.pi * (cycles[:-1, None] + np.diff(cycles)[:, None] * along).ravel()


def constant_curve(stiffness: float) -> StiffnessCurve:
    """The curve of a stiffness [N/m] that is the same at every phase."""
    return StiffnessCurve(SINE, stiffness)


def build_curve(law: stiffness_laws.StiffnessLaw) -> StiffnessCurve:
    """A stiffness law as the numbers of a curve."""
    if isinstance(law, stiffness_laws.SineStiffness):
        return StiffnessCurve(SINE, law.mean_N_per_m, law.amplitude_N_per_m)
    if isinstance(law, stiffness_laws.TableStiffness):
        return _spline_curve(np.array(law.phase_cycles), np.array(law.stiffness_N_per_m))
    if isinstance(law, stiffness_laws.SquareStiffness):
        return _square_curve(law)
    cosines, sines = law.cosine_N_per_m, law.sine_N_per_m
    columns = np.zeros((2, max(len(cosines), len(sines))))
    columns[0, : len(cosines)], columns[1, : len(sines)] = cosines, sines
    return StiffnessCurve(WAVES, law.mean_N_per_m, columns=tuple(columns))


def _square_curve(law: stiffness_laws.SquareStiffness) -> StiffnessCurve:
    """The curve of Eq. 7, its sin(i (u - phase)) taken apart, u = 2 pi (contact ratio - 1)."""
    swing, overlap = law.largest_N_per_m - law.least_N_per_m, law.contact_ratio - 1
    order = np.arange(1, law.harmonics + 1)
    size, turned = swing / (np.pi * order), 2 * np.pi * overlap * order
    cosines, sines = size * np.sin(turned), size * (1 - np.cos(turned))
    return StiffnessCurve(WAVES, law.least_N_per_m + swing * overlap, columns=(cosines, sines))


def _spline_curve(cycles: np.ndarray, stiffness: np.ndarray) -> StiffnessCurve:
    """The curve of a table, by the periodic cubic spline.

    Slopes of neighbouring cubics are equal at every row, the last one's those of the first.
    """
    from scipy.sparse import csc_array  # for tables alone
    from scipy.sparse.linalg import spsolve

    width = np.diff(cycles)
    slope, before, count = np.diff(stiffness) / width, np.roll(width, 1), len(width)
    here = np.arange(count)
    entries = np.concatenate([before / 6, (before + width) / 3, width / 6])
    columns = np.concatenate([np.roll(here, 1), here, np.roll(here, -1)])
    system = csc_array((entries, (np.tile(here, 3), columns)), shape=(count, count))
    bends = spsolve(system, slope - np.roll(slope, 1))
    bends = np.append(bends, bends[0])
    area = width * (stiffness[:-1] + stiffness[1:]) / 2 - width**3 * (bends[:-1] + bends[1:]) / 24
    return StiffnessCurve(SPLINE, float(area.sum()), columns=(cycles, stiffness, bends))


@njit(cache=True)
def stiffness_at(law: np.ndarray, place: int, phase: Number, sine: Number) -> Number:
    """k [N/m] at a mesh phase [rad] and its sine; ``law[place:]`` begins as a StiffnessCurve.array.

    Every law is the same function of a complex phase near the real ones.
    """
    if law[place + KIND] == SINE:
        return law[place + MEAN] + law[place + AMPLITUDE] * sine
    if law[place + KIND] == WAVES:
        return waves_at(law, place, phase)
    return spline_at(law, place, phase)


@njit(cache=True)
def waves_at(law: np.ndarray, place: int, phase: Number) -> Number:
    """Stiffness [N/m] by mean and waves, each order turned on from the last by the phase."""
    rows, first = int(law[place + ROWS]), place + FIRST
    cosine, sine = np.cos(phase), np.sin(phase)
    along, across, total = cosine, sine, law[place + MEAN]
    for row in range(first, first + rows):
        total += law[row] * along + law[row + rows] * across
        along, across = along * cosine - across * sine, along * sine + across * cosine
    return total


@njit(cache=True)
def spline_at(law: np.ndarray, place: int, phase: Number) -> Number:
    """Stiffness [N/m] by the periodic cubic spline at a mesh phase [rad]."""
    rows, first = int(law[place + ROWS]), place + FIRST
    at = phase / (2 * np.pi)
    at -= np.floor(at.real)
    left, right = first, first + rows - 1
    while right - left > 1:
        middle = (left + right) // 2
        if law[middle] <= at.real:
            left = middle
        else:
            right = middle
    width = law[right] - law[left]
    a, b = (law[right] - at) / width, (at - law[left]) / width
    straight = a * law[left + rows] + b * law[right + rows]
    cube_a, cube_b = a * a * a, b * b * b
    bent = (cube_a - a) * law[left + 2 * rows] + (cube_b - b) * law[right + 2 * rows]
    return straight + bent * width**2 / 6

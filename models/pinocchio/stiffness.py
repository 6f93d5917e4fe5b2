"""Mesh stiffness over the mesh phase, for Pinocchio's gear tree: sums of waves and a B-spline."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import cos, pi, sin
from typing import TYPE_CHECKING

import numpy as np

from crosscheck.models.arm import stiffness as stiffness_laws

if TYPE_CHECKING:
    from scipy.interpolate import BSpline


@dataclass(frozen=True)
class StiffnessWaves:
    """mean + sum over n = 1, 2, ... of cosine_n cos(n phase) + sine_n sin(n phase) [N/m]."""

    mean: float
    cosine: np.ndarray
    sine: np.ndarray

    def value(self, phase: np.ndarray) -> np.ndarray:
        """k [N/m] at phases (meshes,) [rad]."""
        cosines = _harmonics(np.cos, phase, self.cosine)
        return self.mean + cosines + _harmonics(np.sin, phase, self.sine)

    def slope(self, phase: np.ndarray) -> np.ndarray:
        """dk/dphase [N/m] at phases (meshes,) [rad], term by term."""
        rising = _harmonics(np.cos, phase, _slope_sizes(self.sine))
        return rising - _harmonics(np.sin, phase, _slope_sizes(self.cosine))


@dataclass(frozen=True)
class Spline:
    """A periodic cubic spline over cycles; its knots are a table's rows."""

    curve: BSpline

    @property
    def mean(self) -> float:
        """Mean stiffness over a period [N/m]."""
        return float(self.curve.integrate(0.0, 1.0))

    def value(self, phase: np.ndarray) -> np.ndarray:
        """k [N/m] at phases (meshes,) [rad]."""
        return np.asarray(self.curve(phase / (2 * pi)))  # itself takes them modulo a period

    def slope(self, phase: np.ndarray) -> np.ndarray:
        """dk/dphase [N/m] at phases (meshes,) [rad]."""
        return np.asarray(self.curve(phase / (2 * pi), 1)) / (2 * pi)


@dataclass(frozen=True)
class MeshStiffness:
    """Many meshes' stiffness: the places of the meshes that share a curve, and the curve."""

    shares: tuple[tuple[np.ndarray, StiffnessWaves | Spline], ...]

    def value(self, phase: np.ndarray) -> np.ndarray:
        """k [N/m] of every mesh at its phase [rad], both of shape (meshes,)."""
        stiffness = np.empty_like(phase)
        for places, curve in self.shares:
            stiffness[places] = curve.value(phase[places])
        return stiffness

    def slope(self, phase: np.ndarray) -> np.ndarray:
        """dk/dphase [N/m] of every mesh at its phase [rad], both of shape (meshes,)."""
        slope = np.empty_like(phase)
        for places, curve in self.shares:
            slope[places] = curve.slope(phase[places])
        return slope


def build_mesh_stiffness(laws: Sequence[stiffness_laws.StiffnessLaw]) -> MeshStiffness:
    """The stiffness of meshes that follow these laws, one law per mesh."""
    shares = []
    for law in dict.fromkeys(laws):
        places = np.array([place for place, other in enumerate(laws) if other == law])
        shares.append((places, build_curve(law)))
    return MeshStiffness(tuple(shares))


def build_curve(law: stiffness_laws.StiffnessLaw) -> StiffnessWaves | Spline:
    """A stiffness law as waves or a spline, which evaluate it."""
    if isinstance(law, stiffness_laws.TableStiffness):
        from scipy.interpolate import make_interp_spline  # for tables alone

        spline = make_interp_spline(law.phase_cycles, law.stiffness_N_per_m, bc_type="periodic")
        return Spline(spline)
    if isinstance(law, stiffness_laws.SquareStiffness):
        return _square_waves(law)
    if isinstance(law, stiffness_laws.FourierStiffness):
        cosine, sine = np.array(law.cosine_N_per_m), np.array(law.sine_N_per_m)
        return StiffnessWaves(law.mean_N_per_m, cosine, sine)
    amplitude = np.array([law.amplitude_N_per_m])  # Eq. 8
    return StiffnessWaves(law.mean_N_per_m, np.zeros(0), amplitude)


def _square_waves(law: stiffness_laws.SquareStiffness) -> StiffnessWaves:
    """Fourier coefficients of the wave that is largest in the first e - 1 of a period, least else.

    Eq. 7, its phase shifts resolved.
    """
    swing, width = law.largest_N_per_m - law.least_N_per_m, law.contact_ratio - 1
    ends = [(n, 2 * pi * n * width) for n in range(1, law.harmonics + 1)]
    cosine = np.array([swing * sin(end) / (pi * n) for n, end in ends])
    sine = np.array([swing * (1 - cos(end)) / (pi * n) for n, end in ends])
    return StiffnessWaves(law.least_N_per_m + swing * width, cosine, sine)


def _harmonics(
    wave: Callable[[np.ndarray], np.ndarray], phase: np.ndarray, sizes: np.ndarray
) -> np.ndarray:
    """Sum over n = 1, 2, ... of size_n wave(n phase), shape (meshes,)."""
    return wave(np.multiply.outer(phase, np.arange(1, len(sizes) + 1))) @ sizes


def _slope_sizes(sizes: np.ndarray) -> np.ndarray:
    """n size_n, the sizes of a derivative's waves."""
    return np.arange(1, len(sizes) + 1) * sizes

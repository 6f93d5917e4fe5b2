"""Poles of an arm with its teeth in contact, against differences of another model's forces."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from crosscheck.checks.modes import mean_stiffness
from crosscheck.findings import About, Finding, checked
from crosscheck.models.arm.arm import Arm
from crosscheck.models.arm.mesh import Mesh
from crosscheck.models.arm.meshes import with_meshes
from crosscheck.models.arm.stiffness import SineStiffness, StiffnessLaw

TOLERANCE, SAFETY = 1e-7, 3.0
MEANINGFUL = 1e-5  # what no slip of a formula is below
# Of a step by poles: the method's polynomial, how far it may be from zero in units of the fastest
# pole, and how closely it is looked for.
STABILITY = np.array([1 / 24, 1 / 6, 1 / 2, 1.0, 1.0])
REACH, STEPS, OTHER_POSES = 3.0, 2000, 1.5
SLOW = 1e-3  # of the fastest pole: slower ones are known to that share of its rounding
BASIS = "1e-7: differences over 1e-4 rad leave 2e-9 of a weight's slope, roundings 1e-9 of a mesh's"


def linear_teeth(arm: Arm, stiffness: Callable[[StiffnessLaw], float] = mean_stiffness) -> Arm:
    """The arm with teeth that never part, without errors, at a stiffness [N/m] of each law."""

    def linear(mesh: Mesh) -> Mesh:
        laws = mesh.stiffness
        constant = tuple(map(held, laws)) if isinstance(laws, tuple) else held(laws)
        clean = {"backlash_m": 0.0, "tooth_error_m": 0.0, "static_error_m": 0.0}
        return mesh.model_copy(update={"stiffness": constant, **clean})

    def held(law: StiffnessLaw) -> SineStiffness:
        mean = stiffness(law)  # of a law within its range it may be beyond that of a mean
        return SineStiffness.model_construct(law="sine", mean_N_per_m=mean, amplitude_N_per_m=0.0)

    return with_meshes(arm, linear)


def poles_follow(about: About, poles: np.ndarray, mass: np.ndarray, slopes: np.ndarray) -> Finding:
    """Poles [1/s], (2 n,), must be those of M (n, n) and the force's slopes by q and v.

    Each is held against the nearest of the others, both ways. slopes (2, n, 2 n): over differences
    of one size and of twice that; what this moves the poles is what rounding and curvature do.
    """
    expected, again = (_poles(mass, each) for each in slopes)
    measured, moved = (_distance(found, expected) for found in (poles, again))
    tolerance = TOLERANCE + SAFETY * moved
    return checked(
        about,
        measured=measured,
        tolerance=tolerance,
        basis=f"{BASIS}; and {SAFETY:g} x {moved:.1g}, which twice the differences move them",
        resolved=tolerance <= MEANINGFUL,
        relative=measured,
    )


def step_follows(about: About, limit: np.ndarray, mass: np.ndarray, slopes: np.ndarray) -> Finding:
    """A model's largest stable step [s], (), against that of Runge and Kutta's method at its poles.

    mass, slopes: of one pose with the teeth at their largest stiffness, as in poles_follow.
    """
    poles = _poles(mass, slopes[0])
    # The first step at which |1 + z + ... + z^4 / 24| > 1, z = h p, of any mode. The method must
    # follow a growing mode's frequency too, so its growth alone is left out.
    own = np.minimum(poles.real, 0.0) + 1j * poles.imag
    steps = np.linspace(0.0, REACH / np.abs(own).max(), STEPS)[1:]
    grows = (np.abs(np.polyval(STABILITY, np.outer(steps, own))) > 1 + 1e-6).any(axis=1)
    limit_s, expected = float(limit), float(steps[np.argmax(grows)] if grows.any() else steps[-1])
    measured = max(limit_s / expected, expected / limit_s)
    return checked(
        about,
        measured=measured,
        tolerance=OTHER_POSES,
        basis=f"{OTHER_POSES:g}: other poses, and bounds of a stiffness that overshoots",
        note=f"{limit_s:.4g} s, by the poles {expected:.4g} s",
    )


def _poles(mass: np.ndarray, slopes: np.ndarray) -> np.ndarray:
    n = len(mass)
    return np.linalg.eigvals(np.vstack([np.eye(n, 2 * n, n), np.linalg.solve(mass, slopes)]))


def _distance(poles: np.ndarray, expected: np.ndarray) -> float:
    """Of a pole to the nearest of the others, over its size, at most."""
    apart = np.abs(poles[:, None] - expected[None, :])
    size = np.maximum(np.abs(expected), SLOW * np.abs(expected).max())
    with np.errstate(divide="ignore", invalid="ignore"):  # a system without a motion has no poles
        relative = apart / size
    return max(float(relative.min(axis=side).max()) for side in (0, 1))

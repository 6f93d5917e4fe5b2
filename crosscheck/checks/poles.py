"""Poles of an arm with its teeth in contact, against differences of another model's forces."""

from __future__ import annotations

import numpy as np

from crosscheck.checks.modes import mean_stiffness
from crosscheck.findings import About, Finding, checked
from models.arm import Arm
from models.mesh import Mesh
from models.meshes import with_meshes
from models.stiffness import SineStiffness, StiffnessLaw

TOLERANCE = 1e-7
SLOW = 1e-3  # of the fastest pole: slower ones are known to that share of its rounding
BASIS = "1e-7: differences over 1e-4 rad leave 2e-9 of a weight's slope, roundings 1e-9 of a mesh's"


def linear_teeth(arm: Arm) -> Arm:
    """The arm with teeth that never part, at their mean stiffness, without errors."""
    return with_meshes(arm, _linear)


def _linear(mesh: Mesh) -> Mesh:
    laws = mesh.stiffness
    constant = tuple(map(_constant, laws)) if isinstance(laws, tuple) else _constant(laws)
    clean = {"backlash_m": 0.0, "tooth_error_m": 0.0, "static_error_m": 0.0}
    return mesh.model_copy(update={"stiffness": constant, **clean})


def _constant(law: StiffnessLaw) -> SineStiffness:
    return SineStiffness(law="sine", mean_N_per_m=mean_stiffness(law), amplitude_N_per_m=0.0)


def poles_follow(about: About, poles: np.ndarray, mass: np.ndarray, slopes: np.ndarray) -> Finding:
    """Poles [1/s], (2 n,), must be those of M (n, n) and the slopes (n, 2 n) of force by q and v.

    Each is held against the nearest of the others, both ways.
    """
    n = len(mass)
    system = np.vstack([np.eye(n, 2 * n, n), np.linalg.solve(mass, slopes)])
    expected = np.linalg.eigvals(system)
    apart = np.abs(poles[:, None] - expected[None, :])
    size = np.maximum(np.abs(expected), SLOW * np.abs(expected).max())
    with np.errstate(divide="ignore", invalid="ignore"):  # a system without a motion has no poles
        relative = apart / size
    measured = max(float(relative.min(axis=side).max()) for side in (0, 1))
    return checked(about, measured=measured, tolerance=TOLERANCE, basis=BASIS, relative=measured)

"""The arm in contact under its controller, linearised: where the feedback makes the teeth flutter.

With every tooth in contact, at rest in a pose, M q'' + D q' + K q = -B (P y + D y'): B = drive_map
turns an output-side torque T into generalized force. The torque T/n acts on the sun, whose angle is
theta_s, so by virtual work B = d(theta_s / n)/dq. The paper's controller senses the link,
y = theta; at the sun it would sense y = theta_s / n = B^T q, and the feedback -B (P B^T q + D B^T
q') is symmetric: it can only store and dissipate energy. That is all that "sensing at the sun"
changes here.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.optimize import brentq

from crosscheck.analytic.model import AnalyticModel, PhysicalModel
from crosscheck.audit.experiments.variant import Variant

LINK, SUN = "link", "sun"
PAPER_GAINS = (1000.0, 400.0)  # P [N m/rad], D [N m s/rad]
SLOWEST_MESH_MODE = 2 * np.pi * 100  # [rad/s]: the mesh modes lie above 1 kHz, the arm's far below
LARGEST_ZETA = 1.0


@dataclass(frozen=True)
class Point:
    """A pose and a setting of the controller.

    gains (P [N m/rad], D [N m s/rad]); elbow_rad the pose (theta_1 does not enter); stiffness: of
    every mesh as a multiple of k_m; sensed: LINK or SUN.
    """

    arm: str = "paper-labelled"
    gains: tuple[float, float] = PAPER_GAINS
    elbow_rad: float = 0.0
    stiffness: float = 1.0
    sensed: str = LINK


def growth(point: Point, zeta: float) -> tuple[float, float]:
    """(growth rate [1/s], frequency [Hz]) of the least stable mesh mode."""
    return _least_stable(*_system(point), zeta)


def threshold(point: Point) -> float:
    """Damping ratio below which a mesh mode flutters; 0 if none does even without damping."""
    matrices = _system(point)

    def rate(zeta: float) -> float:
        return _least_stable(*matrices, zeta)[0]

    if rate(0.0) <= _rounding(matrices[0]):
        return 0.0
    return float(brentq(rate, 0.0, LARGEST_ZETA, xtol=1e-9))


def _rounding(stiff: np.ndarray) -> float:
    """Growth rate [1/s] that eigenvalue rounding alone can give an undamped mode."""
    return 1e-9 * float(np.sqrt(np.abs(stiff).max()))


def _system(point: Point) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(A, G, H), each (n, n): q'' = A q + (G + zeta H) q'."""
    model = _model(point.arm)
    pose = np.zeros(len(model.coordinates))
    pose[model.layout.theta[-1]] = point.elbow_rad
    mass = model.mass_matrix(pose)
    position, rate = feedback(model, point.gains, point.sensed)
    position[:, model.gears.where] += point.stiffness * model.terms.mesh_map * model.gears.k_m
    damping = np.zeros_like(mass)
    damping[model.gears.where, model.gears.where] = -model.gears.d
    parts = (position, rate, damping)
    return tuple(np.linalg.solve(mass, part) for part in parts)  # type: ignore[return-value]


def feedback(
    model: AnalyticModel, gains: tuple[float, float], sensed: str
) -> tuple[np.ndarray, np.ndarray]:
    """Generalized force per coordinate and per rate, (n, n) each, that the controller adds."""
    drive = model.terms.drive_map
    output = drive.T if sensed == SUN else np.eye(len(model.layout))[model.layout.theta]
    return -gains[0] * drive @ output, -gains[1] * drive @ output


def _least_stable(
    position: np.ndarray, rate: np.ndarray, unit_damping: np.ndarray, zeta: float
) -> tuple[float, float]:
    zero, unit = np.zeros_like(position), np.eye(len(position))
    poles = np.linalg.eigvals(np.block([[zero, unit], [position, rate + zeta * unit_damping]]))
    mesh = poles[poles.imag > SLOWEST_MESH_MODE]
    worst = mesh[np.argmax(mesh.real)]
    return float(worst.real), float(worst.imag / (2 * np.pi))


@lru_cache
def _model(arm: str) -> PhysicalModel:
    """The geared arm at damping ratio 1, so that D scales with zeta."""
    return PhysicalModel(*Variant("pd", arm, zeta=1.0).case())

"""The loop's linear limits: at which damping a mesh mode turns unstable, and how fast it grows.

With every tooth in contact, at rest in a pose, M q'' + D q' + K q = -B (P y + D y'): B = drive_map
turns an output-side torque T into generalized force. The torque T/n acts on the sun, whose angle is
theta_s, so by virtual work B = d(theta_s / n)/dq. The paper's controller senses the link,
y = theta; at the sun it would sense y = theta_s / n = B^T q, and the feedback -B (P B^T q + D B^T
q') is symmetric: it can only store and dissipate energy. That is all that "sensing at the sun"
changes here.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.optimize import brentq

from crosscheck.analytic.model import AnalyticModel, PhysicalModel
from crosscheck.audit.experiments.paper_conditions import READINGS
from crosscheck.audit.experiments.variant import Variant
from crosscheck.audit.measures.undefined import JsonObject

ELBOWS_DEG = (0, 30, 60, 90, 120, 150, 180)
STIFFNESSES = (0.8, 1.0, 1.2)  # (k_m - k_a, k_m, k_m + k_a) / k_m
LINK, SUN = "link", "sun"
PAPER_GAINS = (1000.0, 400.0)  # P [N m/rad], D [N m s/rad]
SLOWEST_MESH_MODE = 2 * np.pi * 100  # [rad/s]: the mesh modes lie above 1 kHz, the arm's far below
LARGEST_ZETA = 1.0


@dataclass(frozen=True)
class Point:
    """A pose of the arm and a setting of the controller.

    gains (P [N m/rad], D [N m s/rad]); elbow_rad the pose (theta_1 does not enter); stiffness: of
    every mesh as a multiple of k_m; sensed: LINK or SUN.
    """

    arm: str = "paper-labelled"
    gains: tuple[float, float] = PAPER_GAINS
    elbow_rad: float = 0.0
    stiffness: float = 1.0
    sensed: str = LINK


def growth(point: Point, zeta: float) -> tuple[float, float]:
    """Growth rate [1/s] and frequency [Hz] of the least stable mesh mode."""
    return _least_stable(*_system(point), zeta)


def find_threshold(point: Point) -> float:
    """Damping ratio below which a mesh mode flutters; 0 if none does even without damping."""
    matrices = _system(point)

    def rate(zeta: float) -> float:
        return _least_stable(*matrices, zeta)[0]

    rounding = 1e-9 * np.sqrt(np.abs(matrices[0]).max())  # of eigenvalues, in an undamped mode
    if rate(0.0) <= rounding:
        return 0.0
    return float(brentq(rate, 0.0, LARGEST_ZETA, xtol=1e-9))


def _system(point: Point) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The matrices (A, G, H), each (n, n), of q'' = A q + (G + zeta H) q'."""
    model = _model(point.arm)
    pose = np.zeros(len(model.coordinates))
    pose[model.layout.theta[-1]] = point.elbow_rad
    mass = model.mass_matrix(pose)
    position, rate = feedback(model, point.gains, point.sensed)
    position[:, model.gears.x_index] += point.stiffness * model.terms.mesh_map * model.gears.k_m
    damping = np.zeros_like(mass)
    damping[model.gears.x_index, model.gears.x_index] = -model.gears.d
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


@dataclass(frozen=True)
class Threshold:
    """The damping ratio at which a mesh mode turns unstable in contact.

    zeta: 0 if nowhere; frequency_Hz: of the mode there; undamped_growth_per_s: of the least stable
    mode without damping.
    """

    point: Point
    zeta: float
    frequency_Hz: float
    undamped_growth_per_s: float

    def to_dict(self) -> JsonObject:
        """The threshold as a JSON object."""
        point = self.point
        pose = f"elbow {np.degrees(point.elbow_rad):g}"
        return {
            "id": f"finding/limit/{point.arm}/{pose}/k {point.stiffness:g}/{point.sensed}",
            "unstable_below_zeta": self.zeta,
            "frequency_Hz": self.frequency_Hz,
            "undamped_growth_per_s": self.undamped_growth_per_s,
        }


def find_thresholds(quick: bool) -> list[Threshold]:
    """The thresholds with the paper's gains over poses, stiffness and what is sensed."""
    arms = tuple(READINGS)[:1] if quick else tuple(READINGS)
    elbows = ELBOWS_DEG[:2] if quick else ELBOWS_DEG
    points = [Point(a, elbow_rad=np.radians(e), sensed=s) for a in arms for e in elbows
              for s in (LINK, SUN)]  # fmt: skip
    points += [Point(arm, stiffness=stiffness) for arm in arms for stiffness in STIFFNESSES]
    thresholds = []
    for point in dict.fromkeys(points):
        edge = find_threshold(point)
        _, frequency = growth(point, edge)
        thresholds.append(Threshold(point, edge, frequency, growth(point, 0.0)[0]))
    return thresholds


def is_cured_at_sun(thresholds: Sequence[Threshold]) -> bool:
    """Whether sensing at the sun leaves no threshold, where there is one otherwise."""
    sun, link = (
        [limit.zeta for limit in thresholds if limit.point.sensed == sensed]
        for sensed in (SUN, LINK)
    )
    return max(sun) == 0.0 and min(link) > 0.0

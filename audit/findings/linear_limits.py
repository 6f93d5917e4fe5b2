"""The loop's linear limits: at which damping a mesh mode turns unstable, and how fast it grows.

With every tooth in contact, at rest in a pose, M q'' + D q' + K q = -B (P y + D y'): B = drive_map
turns an output-side torque T into generalized force. The torque T/n acts on the sun, whose angle is
theta_s, so by virtual work B = d(theta_s / n)/dq. The paper's controller senses the link,
y = theta; at the sun it would sense y = theta_s / n = B^T q, and the feedback -B (P B^T q + D B^T
q') is symmetric: it can only store and dissipate energy. That is all that "sensing at the sun"
changes here.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache, partial

import numpy as np
from scipy.optimize import brentq

from crosscheck.analytic.model import PhysicalModel
from crosscheck.analytic.stability import contact_eigenvalues
from crosscheck.audit.experiments.paper_conditions import READINGS
from crosscheck.audit.experiments.variant import Variant

ELBOWS_DEG = (0, 30, 60, 90, 120, 150, 180)
STIFFNESSES = (0.8, 1.0, 1.2)  # (k_m - k_a, k_m, k_m + k_a) / k_m
LINK, SUN = "link", "sun"
SLOWEST_MESH_MODE = 2 * np.pi * 100  # [rad/s]: the mesh modes lie above 1 kHz, the arm's far below
LARGEST_ZETA = 1.0
ROUNDING_PER_S = 1e-4  # of an undamped mode's growth: 1e-9 of the frequency of the fastest


@dataclass(frozen=True)
class Point:
    """A pose of the arm, its stiffness, and what its controller senses.

    elbow_rad: the pose (theta_1 does not enter); stiffness: of every mesh as a multiple of k_m;
    sensed: LINK or SUN.
    """

    arm: str = "paper-labelled"
    elbow_rad: float = 0.0
    stiffness: float = 1.0
    sensed: str = LINK

    @property
    def id(self) -> str:
        """The name of the point in claims.json."""
        pose = f"elbow {np.degrees(self.elbow_rad):g}"
        return f"finding/limit/{self.arm}/{pose}/k {self.stiffness:g}/{self.sensed}"


def compute_growth(point: Point, zeta: float) -> float:
    """Growth rate [1/s] of the least stable mesh mode."""
    model = _model(point.arm)
    pose = np.zeros(len(model.layout))
    pose[model.layout.theta[-1]] = point.elbow_rad
    poles = contact_eigenvalues(
        model.terms,
        model.gears._replace(d=zeta * model.gears.d),
        model.drive,
        pose,
        point.stiffness * model.gears.k_m,
        model.terms.drive_map if point.sensed == SUN else None,
    )
    return float(poles.real[poles.imag > SLOWEST_MESH_MODE].max())


def find_threshold(point: Point) -> float:
    """Damping ratio below which a mesh mode flutters; 0 if none does even without damping."""
    if compute_growth(point, 0.0) <= ROUNDING_PER_S:
        return 0.0
    return float(brentq(partial(compute_growth, point), 0.0, LARGEST_ZETA, xtol=1e-9))


@lru_cache
def _model(arm: str) -> PhysicalModel:
    """The geared arm at damping ratio 1, so that D scales with zeta."""
    return PhysicalModel(*Variant("pd", arm, zeta=1.0).case())


def find_thresholds() -> dict[Point, float]:
    """The thresholds with the paper's gains over poses, stiffness and what is sensed."""
    points = [
        Point(arm, elbow_rad=np.radians(elbow), sensed=sensed)
        for arm in READINGS
        for elbow in ELBOWS_DEG
        for sensed in (LINK, SUN)
    ]
    points += [Point(arm, stiffness=stiffness) for arm in READINGS for stiffness in STIFFNESSES]
    return {point: find_threshold(point) for point in dict.fromkeys(points)}


def is_cured_at_sun(thresholds: Mapping[Point, float]) -> bool:
    """Whether sensing at the sun leaves no threshold, where there is one otherwise."""
    sun, link = (
        [zeta for point, zeta in thresholds.items() if point.sensed == sensed]
        for sensed in (SUN, LINK)
    )
    return max(sun) == 0.0 and min(link) > 0.0

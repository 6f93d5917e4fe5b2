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

from crosscheck.analytic.model import PhysicalModel
from crosscheck.analytic.stability import contact_eigenvalues
from crosscheck.audit.experiments.paper_conditions import READINGS
from crosscheck.audit.experiments.variant import Variant
from crosscheck.audit.measures.undefined import JsonObject

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

    def rate(zeta: float) -> float:
        return compute_growth(point, zeta)

    if rate(0.0) <= ROUNDING_PER_S:
        return 0.0
    return float(brentq(rate, 0.0, LARGEST_ZETA, xtol=1e-9))


@lru_cache
def _model(arm: str) -> PhysicalModel:
    """The geared arm at damping ratio 1, so that D scales with zeta."""
    return PhysicalModel(*Variant("pd", arm, zeta=1.0).case())


@dataclass(frozen=True)
class Threshold:
    """The damping ratio at which a mesh mode turns unstable in contact; 0 if nowhere."""

    point: Point
    zeta: float

    def to_dict(self) -> JsonObject:
        """The threshold as a JSON object."""
        point = self.point
        pose = f"elbow {np.degrees(point.elbow_rad):g}"
        return {
            "id": f"finding/limit/{point.arm}/{pose}/k {point.stiffness:g}/{point.sensed}",
            "unstable_below_zeta": self.zeta,
        }


def find_thresholds() -> list[Threshold]:
    """The thresholds with the paper's gains over poses, stiffness and what is sensed."""
    points = [Point(a, elbow_rad=np.radians(e), sensed=s) for a in READINGS for e in ELBOWS_DEG
              for s in (LINK, SUN)]  # fmt: skip
    points += [Point(arm, stiffness=stiffness) for arm in READINGS for stiffness in STIFFNESSES]
    return [Threshold(point, find_threshold(point)) for point in dict.fromkeys(points)]


def is_cured_at_sun(thresholds: Sequence[Threshold]) -> bool:
    """Whether sensing at the sun leaves no threshold, where there is one otherwise."""
    sun, link = (
        [limit.zeta for limit in thresholds if limit.point.sensed == sensed]
        for sensed in (SUN, LINK)
    )
    return max(sun) == 0.0 and min(link) > 0.0

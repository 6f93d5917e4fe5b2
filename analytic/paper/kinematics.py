"""Mesh kinematics of one planetary stage, Eqs. 2-3, and the stage's geometry."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from crosscheck.models.arm.gears import PlanetaryGears


class StageGeometry(NamedTuple):
    """Radii [m] and ratio of one stage.

    r_s, r_p: base radii of sun and planet; r_c: carrier radius; r_cp: r_c cos(alpha); n: reduction
    ratio z_r / z_s + 1 of Section 2.
    """

    r_s: float
    r_p: float
    r_c: float
    r_cp: float
    n: float


def stage_geometry(joint: PlanetaryGears) -> StageGeometry:
    """Geometry of a stage: base radius = pitch radius x cos(alpha), pitch radius = m z / 2."""
    cos_alpha = math.cos(math.radians(joint.pressure_angle_deg))
    r_c = joint.module_m * (joint.sun_teeth + joint.planet_teeth) / 2
    return StageGeometry(
        r_s=joint.module_m * joint.sun_teeth / 2 * cos_alpha,
        r_p=joint.module_m * joint.planet_teeth / 2 * cos_alpha,
        r_c=r_c,
        r_cp=r_c * cos_alpha,
        n=joint.ring_teeth / joint.sun_teeth + 1,
    )


def mesh_displacements(
    theta_s: Any, theta_p: Any, theta_c: Any, r_s: Any, r_p: Any, r_cp: Any
) -> tuple[Any, Any]:
    """(x_sp, x_pr) [m] from gear angles [rad] relative to the ring's body, Eqs. 2-3.

    theta_p counts positive against the carrier. Numbers, arrays or symbols.
    """
    x_s, x_p, x_c = r_s * theta_s, r_p * theta_p, r_cp * theta_c
    return x_s - x_p - x_c, x_p - x_c


def gear_angles(
    x_sp: Any, x_pr: Any, theta_c: Any, r_s: Any, r_p: Any, r_cp: Any
) -> tuple[Any, Any]:
    """(theta_s, theta_p) [rad] from mesh displacements [m]: Eqs. 2-3 solved."""
    theta_p = (x_pr + r_cp * theta_c) / r_p
    theta_s = (x_sp + x_pr + 2 * r_cp * theta_c) / r_s
    return theta_s, theta_p

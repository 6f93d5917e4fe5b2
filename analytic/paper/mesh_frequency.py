"""Meshing frequencies and phases, Eqs. 9-13."""

from __future__ import annotations

import numpy as np

from crosscheck.analytic.paper.kinematics import StageGeometry
from crosscheck.models.arm.gears import PlanetaryGears

ANGLE, OMEGA_T = 0, 1


def meshing_frequency(omega_gear: float, omega_carrier: float, teeth: int) -> float:
    """Eq. 10 (Eq. 9 for a fixed carrier): teeth per time [rad/s] of a gear passing the mesh."""
    return (omega_gear - omega_carrier) * teeth


def sun_mesh_frequency(
    x_sp_dot: float, x_pr_dot: float, theta_c_dot: float, geometry: StageGeometry, z_s: int
) -> float:
    """Eq. 11 [rad/s]: with the mesh displacement rates [m/s] not yet neglected."""
    rolling = x_sp_dot + x_pr_dot + 2 * theta_c_dot * geometry.r_cp
    return (rolling / geometry.r_s - theta_c_dot) * z_s


def sun_mesh_rate(joint: PlanetaryGears, geometry: StageGeometry) -> float:
    """Eq. 12 over theta_c': mesh cycles, in radians, per radian of carrier rotation."""
    return joint.sun_teeth * (2 * geometry.r_cp / geometry.r_s - 1)


def ring_mesh_rate(joint: PlanetaryGears, geometry: StageGeometry, ring_rate: str) -> float:
    """Eq. 13 over theta_c' as printed (``eq13``), or ``corrected``.

    Eq. 10 takes frequencies relative to the carrier, and theta_p counts positive against it, so the
    planet's relative rate is theta_p' + theta_c': the sign that Eq. 13 loses.
    """
    sign = -1 if ring_rate == "eq13" else 1
    return joint.planet_teeth * (geometry.r_cp / geometry.r_p + sign)


def mesh_phase(
    law: int,
    rate: np.ndarray | float,
    offset: np.ndarray | float,
    t: np.ndarray | float,
    theta: np.ndarray | float,
    theta_dot: np.ndarray | float,
) -> np.ndarray:
    """phi [rad]: the argument of the sines of Eqs. 8 and 14.

    OMEGA_T as the paper has it, current frequency times time; ANGLE its integral.
    """
    angle = np.multiply(theta_dot, t) if law == OMEGA_T else theta
    return np.multiply(rate, angle) + offset

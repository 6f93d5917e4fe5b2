"""Meshing frequencies and phases, Eqs. 9-13; constants of phases, given or from the teeth.

After Parker and Lin (2004) a mesh of planet n lags behind that of the first by gamma [cycles]: the
tooth that has left the first planet's mesh comes to planet n's after the angle psi_n =
2 pi (n - 1) / N of the carrier.
"""

from __future__ import annotations

import math

import numpy as np

from crosscheck.analytic.paper.kinematics import StageGeometry
from crosscheck.models.arm.gears import PlanetaryGears, PlanetaryStage

ANGLE, OMEGA_T = 0, 1
TURN = 2 * math.pi


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


def sun_lag(joint: PlanetaryGears, planet: int) -> float:
    """Lag gamma_sn = z_s psi_n / 2 pi [cycles] of a planet's sun mesh; planet counted from 0."""
    return joint.sun_teeth * planet / joint.planet_count


def ring_lag(joint: PlanetaryGears, planet: int) -> float:
    """Lag gamma_rn = -z_r psi_n / 2 pi [cycles] of a planet's ring mesh.

    Modulo 1 it is that of the sun mesh: the planets can be assembled.
    """
    return -joint.ring_teeth * planet / joint.planet_count


def ring_behind_sun(joint: PlanetaryGears) -> float:
    """Lag gamma_rs [cycles] between a planet's two meshes, its teeth as thick as their gaps.

    Its flanks that carry at sun and ring are half its teeth and half a tooth apart.
    """
    return 0.0 if joint.planet_teeth % 2 else 0.5


def mesh_phases(joint: PlanetaryStage, planet: int) -> tuple[float, float]:
    """Constants [rad] of the phases of a planet's meshes with sun and ring, planet from 0.

    Where the teeth say them, the ring mesh follows what is given of the first planet's sun mesh.
    """
    sun, ring = joint.sun_mesh.planet_mesh(planet).phase_rad, joint.ring_mesh.planet_mesh(planet)
    first = joint.sun_mesh.planet_mesh(0).phase_rad
    of_sun = sun if sun is not None else _phase(sun_lag(joint, planet))
    if ring.phase_rad is not None:
        return of_sun, ring.phase_rad
    return of_sun, (first or 0.0) + _phase(ring_lag(joint, planet) + ring_behind_sun(joint))


def _phase(lag: float) -> float:
    """Phase [rad], from 0 to a turn, of a mesh that lags so many cycles."""
    return TURN * (-lag % 1.0)

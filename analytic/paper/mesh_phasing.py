"""Phases of a stage's meshes, given or from the teeth (Parker and Lin 2004).

A mesh of planet n lags behind that of the first by gamma [cycles]: the tooth that has left the
first planet's mesh comes to planet n's after the angle psi_n = 2 pi (n - 1) / N of the carrier.
"""

from __future__ import annotations

import math

from crosscheck.models.arm.gears import PlanetaryGears, PlanetaryStage

TURN = 2 * math.pi


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

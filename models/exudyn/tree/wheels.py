"""Radii and inertias of a stage's wheels, out of the numbers of its gears."""

from __future__ import annotations

from typing import Literal

import numpy as np

from crosscheck.models.arm.gears import PlanetaryGears

Gear = Literal["sun", "planet"]


def base_radius(joint: PlanetaryGears, teeth: int) -> float:
    """Radius [m] of the circle the involutes of a wheel with this many teeth unwind from."""
    return joint.module_m * teeth / 2 * float(np.cos(np.radians(joint.pressure_angle_deg)))


def inertia(joint: PlanetaryGears, gear: Gear) -> float:
    """J [kg m^2] of a gear, as given or M r^2."""
    mass, given, radius = _gear(joint, gear)
    if given is not None:
        return given
    assert mass is not None
    return mass * radius**2


def equivalent_mass(joint: PlanetaryGears, gear: Gear) -> float:
    """M [kg] of a gear, as given or J / r^2."""
    mass, given, radius = _gear(joint, gear)
    if mass is not None:
        return mass
    assert given is not None
    return given / radius**2


def _gear(joint: PlanetaryGears, gear: Gear) -> tuple[float | None, float | None, float]:
    """M or J, whichever is given, and r [m]."""
    radius = base_radius(joint, joint.sun_teeth if gear == "sun" else joint.planet_teeth)
    mass = getattr(joint, f"{gear}_equivalent_mass_kg")
    return mass, getattr(joint, f"{gear}_inertia_kg_m2"), radius

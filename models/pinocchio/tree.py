"""Suns and planets as bodies of a tree in Pinocchio, without masses: what they turn, and spin."""

from __future__ import annotations

from math import cos, pi, radians, sin
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from crosscheck.models.arm.gears import PlanetaryGears

AXIS = np.array([0.0, 0.0, 1.0])  # about which Pinocchio has a joint of its own


class TreeStage(NamedTuple):
    """Bodies of one joint in the tree, 0 the base; ``driven`` is the sun."""

    previous: int
    link: int
    planets: tuple[int, ...]
    driven: int


def sun_turns(joint: PlanetaryGears) -> float:
    """Turns of the sun in the ring's body per turn of the link, on rolling gears."""
    return 1 + joint.ring_teeth / joint.sun_teeth


def planet_turns(joint: PlanetaryGears) -> float:
    """Turns of a planet in its carrier per turn of the link, on rolling gears."""
    return -joint.ring_teeth / joint.planet_teeth


def base_radii(joint: PlanetaryGears) -> tuple[float, float, float]:
    """Base radii [m] of sun, planet and ring."""
    half = joint.module_m / 2 * cos(radians(joint.pressure_angle_deg))
    return half * joint.sun_teeth, half * joint.planet_teeth, half * joint.ring_teeth


def add_wheels(
    tree: pin.Model, gears: PlanetaryGears, link: int, axis: np.ndarray, out: np.ndarray
) -> TreeStage:
    """Add planets and sun of the joint that turns a link, without masses.

    axis: the joint's, and out, across it towards the first planet, in the link's frame.
    """
    (sun_inertia, planet_inertia), radius = spin_inertias(gears), carrier_radius(gears)
    planets = []
    for turn in range(gears.planet_count):
        angle = 2 * pi * turn / gears.planet_count
        seat = radius * (cos(angle) * out + sin(angle) * np.cross(axis, out))
        name, at = f"planet_{link}_{turn + 1}", pin.SE3(np.eye(3), seat)
        planets.append(add_spinning_body(tree, link, at, axis, planet_inertia, name))
    parent, placement = tree.parents[link], tree.jointPlacements[link]
    sun = add_spinning_body(tree, parent, placement, axis, sun_inertia, f"sun_{link}")
    return TreeStage(parent, link, tuple(planets), sun)


def add_spinning_body(
    tree: pin.Model, parent: int, placement: pin.SE3, axis: np.ndarray, inertia: float, name: str
) -> int:
    """Add a joint whose body has inertia about its axis alone; returns the joint."""
    about_z = np.array_equal(axis, AXIS)
    joint = pin.JointModelRZ() if about_z else pin.JointModelRevoluteUnaligned(axis)
    body: int = tree.addJoint(parent, joint, placement, name)
    spinning = pin.Inertia(0.0, np.zeros(3), inertia * np.outer(axis, axis))
    tree.appendBodyToJoint(body, spinning, pin.SE3.Identity())
    return body


def carrier_radius(gears: PlanetaryGears) -> float:
    """Distance [m] of the planets' axes from the sun's."""
    return gears.module_m * (gears.sun_teeth + gears.planet_teeth) / 2


def spin_inertias(gears: PlanetaryGears) -> tuple[float, float]:
    """Inertias of sun and one planet [kg m^2], each given or M r^2 of equivalent mass M."""
    r_s, r_p, _ = base_radii(gears)
    return (
        resolve_inertia_form(gears.sun_inertia_kg_m2, gears.sun_equivalent_mass_kg, r_s**2),
        resolve_inertia_form(gears.planet_inertia_kg_m2, gears.planet_equivalent_mass_kg, r_p**2),
    )


def reflected_inertia(gears: PlanetaryGears) -> float:
    """Inertia [kg m^2] that spinning sun and planets add to their carrier on a standing ring."""
    sun_inertia, planet_inertia = spin_inertias(gears)
    spun = planet_inertia * (1 + planet_turns(gears)) ** 2
    return sun_inertia * sun_turns(gears) ** 2 + gears.planet_count * spun


def equivalent_masses(joint: PlanetaryGears) -> tuple[float, float]:
    """Equivalent masses M = J / r^2 [kg] of the sun and of one planet."""
    r_s, r_p, _ = base_radii(joint)
    return (
        resolve_inertia_form(joint.sun_equivalent_mass_kg, joint.sun_inertia_kg_m2, 1 / r_s**2),
        resolve_inertia_form(
            joint.planet_equivalent_mass_kg, joint.planet_inertia_kg_m2, 1 / r_p**2
        ),
    )


def resolve_inertia_form(given: float | None, other: float | None, factor: float) -> float:
    """Moment of inertia or equivalent mass, converted from the other if the file states that."""
    if given is not None:
        return given
    assert other is not None  # the arm has one of them
    return other * factor

"""The bodies of the geared arm in Pinocchio: links, suns and planets, without meshes or gravity.

The tree's own joint angles (link relative to link, planet relative to its carrier, sun relative to
the previous link) are mapped linearly to those of a layout (Eqs. 2, 3, 20).
"""

from __future__ import annotations

from math import cos, pi, radians, sin
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from crosscheck.models.arm.arm import Arm, Direct, Link, Planetary
from crosscheck.models.arm.gears import PlanetaryGears
from crosscheck.models.arm.layout import Layout

AXIS_X, _, AXIS = np.eye(3)  # along a planar link, and about which its joint turns


class TreeStage(NamedTuple):
    """Bodies of one joint in the tree; 0 is the base. Body b turns by tree coordinate b - 1.

    ``driven`` is the body that the motor turns against the previous one: the sun or, without gears,
    the link itself.
    """

    previous: int
    link: int
    planets: tuple[int, ...]
    driven: int


def build_links(arm: Arm) -> pin.Model:
    """The links of an arm, body i turned by joint i, and its payload, without gravity."""
    tree = pin.Model()
    tree.gravity.linear = np.zeros(3)
    reach = 0.0
    for number, link in enumerate(arm.links, 1):
        add_body(tree, number - 1, (reach, 0.0), f"link_{number}")
        attach(tree, number, *mass_and_inertia(link), link.com_m)
        reach = link.length_m
    attach(tree, len(arm.links), arm.payload_mass_kg, 0.0, reach)
    return tree


def build_tree(arm: Arm) -> tuple[pin.Model, list[TreeStage]]:
    """The tree without gravity, and every joint's bodies in it, from the base to the tip.

    All links come first, then each joint's gears from the tip inwards: in this order every subtree
    is complete before the next begins (depth-first).
    """
    tree = build_links(arm)
    stages = []
    for link, joint in reversed(list(enumerate(arm.joints, 1))):
        if isinstance(joint, Planetary):
            stages.append(_add_joint(tree, joint, link))
        else:
            attach_motor(tree, link, joint)
            stages.append(TreeStage(link - 1, link, (), link))
    return tree, stages[::-1]


def map_to_tree(arm: Arm, stages: list[TreeStage], layout: Layout) -> np.ndarray:
    """Matrix from a layout's coordinates to the tree's angles, shape (angles, coordinates).

    The sun turns by theta_s; the planet, by -theta_p in the previous body, turns by -theta_p -
    theta in its carrier. Eqs. 2 and 3 give r_p theta_p = x_pr + r_cp theta and r_s theta_s =
    x_sp + x_pr + 2 r_cp theta, with r_cp = r_s + r_p; ratios of radii are those of tooth numbers.
    There is one sun: by whichever planet it is reckoned, x_sp + x_pr is the same.
    """
    matrix = np.zeros((sum(len({s.link, s.driven, *s.planets}) for s in stages), len(layout)))
    for i, (joint, stage) in enumerate(zip(arm.joints, stages, strict=True)):
        theta = layout.at("theta", i)
        matrix[stage.link - 1, theta] = 1
        if isinstance(joint, Direct):
            continue
        r_s, r_p, _ = base_radii(joint)
        advance = layout.displacement("x_sp", i, 0) + layout.displacement("x_pr", i, 0)
        matrix[stage.driven - 1] = advance / r_s
        matrix[stage.driven - 1, theta] = sun_turns(joint)
        for number, planet in enumerate(stage.planets):
            matrix[planet - 1] = -layout.displacement("x_pr", i, number) / r_p
            matrix[planet - 1, theta] = planet_turns(joint)
    return matrix


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


def _add_joint(tree: pin.Model, joint: Planetary, link: int) -> TreeStage:
    """Add carrier, planets, ring and sun of the joint that turns a link."""
    attach(tree, link, joint.carrier_mass_kg, carrier_inertia(joint))
    attach_to_previous(tree, link, joint.ring_mass_kg, joint.ring_inertia_kg_m2)
    stage = add_wheels(tree, joint, link)
    for planet in stage.planets:
        attach(tree, planet, joint.planet_mass_kg, 0.0)
    attach(tree, stage.driven, joint.sun_mass_kg, 0.0)
    return stage


def add_wheels(
    tree: pin.Model,
    gears: PlanetaryGears,
    link: int,
    axis: np.ndarray = AXIS,
    out: np.ndarray = AXIS_X,
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


def carrier_inertia(joint: Planetary) -> float:
    """Inertia of the carrier [kg m^2], given or M r^2 of its equivalent mass M."""
    given, mass = joint.carrier_inertia_kg_m2, joint.carrier_equivalent_mass_kg
    r_s, r_p, _ = base_radii(joint)
    return resolve_inertia_form(given, mass, (r_s + r_p) ** 2)


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


def mass_and_inertia(link: Link) -> tuple[float, float]:
    """Mass [kg] of a link, and inertia about its centre of mass [kg m^2]; a rod is slender."""
    if link.mass_kg is not None and link.inertia_kg_m2 is not None:
        return link.mass_kg, link.inertia_kg_m2
    assert link.density_kg_per_m3 is not None
    assert link.cross_section_m2 is not None
    mass = link.density_kg_per_m3 * link.cross_section_m2 * link.length_m
    return mass, mass * link.length_m**2 / 12


def add_body(tree: pin.Model, parent: int, place: tuple[float, float], name: str) -> int:
    """Add a body that turns about z at (x, y) [m] of its parent; returns its number."""
    placement = pin.SE3(np.eye(3), np.array([*place, 0.0]))
    return tree.addJoint(parent, pin.JointModelRZ(), placement, name)


def attach(tree: pin.Model, body: int, mass: float, inertia: float, x: float = 0.0) -> None:
    """Add mass [kg] at x [m] along a body, with inertia [kg m^2] about z there.

    In the plane only the inertia about z matters.
    """
    added = pin.Inertia(mass, np.array([x, 0.0, 0.0]), np.diag([0.0, 0.0, inertia]))
    tree.appendBodyToJoint(body, added, pin.SE3.Identity())


def attach_to_previous(tree: pin.Model, link: int, mass: float, inertia: float) -> None:
    """Add mass [kg] and inertia [kg m^2] to the body before a link, where that one's joint is."""
    place = tree.jointPlacements[link].translation[0]
    attach(tree, tree.parents[link], mass, inertia, place)


def attach_motor(tree: pin.Model, link: int, joint: Direct) -> None:
    """Add the motor's mass to the end of the body before a link, its rotor to the link."""
    attach(tree, link, 0.0, joint.rotor_inertia_kg_m2)
    attach_to_previous(tree, link, joint.motor_mass_kg, 0.0)

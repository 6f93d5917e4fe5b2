"""The Exudyn tree's bodies, and its coordinates as linear maps of the paper's."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from crosscheck.models.arm.arm import Arm, Link, Planetary
from crosscheck.models.arm.layout import Layout
from crosscheck.models.exudyn.engine import TreePart, make_planar_part
from crosscheck.models.exudyn.tree.laws import base_radius, inertia
from crosscheck.models.exudyn.tree.mesh import StageCoordinates

# [kg] For a body without mass, whose inertia may still count: the engine divides by a body's mass.
# No sum with a number of an arm notices so little.
NO_MASS = 1e-200
PartOfBody = tuple[float, float, float]  # mass [kg], place [m], inertia about its own com [kg m^2]


def build_stages(arm: Arm) -> list[StageCoordinates]:
    """Places of every joint's bodies, counted joint by joint: link, then any sun and planets."""
    stages, first = [], 0
    for joint in arm.joints:
        driven = first + isinstance(joint, Planetary)
        stage = StageCoordinates(
            first, driven, tuple(range(driven + 1, driven + 1 + joint.planet_count))
        )
        stages.append(stage)
        first = stage.end
    return stages


def build_bodies(arm: Arm) -> list[TreePart]:
    """Every body of the arm in the order of the tree coordinates."""
    bodies, parent, axis = [], -1, (0.0, 0.0)
    for place, (stage, joint) in enumerate(zip(build_stages(arm), arm.joints, strict=True)):
        bodies.append(make_planar_part(parent, axis, *_composite(_link_parts(arm, place))))
        if isinstance(joint, Planetary):
            mass = joint.sun_mass_kg or NO_MASS
            bodies.append(make_planar_part(parent, axis, mass, 0.0, inertia(joint, "sun")))
            bodies += _planets(joint, stage.link)
        parent, axis = stage.link, (arm.links[place].length_m, 0.0)
    return bodies


def _composite(parts: Sequence[PartOfBody]) -> PartOfBody:
    """Mass, com and inertia about it of rigidly joined parts."""
    mass, x, inertias = np.array(parts).T
    com = mass @ x / mass.sum()
    return float(mass.sum()), float(com), float(inertias.sum() + mass @ (x - com) ** 2)


def _link_parts(arm: Arm, place: int) -> list[PartOfBody]:
    """Parts of a link's body: the link, what its joint fixes to it, what its far end carries."""
    joint = arm.joints[place]
    if isinstance(joint, Planetary):
        turned = (joint.carrier_mass_kg, 0.0, inertia(joint, "carrier"))
    else:
        turned = (0.0, 0.0, joint.rotor_inertia_kg_m2)
    return [_link(arm.links[place]), turned, _far_end(arm, place)]


def _link(link: Link) -> PartOfBody:
    if link.mass_kg is not None and link.inertia_kg_m2 is not None:
        return link.mass_kg, link.com_m, link.inertia_kg_m2
    assert link.density_kg_per_m3 is not None
    assert link.cross_section_m2 is not None
    rod = link.density_kg_per_m3 * link.cross_section_m2 * link.length_m
    return rod, link.com_m, rod * link.length_m**2 / 12


def _far_end(arm: Arm, place: int) -> PartOfBody:
    """Part at a link's far end: ring or motor of the next joint, or the payload."""
    at = arm.links[place].length_m
    if place + 1 == len(arm.joints):
        return arm.payload_mass_kg, at, 0.0
    outer = arm.joints[place + 1]
    if isinstance(outer, Planetary):
        return outer.ring_mass_kg, at, outer.ring_inertia_kg_m2
    return outer.motor_mass_kg, at, 0.0


def _planets(joint: Planetary, carrier: int) -> list[TreePart]:
    radius = joint.module_m * (joint.sun_teeth + joint.planet_teeth) / 2
    planet_inertia = inertia(joint, "planet")
    angles = 2 * np.pi * np.arange(joint.planet_count) / joint.planet_count
    mass = joint.planet_mass_kg or NO_MASS
    return [
        make_planar_part(
            carrier, (radius * np.cos(a), radius * np.sin(a)), mass, 0.0, planet_inertia
        )
        for a in angles
    ]


def tree_from_paper(arm: Arm, layout: Layout) -> np.ndarray:
    """Matrix A that gives tree coordinates by the paper's, shape (bodies, n).

    From x_sp = r_s (sun - link) + r_p planet and x_pr = -r_r link - r_p planet. The paper's planet
    angle, counted against the carrier, is -(link + planet) here. Lumped planets are all alike.
    """
    stages = build_stages(arm)
    matrix = np.zeros((stages[-1].end, len(layout)))
    for place, (stage, joint) in enumerate(zip(stages, arm.joints, strict=True)):
        theta = layout.at("theta", place)
        matrix[stage.link, theta] = 1
        if isinstance(joint, Planetary):
            sun, planet, ring = _radii(joint)
            advance = layout.displacement("x_sp", place, 0) + layout.displacement("x_pr", place, 0)
            matrix[stage.driven] = advance / sun
            matrix[stage.driven, theta] = (sun + ring) / sun
            for number, body in enumerate(stage.planets):
                matrix[body] = -layout.displacement("x_pr", place, number) / planet
                matrix[body, theta] = -ring / planet
    return matrix


def paper_from_tree(arm: Arm, layout: Layout) -> np.ndarray:
    """Matrix that gives the paper's coordinates by the tree's, (n, bodies); lumped: by the mean."""
    stages = build_stages(arm)
    matrix = np.zeros((len(layout), stages[-1].end))
    for place, (stage, joint) in enumerate(zip(stages, arm.joints, strict=True)):
        matrix[layout.at("theta", place), stage.link] = 1
        if isinstance(joint, Planetary):
            sun, planet, ring = _radii(joint)
            planets = list(stage.planets)
            if layout.free:  # in x_s = x_sp + x_pr the planet's turn is gone
                turned = [stage.driven, stage.link]
                matrix[layout.at("x_s", place), turned] = sun, -(sun + ring)
                for number, body in enumerate(planets):
                    row = layout.at("x_pr", place, number)
                    matrix[row, [stage.link, body]] = -ring, -planet
            else:
                x_sp, x_pr = layout.at("x_sp", place), layout.at("x_pr", place)
                matrix[x_sp, [stage.driven, stage.link]] = sun, -sun
                matrix[x_sp, planets] = planet / joint.planet_count
                matrix[x_pr, stage.link] = -ring
                matrix[x_pr, planets] = -planet / joint.planet_count
    return matrix


def _radii(joint: Planetary) -> tuple[float, float, float]:
    """Base radii of sun, planet and ring [m]."""
    sun, planet, ring = (
        base_radius(joint, teeth)
        for teeth in (joint.sun_teeth, joint.planet_teeth, joint.ring_teeth)
    )
    return sun, planet, ring

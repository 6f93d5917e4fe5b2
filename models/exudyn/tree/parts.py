"""The Exudyn tree's bodies, and its coordinates as linear maps of the paper's."""

from __future__ import annotations

import numpy as np

from crosscheck.models.arm.arm import Arm, Planetary
from crosscheck.models.arm.layout import Layout
from crosscheck.models.exudyn.engine import TreePart, make_planar_part
from crosscheck.models.exudyn.tree.mesh import StageCoordinates
from crosscheck.models.exudyn.tree.wheels import base_radius, inertia
from crosscheck.models.robot.robot import BASE, Robot

# [kg] For suns and planets, whose masses the links have: the engine divides by a body's mass.
# No sum with a number of an arm notices so little.
NO_MASS = 1e-200


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


def build_bodies(arm: Arm, robot: Robot) -> list[TreePart]:
    """Every body of an arm in the order of the tree coordinates; robot: that the arm is.

    Suns and planets have their inertia about their own axes, and the links all masses.
    """
    bodies: list[TreePart] = []
    stages = build_stages(arm)
    links = [stage.link for stage in stages]
    joints = zip(stages, arm.joints, robot.joints, robot.bodies, strict=True)
    for stage, joint, moving, body in joints:
        parent = BASE if moving.parent == BASE else links[moving.parent]
        x, y, _ = moving.placement.position
        link = body.mass or NO_MASS, body.com[0], body.inertia[2, 2]
        bodies.append(make_planar_part(parent, (x, y), *link))
        if isinstance(joint, Planetary):
            sun, planet = inertia(joint, "sun"), inertia(joint, "planet")
            bodies.append(make_planar_part(parent, (x, y), NO_MASS, 0.0, sun))
            seated = make_planar_part(stage.link, (0.0, 0.0), NO_MASS, 0.0, planet)
            bodies += [seated] * joint.planet_count
    return bodies


def tree_from_paper(arm: Arm, layout: Layout) -> np.ndarray:
    """Matrix A that gives tree coordinates by the paper's, shape (bodies, n).

    From x_sp = r_s (sun - link) + r_p planet and x_pr = -r_r link - r_p planet. The paper's planet
    angle, counted against the carrier, is -(link + planet) here. Lumped planets are all equal.
    """
    stages = build_stages(arm)
    matrix = np.zeros((stages[-1].end, len(layout)))
    for place, (stage, joint) in enumerate(zip(stages, arm.joints, strict=True)):
        theta = layout.at("theta", place)
        matrix[stage.link, theta] = 1
        if isinstance(joint, Planetary):
            wheels = joint.sun_teeth, joint.planet_teeth, joint.ring_teeth
            sun, planet, ring = (base_radius(joint, teeth) for teeth in wheels)
            advance = layout.displacement("x_sp", place, 0) + layout.displacement("x_pr", place, 0)
            matrix[stage.driven] = advance / sun
            matrix[stage.driven, theta] = (sun + ring) / sun
            for number, body in enumerate(stage.planets):
                matrix[body] = -layout.displacement("x_pr", place, number) / planet
                matrix[body, theta] = -ring / planet
    return matrix

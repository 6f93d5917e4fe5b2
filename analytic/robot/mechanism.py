"""A robot at a level as the algorithms take it: a tree whose numbers are floats, 0, 1 and -1.

Whole numbers are structure and floats are arguments. Entries of rotations and axes that are 0, 1 or
-1 but for rounding are these. A joint's oblique axis is made the z axis of its frame.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from crosscheck.analytic.derivation.stage import gear_masses
from crosscheck.analytic.paper.kinematics import stage_geometry
from crosscheck.analytic.robot.algorithms import (
    BASE,
    Matrix,
    Mechanism,
    TreeJoint,
    TreeLink,
    TreeRotor,
    Vector,
)
from crosscheck.models.robot.robot import WITH_ROTORS, JointStage, Level, Robot, Rotor

ROUNDING = 4 * np.finfo(float).eps  # error of cosines and sines of right angles, and their products


def build_mechanism(robot: Robot, level: Level) -> Mechanism:
    """The mechanism of a robot at a level."""
    frames = [_axis_frame(joint.axis) for joint in robot.joints]
    free = robot.coordinates
    joints = []
    for number, joint in enumerate(robot.joints):
        under = np.eye(3) if joint.parent == BASE else frames[joint.parent]
        leader = number if joint.mimic is None else joint.mimic.joint
        joints.append(
            TreeJoint(
                parent=joint.parent,
                slides=joint.kind == "prismatic",
                rotation=_matrix(under.T @ joint.placement.rotation @ frames[number]),
                position=_vector(under.T @ joint.placement.position),
                axis=_direction(frames[number].T @ joint.axis),
                coordinate=free.index(leader),
                factor=1 if joint.mimic is None else joint.mimic.multiplier,
                offset=0 if joint.mimic is None else joint.mimic.offset,
                friction=float(joint.friction) if joint.friction else 0,
                armature=float(joint.armature) if joint.armature and level != "links" else 0,
            )
        )
    bodies = []
    for body, frame in zip(robot.bodies, frames, strict=True):
        inertia = (frame.T @ body.inertia @ frame)[np.triu_indices(3)]
        com = _vector(frame.T @ body.com)
        bodies.append(TreeLink(float(body.mass), com, _numbers(inertia)))
    rotors = list(_rotors(robot, level, frames)) if level != "links" else []
    gravity = _vector(robot.gravity)
    parts = tuple(joints), tuple(bodies), tuple(rotors)
    return Mechanism(*parts, gravity, len(free), level in WITH_ROTORS)


def _rotors(robot: Robot, level: Level, frames: Sequence[np.ndarray]) -> list[TreeRotor]:
    """Rotors, then sun and planets of every stage; on meshes at the level geared."""
    meshes = robot.mesh_coordinates if level == "geared" else 0
    rotors, place, free = [], 0, len(robot.coordinates)
    for rotor in robot.rotors:
        if meshes and rotor.mesh:
            turns, levers = np.zeros((2, meshes))
            turns[place] = 1 / rotor.mesh.pinion_base_radius_m
            levers[place] = rotor.mesh.pinion_base_radius_m
            place += 1
            rotors.append(_rotor(robot, rotor, frames, turns, levers))
        else:
            rotors.append(_rotor(robot, rotor, frames))
    for stage, columns in zip(robot.stages, robot.stage_columns, strict=True):
        behind_joints = slice(columns.start - free, columns.stop - free)
        rotors += _stage_rotors(robot, stage, frames, meshes, behind_joints)
    return rotors


def _rotor(
    robot: Robot, rotor: Rotor, frames: Sequence[np.ndarray], *elastic: np.ndarray
) -> TreeRotor:
    frame = robot.frames[rotor.stator]
    axis = _turned_axis(frame.placement.rotation @ rotor.axis, frame.body, frames)
    rigid = TreeRotor(frame.body, axis, float(rotor.inertia), rotor.joint, float(rotor.ratio))
    if not elastic:
        return rigid
    is_driven = robot.joints[rotor.joint].mimic is None
    turns, levers = map(_numbers, elastic)
    return rigid._replace(turns=turns, levers=levers, motor=1 / rotor.ratio if is_driven else 0)


def _stage_rotors(
    robot: Robot, stage: JointStage, frames: Sequence[np.ndarray], meshes: int, columns: slice
) -> list[TreeRotor]:
    """Sun and planets of a stage on the link of its ring, by Eqs. 2 and 3 of the paper.

    y_s = (x_sp + x_pr) / r_s, y_p = -x_pr / r_p; columns: of the stage's coordinates.
    """
    gears, joint = stage.gears, robot.joints[stage.joint]
    geometry, (sun_mass, planet_mass) = stage_geometry(gears), gear_masses(gears)
    r_s, r_p, r_cp = geometry.r_s, geometry.r_p, geometry.r_cp
    axis = _turned_axis(joint.placement.rotation @ joint.axis, joint.parent, frames)
    planets = gears.planet_count * planet_mass * r_p**2 / len(stage.groups)
    sun = TreeRotor(joint.parent, axis, sun_mass * r_s**2, stage.joint, 2 * r_cp / r_s)
    planet = TreeRotor(joint.parent, axis, planets, stage.joint, -r_cp / r_p)
    if not meshes:
        return [sun, *[planet] * len(stage.groups)]
    turns, levers = np.zeros((2, 1 + len(stage.groups), meshes))
    if stage.has_free_planets:  # x_s = r_s y_s, x_pr = -r_p y_p
        np.fill_diagonal(turns[:, columns], [1 / r_s, *[-1 / r_p] * len(stage.groups)])
        np.fill_diagonal(levers[:, columns], [r_s, *[-r_p] * len(stage.groups)])
    else:
        turns[0, columns], turns[1, columns] = (1 / r_s, 1 / r_s), (0.0, -1 / r_p)
        levers[0, columns], levers[1, columns] = (r_s, 0.0), (r_p, -r_p)
    motor = 1 / geometry.n if joint.mimic is None else 0
    sun = sun._replace(motor=motor)
    return [
        rotor._replace(turns=_numbers(turned), levers=_numbers(lever))
        for rotor, turned, lever in zip(
            [sun, *[planet] * len(stage.groups)], turns, levers, strict=True
        )
    ]


def _axis_frame(axis: np.ndarray) -> np.ndarray:
    """A rotation by which an axis is one of the frame's: none where it is already."""
    if np.count_nonzero(_direction(axis)) == 1:
        return np.eye(3)
    x = np.cross(np.eye(3)[np.argmin(np.abs(axis))], axis)
    x /= np.linalg.norm(x)
    return np.column_stack([x, np.cross(axis, x), axis])


def _turned_axis(axis: np.ndarray, body: int, frames: Sequence[np.ndarray]) -> Vector:
    """An axis in a body's frame as one in its turned frame."""
    return _direction(axis if body == BASE else frames[body].T @ axis)


def _direction(values: np.ndarray) -> Vector:
    """Components of a direction: 0, 1 and -1 are structure."""
    whole = np.round(values)
    near = np.abs(values - whole) < ROUNDING
    x, y, z = (int(w) if n else float(v) for v, w, n in zip(values, whole, near, strict=True))
    return x, y, z


def _matrix(values: np.ndarray) -> Matrix:
    x, y, z = map(_direction, values)
    return x, y, z


def _numbers(values: np.ndarray) -> tuple[Any, ...]:
    """Numbers, of which zeros are structure."""
    return tuple(float(value) if value else 0 for value in values)


def _vector(values: np.ndarray) -> Vector:
    x, y, z = _numbers(values)
    return x, y, z


def name_numbers(mechanism: Mechanism) -> tuple[Mechanism, dict[str, float]]:
    """The mechanism with a name in place of every float, and the floats by name."""
    numbers: dict[str, float] = {}

    def named(value: Any, name: str) -> Any:
        if isinstance(value, float):
            numbers[name] = value
            return name
        if isinstance(value, tuple):
            fields = getattr(value, "_fields", range(len(value)))
            parts = (
                named(v, f"{name}_{f}" if name else f) for v, f in zip(value, fields, strict=True)
            )
            return type(value)(*parts) if hasattr(value, "_fields") else tuple(parts)
        return value

    return named(mechanism, ""), numbers


def replace_names(mechanism: Mechanism, values: Any) -> Mechanism:
    """The mechanism with values(name) in place of every name."""

    def replaced(value: Any) -> Any:
        if isinstance(value, str):
            return values(value)
        if isinstance(value, tuple):
            parts = map(replaced, value)
            return type(value)(*parts) if hasattr(value, "_fields") else tuple(parts)
        return value

    return replaced(mechanism)

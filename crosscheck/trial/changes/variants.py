"""Many robots at the same states, their numbers side by side: by which changes are screened.

The recursions of Newton and Euler and of composite bodies take numbers of any kind, so that one
that may differ among the robots is an array (robots, 1), and a coordinate one (robots, states).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from crosscheck.analytic.robot.algorithms import (
    Mechanism,
    MovingTree,
    TreeJoint,
    TreeLink,
    TreeRotor,
)
from crosscheck.analytic.robot.model import multiply
from crosscheck.models.robot.robot import WITH_ROTORS, Level, Robot, Rotor
from crosscheck.trial.changes.kane import list_spinners
from crosscheck.trial.changes.problem import DynamicsTerms

MOST_ROBOTS = 1000  # side by side
ROUNDING = 1e-12  # of the length of a unit vector


def compute_variants(
    robots: Sequence[Robot], level: Level, q: np.ndarray, v: np.ndarray
) -> DynamicsTerms:
    """The terms (robots, states, ...) of robots at q, v (states, n)."""
    states, size = q.shape
    terms = DynamicsTerms(
        np.zeros((len(robots), states, size, size)), *np.zeros((2, len(robots), states, size))
    )
    groups: dict[Any, list[int]] = {}
    spinners = _list_rotors(robots) if level != "links" else [()] * len(robots)
    for number, (robot, rotors) in enumerate(zip(robots, spinners, strict=True)):
        joints = [
            (each.kind, each.parent, each.mimic and each.mimic.joint) for each in robot.joints
        ]
        places = [(rotor.joint, robot.frames[rotor.stator].body) for rotor in rotors]
        groups.setdefault((*joints, *places), []).append(number)
    for numbers in groups.values():
        for begin in range(0, len(numbers), MOST_ROBOTS):
            some = numbers[begin : begin + MOST_ROBOTS]
            alike, rotors_of_alike = [robots[n] for n in some], [spinners[n] for n in some]
            mechanism = _build_mechanism(alike, rotors_of_alike, level)
            parts = _compute_alike(mechanism, len(some), q, v)
            for whole, part in zip(terms, parts, strict=True):
                whole[some] = part
    return terms


def _list_rotors(robots: Sequence[Robot]) -> list[tuple[Rotor, ...]]:
    """Rotors of robots and of their stages; the same ones of robots that share them."""
    by_parts: dict[tuple[int, ...], tuple[Rotor, ...]] = {}
    result = []
    for robot in robots:
        key = id(robot.rotors), id(robot.stages), id(robot.joints) if robot.stages else 0
        if key not in by_parts:
            by_parts[key] = tuple(each.rotor for each in list_spinners(robot))
        result.append(by_parts[key])
    return result


def _compute_alike(mechanism: Mechanism, count: int, q: np.ndarray, v: np.ndarray) -> DynamicsTerms:
    joints, free = mechanism.joints, q.shape[1]
    values = [joint.factor * q[:, joint.coordinate] + joint.offset for joint in joints]
    tree = MovingTree(mechanism, values, [(np.cos(each), np.sin(each)) for each in values])
    shape = count, len(q)
    mass = np.empty((*shape, free, free))
    for i, row in enumerate(tree.collapse(tree.mass_matrix())):
        for j, entry in enumerate(row):
            mass[:, :, i, j] = entry
    held = []
    for gravity, rate in (((0, 0, 0), 1.0), (mechanism.gravity, 0.0)):
        tree.mechanism = mechanism._replace(gravity=gravity)
        rates = [joint.factor * (rate * v[:, joint.coordinate]) for joint in joints]
        forces = np.zeros((*shape, free))
        for joint, force in zip(joints, tree.bias(rates), strict=True):
            forces[:, :, joint.coordinate] += joint.factor * force
        held.append(forces)
    return DynamicsTerms(mass, *held)


def _build_mechanism(
    robots: Sequence[Robot], spinners: Sequence[Sequence[Rotor]], level: Level
) -> Mechanism:
    """The mechanism of robots with one structure, each joint's axis the z axis of its frame."""
    first, free = robots[0], robots[0].coordinates
    by_joint = [_Column([each.joints[k] for each in robots]) for k in range(len(first.joints))]
    frames = [_make_frames(each.take(lambda joint: joint.axis)) for each in by_joint]
    backs = [frame.swapaxes(1, 2) for frame in (*frames, np.eye(3)[None])]  # the last is BASE's
    joints, bodies, rotors = [], [], []
    for k, joint in enumerate(first.joints):
        column, back = by_joint[k], backs[joint.parent]
        rotation = back @ column.take(lambda joint: joint.placement.rotation) @ frames[k]
        joints.append(
            TreeJoint(
                joint.parent,
                joint.kind == "prismatic",
                _split(rotation),
                _split(multiply(back, column.take(lambda joint: joint.placement.position))),
                (0, 0, _measure_length(column) if joint.kind == "prismatic" else 1),
                free.index(k if joint.mimic is None else joint.mimic.joint),
                _split(column.take(lambda joint: joint.mimic.multiplier if joint.mimic else 1.0)),
                _split(column.take(lambda joint: joint.mimic.offset if joint.mimic else 0.0)),
                armature=joint.armature if level != "links" else 0,
            )
        )
        column = _Column([each.bodies[k] for each in robots])
        (xx, xy, xz), (_, yy, yz), (*_, zz) = _split(
            backs[k] @ column.take(lambda body: body.inertia) @ frames[k]
        )
        com = _split(multiply(backs[k], column.take(lambda body: body.com)))
        mass = _split(column.take(lambda body: body.mass))
        bodies.append(TreeLink(mass, com, (xx, xy, xz, yy, yz, zz)))
    for together in zip(*spinners, strict=True):
        column, rotor = _Column(together), together[0]
        axes = column.take(lambda rotor: first.frames[rotor.stator].placement.rotation @ rotor.axis)
        body = first.frames[rotor.stator].body
        rotors.append(
            TreeRotor(
                body,
                _split(multiply(backs[body], axes)),
                _split(column.take(lambda rotor: rotor.inertia)),
                rotor.joint,
                _split(column.take(lambda rotor: rotor.ratio)),
            )
        )
    gravity = _split(_Column(robots).take(lambda robot: robot.gravity))
    parts = tuple(joints), tuple(bodies), tuple(rotors)
    return Mechanism(*parts, gravity, len(free), level in WITH_ROTORS)


def _measure_length(column: _Column) -> Any:
    """Lengths (robots, 1) of the axes of joints that slide; 1 where all are unit vectors."""
    lengths = np.linalg.norm(column.take(lambda joint: joint.axis), axis=1, keepdims=True)
    return lengths if (np.abs(lengths - 1) > ROUNDING).any() else 1


class _Column:
    """A part of several robots, most of which share it: its numbers are read once of each."""

    def __init__(self, parts: Sequence[Any]) -> None:
        _, first, self._places = np.unique(
            list(map(id, parts)), return_index=True, return_inverse=True
        )
        self._unique = [parts[place] for place in first]

    def take(self, read: Callable[[Any], Any]) -> np.ndarray:
        """A number, vector or matrix of the part (robots, ...)."""
        values: np.ndarray = np.array([read(each) for each in self._unique], float)[self._places]
        return values


def _make_frames(axes: np.ndarray) -> np.ndarray:
    """Rotations (robots, 3, 3) whose third columns are axes (robots, 3)."""
    axes = axes / np.maximum(np.linalg.norm(axes, axis=1, keepdims=True), 1e-300)
    x = np.cross(np.eye(3)[np.abs(axes).argmin(axis=1)], axes)
    x /= np.maximum(np.linalg.norm(x, axis=1, keepdims=True), 1e-300)
    return np.stack([x, np.cross(axes, x), axes], axis=2)


def _split(values: np.ndarray) -> Any:
    """Entries of values (robots, ...) as tuples of arrays (robots, 1)."""
    if values.ndim == 1:
        return values[:, None]
    return tuple(_split(values[:, k]) for k in range(values.shape[1]))

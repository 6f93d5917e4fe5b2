"""Links and joints of a URDF as a tree of bodies: what is fixed to a body is merged into it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from crosscheck.models.errors import InputError
from crosscheck.models.robot.inertias import (
    InertiaDoubt,
    find_inertia_doubts,
    measure_reach,
    remove_dust,
)
from crosscheck.models.robot.robot import (
    BASE,
    Joint,
    LinkFrame,
    Mimic,
    Placement,
    RobotBody,
    compute_point_inertia,
)
from crosscheck.models.robot.urdf import LARGEST_MULTIPLIER, Urdf, UrdfJoint, UrdfLink

MOST_JOINTS = 64
SINGULAR = 1e-12  # eigenvalue of M, scaled to a unit diagonal, that counts as zero
WORLD, WORLD_LINK = "world", '<link name="world"/>'
HOME = Placement(np.eye(3), np.zeros(3))


class Tree(NamedTuple):
    """A robot's moving joints, parents first; their bodies; frames of links; what is doubtful."""

    joints: tuple[Joint, ...]
    bodies: tuple[RobotBody, ...]
    frames: dict[str, LinkFrame]
    doubts: tuple[str, ...]


def build_tree(urdf: Urdf, where: str) -> Tree:
    """The tree of bodies that a URDF's links and joints make.

    Raises InputError for what is no tree, or joints whose mass matrix is singular.
    """
    frames, joints, bodies, doubts = _assemble(urdf, where)
    for doubt in doubts:
        if doubt.is_fatal:
            raise InputError(where, f"link {doubt.link}: inertia", None, doubt.reason)
    children = {joint.name: joint.child for joint in urdf.joints}
    moved_links = [children[joint.name] for joint in joints]
    _require_regular(joints, bodies, moved_links, where)
    notes = [f"link {doubt.link}: {doubt.reason}" for doubt in doubts]
    still = [
        name
        for name, joint, body in zip(moved_links, joints, bodies, strict=True)
        if joint.has_motor and not _is_solid(body)
    ]
    if still:
        notes.append(f"link {', '.join(still)} has no mass and inertia of its own")
    return Tree(joints, bodies, frames, (*notes, *_find_held_root(urdf, frames, joints)))


def survey_inertias(urdf: Urdf, where: str) -> list[InertiaDoubt]:
    """All doubtful inertias of a URDF at once. Raises InputError for what is no tree."""
    return _assemble(urdf, where)[3]


def _assemble(
    urdf: Urdf, where: str
) -> tuple[dict[str, LinkFrame], tuple[Joint, ...], tuple[RobotBody, ...], list[InertiaDoubt]]:
    """Build frames, joints and bodies, and list doubtful ones. Raises InputError."""
    root, below = _find_root(urdf, where)
    frames, moving = _frames(root, below)
    if not 1 <= len(moving) <= MOST_JOINTS:
        allowed = f"must be 1 to {MOST_JOINTS} that move; {len(moving)} do"
        raise InputError(where, "joint", None, allowed)
    bodies = tuple(merge_bodies(number, urdf.links, frames) for number in range(len(moving)))
    numbers = {joint.name: number for number, joint in enumerate(moving)}
    joints = tuple(
        Joint(
            joint.name,
            "prismatic" if joint.kind == "prismatic" else "revolute",
            frames[joint.parent].body,
            compose(frames[joint.parent].placement, joint.placement),
            joint.axis,
            joint.limits,
            _mimic(joint, moving, numbers, where),
            joint.damping,
            joint.armature,
            joint.has_motor,
        )
        for joint in moving
    )
    links = remove_dust(urdf.links, measure_reach(joints, bodies))
    bodies = tuple(merge_bodies(number, links, frames) for number in range(len(moving)))
    return frames, joints, bodies, list(find_inertia_doubts(urdf.links, frames, joints, bodies))


def compose(outer: Placement, inner: Placement) -> Placement:
    """Placement of a frame that is at ``inner`` in a frame that is at ``outer``."""
    position = outer.position + outer.rotation @ inner.position
    return Placement(outer.rotation @ inner.rotation, position)


def _find_root(urdf: Urdf, where: str) -> tuple[str, dict[str, list[UrdfJoint]]]:
    """The root's name, and the joints that stand on each link. Raises InputError."""
    below: dict[str, list[UrdfJoint]] = {link.name: [] for link in urdf.links}
    above: dict[str, str] = {}
    for joint in urdf.joints:
        for end, name in (("parent", joint.parent), ("child", joint.child)):
            if name not in below:
                allowed = "no such link in this file"
                if name == WORLD:
                    allowed += f"; Drake knows it without a link, other programs need {WORLD_LINK}"
                raise InputError(where, f"joint {joint.name}: {end}", name, allowed)
        if joint.child in above:
            allowed = f"is moved by two joints, {above[joint.child]} and {joint.name}; loops cannot"
            raise InputError(where, f"link {joint.child}", None, f"{allowed} be read, only trees")
        above[joint.child] = joint.name
        below[joint.parent].append(joint)
    if not below:
        raise InputError(where, "link", None, "there is none; a robot needs two at least")
    roots = [name for name in below if name not in above]
    if len(roots) != 1:
        named = f"{len(roots)} are: {', '.join(roots)}" if roots else "none is: they form a loop"
        raise InputError(
            where, "link", None, f"one alone must be without a joint that moves it; {named}"
        )
    reached, left = 0, [roots[0]]
    while left:
        reached += 1
        left += [joint.child for joint in below[left.pop()]]
    if reached < len(below):
        allowed = f"{len(below) - reached} cannot be reached from {roots[0]}: they form a loop"
        raise InputError(where, "link", None, allowed)
    return roots[0], below


def _frames(
    root: str, below: dict[str, list[UrdfJoint]]
) -> tuple[dict[str, LinkFrame], list[UrdfJoint]]:
    """Every link's frame, and the moving joints, depth first in the file's order."""
    frames = {root: LinkFrame(BASE, HOME)}
    moving: list[UrdfJoint] = []
    left = below[root][::-1]
    while left:
        joint = left.pop()
        if joint.kind == "fixed":
            parent = frames[joint.parent]
            frame = LinkFrame(parent.body, compose(parent.placement, joint.placement))
        else:
            frame = LinkFrame(len(moving), HOME)
            moving.append(joint)
        frames[joint.child] = frame
        left += below[joint.child][::-1]
    return frames, moving


def merge_bodies(number: int, links: Sequence[UrdfLink], frames: dict[str, LinkFrame]) -> RobotBody:
    """All that a joint carries, merged into one body, in its frame; it may be without mass."""
    parts = []
    for link in links:
        frame = frames[link.name]
        if frame.body == number and link.body is not None:
            turn, body = frame.placement.rotation, link.body
            com = frame.placement.position + turn @ body.com
            parts.append(RobotBody(body.mass, com, turn @ body.inertia @ turn.T))
    mass = sum(part.mass for part in parts)
    com = sum((part.mass * part.com for part in parts), np.zeros(3))
    com = com / mass if mass else com
    inertia = np.zeros((3, 3))
    for part in parts:
        inertia += part.inertia + compute_point_inertia(part.mass, part.com - com)
    return RobotBody(mass, com, inertia)


def _require_regular(
    joints: Sequence[Joint], bodies: Sequence[RobotBody], links: Sequence[str], where: str
) -> None:
    """Raise InputError where M is singular, at a pose that is nothing special.

    So a point mass and a thin rod may be bodies, but not on the axis that turns them alone.
    """
    if not any(map(_is_solid, bodies)):
        allowed = "no link that moves has an inertial: the file has no masses and inertias"
        raise InputError(where, "link", None, allowed)
    root = _root_of_mass_matrix(joints, bodies)
    sizes = np.linalg.norm(root, axis=0)
    free = [number for number, joint in enumerate(joints) if joint.mimic is None]
    light = [number for number, size in zip(free, sizes, strict=True) if size == 0]
    if light:
        number, *others = light
        allowed = f"must have inertia about the axis of joint {joints[number].name}, or mass off it"
        if others:
            allowed += f"; so must link {', '.join(links[other] for other in others)}"
        raise InputError(where, f"link {links[number]}", None, allowed)
    values = np.linalg.svd(root / sizes, compute_uv=False)
    if values[-1] ** 2 < SINGULAR:
        allowed = "too few masses and inertias for so many joints: the mass matrix is singular"
        raise InputError(where, "joint", None, allowed)


def _is_solid(body: RobotBody) -> bool:
    return bool(body.mass or body.inertia.any())


def _root_of_mass_matrix(joints: Sequence[Joint], bodies: Sequence[RobotBody]) -> np.ndarray:
    """B (6 bodies, free joints) with M = B' B: of each body its velocity and its rate, weighted."""
    free = [number for number, joint in enumerate(joints) if joint.mimic is None]
    angles = np.random.default_rng(0).uniform(0.3, 1.2, len(joints))
    poses, motions, rows = list[Placement](), list[np.ndarray](), list[np.ndarray]()
    for number, (joint, body, angle) in enumerate(zip(joints, bodies, angles, strict=True)):
        under, motion = HOME, np.zeros((6, len(free)))  # velocity and rate by each free joint
        if joint.parent != BASE:
            under, motion = poses[joint.parent], motions[joint.parent]
        home = compose(under, joint.placement)
        motion, axis = (
            _point_motion(motion, home.position - under.position),
            home.rotation @ joint.axis,
        )
        leader, factor = (joint.mimic.joint, joint.mimic.multiplier) if joint.mimic else (number, 1)
        if joint.kind == "revolute":
            motion[3:, free.index(leader)] += factor * axis
            pose = Placement(rotate_about(axis, angle) @ home.rotation, home.position)
        else:
            motion[:3, free.index(leader)] += factor * axis
            pose = Placement(home.rotation, home.position + angle * axis)
        values, axes = np.linalg.eigh(body.inertia)
        turning = np.sqrt(np.maximum(values, 0.0))[:, None] * (pose.rotation @ axes).T
        rows.append(np.sqrt(body.mass) * _point_motion(motion, pose.rotation @ body.com)[:3])
        rows.append(turning @ motion[3:])
        poses.append(pose)
        motions.append(motion)
    return np.vstack(rows)


def _point_motion(motion: np.ndarray, arm: np.ndarray) -> np.ndarray:
    """Velocity and rate (6, n) of a point that is an arm (3,) further on the same body."""
    return np.vstack([motion[:3] + np.cross(motion[3:].T, arm).T, motion[3:]])


def rotate_about(axis: np.ndarray, angle: float) -> np.ndarray:
    """Rotation (3, 3) about a unit vector."""
    cross = np.cross(np.eye(3), -axis)
    rotation: np.ndarray = np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
    return rotation


def _find_held_root(
    urdf: Urdf, frames: dict[str, LinkFrame], joints: Sequence[Joint]
) -> Iterator[str]:
    """A line where a base with mass carries several limbs, as that of a walking or flying robot."""
    mass = sum(
        link.body.mass for link in urdf.links if link.body and frames[link.name].body == BASE
    )
    if mass and sum(joint.parent == BASE for joint in joints) > 1:
        root = next(iter(frames))
        held = f"link {root} is fixed to the ground, with its {mass:.3g} kg"
        yield f"{held}: one that moves needs a link before it, and a joint of type floating"


def _mimic(
    joint: UrdfJoint, moving: Sequence[UrdfJoint], numbers: dict[str, int], where: str
) -> Mimic | None:
    """The free joint that a joint mimics, itself or by joints that mimic others; or None.

    Raises InputError unless such joints lead to one that moves and mimics none.
    """
    if joint.mimic is None:
        return None
    field, followers = f"joint {joint.name}: mimic", {joint.name}
    name, multiplier, offset = joint.mimic
    while name in numbers and name not in followers:
        leader = moving[numbers[name]].mimic
        if leader is None:
            if abs(multiplier) > LARGEST_MULTIPLIER:
                allowed = f"must make at most {LARGEST_MULTIPLIER:g}, times those before it"
                raise InputError(where, f"{field}.multiplier", multiplier, allowed)
            return Mimic(numbers[name], multiplier, offset)
        followers.add(name)
        name, multiplier, offset = (
            leader[0],
            multiplier * leader[1],
            multiplier * leader[2] + offset,
        )
    allowed = "must be a joint that moves, and that does not follow this one"
    raise InputError(where, f"{field}.joint", name, allowed)

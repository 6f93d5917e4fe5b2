"""Links and joints of a URDF as a tree of bodies: what is fixed to a body is merged into it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from crosscheck.models.errors import InputError
from crosscheck.models.robot.robot import BASE, Joint, LinkFrame, Mimic, Placement, RobotBody
from crosscheck.models.robot.urdf import Urdf, UrdfJoint

MOST_JOINTS = 64
# Of a principal inertia over the largest one: what rounding of printed digits explains.
ROUNDED = 1e-6
SINGULAR = 1e-12  # less of it is none
HOME = Placement(np.eye(3), np.zeros(3))


class Tree(NamedTuple):
    """A robot's moving joints, parents first; their bodies; frames of links; what is doubtful."""

    joints: tuple[Joint, ...]
    bodies: tuple[RobotBody, ...]
    frames: dict[str, LinkFrame]
    doubtful: tuple[str, ...]


def tree_of(urdf: Urdf, where: str) -> Tree:
    """The tree of bodies that a URDF's links and joints make.

    Raises InputError for what is no tree, or a body that cannot move by its inertia.
    """
    root, below = _rooted(urdf, where)
    frames, moving = _frames(root, below)
    if not 1 <= len(moving) <= MOST_JOINTS:
        allowed = f"must be 1 to {MOST_JOINTS} that move; {len(moving)} do"
        raise InputError(where, "joint", None, allowed)
    bodies = [_merged(number, urdf, frames, moving, where) for number in range(len(moving))]
    numbers = {joint.name: number for number, joint in enumerate(moving)}
    joints = [
        Joint(
            joint.name,
            "prismatic" if joint.kind == "prismatic" else "revolute",
            frames[joint.parent].body,
            composed(frames[joint.parent].placement, joint.placement),
            joint.axis,
            joint.limits,
            _mimic(joint, moving, numbers, where),
        )
        for joint in moving
    ]
    return Tree(tuple(joints), tuple(bodies), frames, tuple(_doubtful(urdf, frames)))


def composed(outer: Placement, inner: Placement) -> Placement:
    """Placement of a frame that is at ``inner`` in a frame that is at ``outer``."""
    position = outer.position + outer.rotation @ inner.position
    return Placement(outer.rotation @ inner.rotation, position)


def _rooted(urdf: Urdf, where: str) -> tuple[str, dict[str, list[UrdfJoint]]]:
    """The root's name, and the joints that stand on each link. Raises InputError."""
    below: dict[str, list[UrdfJoint]] = {link.name: [] for link in urdf.links}
    above: dict[str, str] = {}
    for joint in urdf.joints:
        for end, name in (("parent", joint.parent), ("child", joint.child)):
            if name not in below:
                raise InputError(where, f"joint {joint.name}: {end}", name, "must be a link of it")
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
            own = LinkFrame(parent.body, composed(parent.placement, joint.placement))
        else:
            own = LinkFrame(len(moving), HOME)
            moving.append(joint)
        frames[joint.child] = own
        left += below[joint.child][::-1]
    return frames, moving


def _merged(
    number: int, urdf: Urdf, frames: dict[str, LinkFrame], moving: Sequence[UrdfJoint], where: str
) -> RobotBody:
    """All that a joint carries, merged into one body, in its frame. Raises InputError."""
    parts = []
    for link in urdf.links:
        frame = frames[link.name]
        if frame.body == number and link.body is not None:
            turn, own = frame.placement.rotation, link.body
            _require_definite(own.inertia, -ROUNDED, where, f"link {link.name}: inertia")
            com = frame.placement.position + turn @ own.com
            parts.append(RobotBody(own.mass, com, turn @ own.inertia @ turn.T))
    mass = sum(part.mass for part in parts)
    field = f"link {moving[number].child}"
    if not mass > 0:
        allowed = f"must have a mass, with all that is fixed to it: joint {moving[number].name}"
        raise InputError(where, field, None, f"{allowed} moves it")
    com = sum((part.mass * part.com for part in parts), np.zeros(3)) / mass
    inertia = np.zeros((3, 3))
    for part in parts:
        away = part.com - com
        inertia += part.inertia + part.mass * (away @ away * np.eye(3) - np.outer(away, away))
    _require_definite(inertia, SINGULAR, where, f"{field}: inertia")
    return RobotBody(mass, com, inertia)


def _require_definite(inertia: np.ndarray, least: float, where: str, field: str) -> None:
    """Raise InputError unless each principal value is more than so much of the largest."""
    values = np.linalg.eigvalsh(inertia)
    if values[0] < least * abs(values[-1]) or values[0] <= 0 < least:
        allowed = f"must be positive definite; its principal values are {_listed(values)} kg m^2"
        raise InputError(where, field, None, allowed)


def _listed(values: np.ndarray) -> str:
    return ", ".join(f"{each:.3g}" for each in values)


def _doubtful(urdf: Urdf, frames: dict[str, LinkFrame]) -> Iterator[str]:
    """A line for every moving link whose mass or inertia no body has."""
    for link in urdf.links:
        if link.body is None or frames[link.name].body == BASE:
            continue
        values = np.linalg.eigvalsh(link.body.inertia)
        if link.body.mass == 0 and values[-1] > 0:
            yield f"link {link.name}: an inertia without mass; used as it stands"
        if values[0] + values[1] < values[2] * (1 - ROUNDED):
            yield (
                f"link {link.name}: no body has principal inertias {_listed(values)} kg m^2, of"
                " which the last exceeds the others' sum; used as they stand"
            )


def _mimic(
    joint: UrdfJoint, moving: Sequence[UrdfJoint], numbers: dict[str, int], where: str
) -> Mimic | None:
    """What a joint mimics, or None.

    Raises InputError unless it follows a joint that moves and follows none.
    """
    if joint.mimic is None:
        return None
    name, multiplier, offset = joint.mimic
    if name not in numbers or moving[numbers[name]].mimic is not None:
        allowed = "must be a joint that moves and mimics none"
        raise InputError(where, f"joint {joint.name}: mimic.joint", name, allowed)
    return Mimic(numbers[name], multiplier, offset)

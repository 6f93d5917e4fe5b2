"""A robot with one thing taken for another: what may be wrong in its record, kind by kind.

A mistake is a row of the tables below: words that complete `with ...`, and the part that has it.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from itertools import combinations, permutations, product
from typing import Any, NamedTuple

import numpy as np

from crosscheck.models.robot.robot import (
    BASE,
    Joint,
    Level,
    Placement,
    Robot,
    RobotBody,
    Rotor,
    compute_point_inertia,
)
from crosscheck.models.robot.tree import merge_bodies, rotate_about
from crosscheck.models.robot.urdf import read_urdf, roll_pitch_yaw
from crosscheck.trial.changes.numbers import (
    AXES,
    INERTIA,
    INERTIA_ORDERS,
    LINK_FIELDS,
    Path,
    RobotNumber,
    get_link_name,
    get_value,
    list_numbers,
    name_part,
    put_value,
    set_entry,
)

UPPER = np.triu_indices(3)
EVERY = {"bodies": "every link", "joints": "every joint", "rotors": "every rotor"}


@dataclass(frozen=True)
class RobotMistake:
    """One thing taken for another: words that complete `with ...`, and the robot with it.

    several: whether in every part of a kind.
    """

    words: str
    robot: Robot
    several: bool = False


class BodyPart(NamedTuple):
    """A link of the URDF as a part of a body.

    number: of the body; in_link: in the link's axes; placement: of the link in the body's frame,
    where fixed joints move it; turn (3, 3): of the axes in which the file has its inertia.
    """

    name: str
    number: int
    in_link: RobotBody
    placement: Placement
    turn: np.ndarray

    @property
    def body(self) -> RobotBody:
        """The part in the body's frame."""
        return self.carry(self.in_link)

    def carry(self, body: RobotBody) -> RobotBody:
        """A body in the link's axes, in the frame of the part's body."""
        R, place = self.placement.rotation, self.placement.position
        return RobotBody(body.mass, R @ body.com + place, R @ body.inertia @ R.T)


def list_body_parts(robot: Robot) -> list[BodyPart]:
    """The links of which the bodies are made, each as the URDF has it; else the bodies."""
    parts, made = list[BodyPart](), np.zeros(len(robot.bodies))
    for link in read_urdf(robot.urdf, robot.name).links:
        frame = robot.frames.get(link.name)
        if link.body is not None and frame is not None and frame.body != BASE:
            parts.append(BodyPart(link.name, frame.body, link.body, frame.placement, link.turn))
            made[frame.body] += link.body.mass
    is_whole = np.allclose(made, [body.mass for body in robot.bodies])
    return parts if is_whole else list_whole_bodies(robot)


def list_whole_bodies(robot: Robot) -> list[BodyPart]:
    """Each body as a part of itself."""
    here = Placement(np.eye(3), np.zeros(3))
    return [
        BodyPart(get_link_name(robot, number), number, body, here, np.eye(3))
        for number, body in enumerate(robot.bodies)
    ]


def list_all_numbers(robot: Robot) -> Iterator[RobotNumber]:
    """The numbers of a robot; masses and centres also of links that are one body together."""
    links = read_urdf(robot.urdf, robot.name).links
    frames, parts = dict(robot.frames), list_body_parts(robot)
    together = Counter(part.number for part in parts)
    composed = [number for number, count in together.items() if count > 1]
    yield from list_numbers(robot, composed)

    def build_robot(part: BodyPart, path: Path, value: float) -> Robot:
        body = put_value(part.in_link, path, value)
        changed = [replace(e, body=body) if e.name == part.name else e for e in links]
        merged = merge_bodies(part.number, changed, frames)
        return put_value(robot, ("bodies", part.number), merged)

    for part in (each for each in parts if each.number in composed):
        for field in LINK_FIELDS:
            for entry in field.entries:
                path: Path = (*field.path, entry) if entry else field.path
                name = f"{part.name}: {field.words.format(entry)}"
                where = ".".join(map(str, ("links", part.name, *path)))
                size = max(float(np.abs(get_value(part.in_link, field.path)).max()), field.size)
                value, put = float(get_value(part.in_link, path)), partial(build_robot, part, path)
                if size:
                    yield RobotNumber(where, name, field.unit, value, size, put)


def list_part_mistakes(robot: Robot, part: BodyPart) -> dict[str, RobotBody]:
    """By words, what a link may be taken for, in the frame of its body."""
    changed = dict(_confuse_body(part.in_link, part.turn))
    for link, place in _list_places_beyond(robot, part):
        moved = replace(part.in_link, com=place + part.in_link.com)
        changed[f"its centre of mass counted from {link}"] = moved
    return {words: part.carry(body) for words, body in changed.items()}


def _list_places_beyond(robot: Robot, part: BodyPart) -> Iterator[tuple[str, np.ndarray]]:
    """Links that are fixed to a part or that move on it, and their places in its frame."""
    at, number = part.placement, part.number
    frames = {name: f.placement.position for name, f in robot.frames.items() if f.body == number}
    for other, joint in enumerate(robot.joints):
        if joint.parent == number:
            frames[get_link_name(robot, other)] = joint.placement.position
    for name, place in frames.items():
        shift = at.rotation.T @ (place - at.position)
        if name != part.name and shift.any():
            yield name, shift


def _confuse_body(body: RobotBody, axes: np.ndarray) -> Iterator[tuple[str, RobotBody]]:
    """Words on what a link's numbers may be taken for, and the link so.

    axes (3, 3): the rotation of those in which the file has its inertia.
    """
    yield "left out", RobotBody(0.0, body.com, 0 * body.inertia)
    yield "twice", RobotBody(2 * body.mass, body.com, 2 * body.inertia)
    about = compute_point_inertia(body.mass, body.com)
    of_centre = body.inertia - about
    stated = axes.T @ body.inertia @ axes
    diagonal, of_joint = np.diag(np.diag(stated)), body.inertia + about
    once = "its inertia turned once by the rpy of its inertial frame"
    inertia_of = {
        "its inertia as it stands, not turned by the rpy of its inertial frame": stated,
        f"{once}, R I for R I R'": axes @ stated,
        f"{once}, I R' for R I R'": stated @ axes.T,
        "its inertia about the joint, taken for that about the centre of mass": of_joint,
        "its inertia about the centre of mass, taken for that about the joint": of_centre,
        "the parallel axis term m (c'c 1 - c c') with the opposite sign": body.inertia - 2 * about,
        "all products of inertia left out": axes @ diagonal @ axes.T,
        "all products of inertia with the opposite sign": axes @ (2 * diagonal - stated) @ axes.T,
    }
    for words, inertia in inertia_of.items():
        yield words, replace(body, inertia=inertia)
    # Of a planar arm's links one number alone is stated.
    for order, other in permutations(INERTIA_ORDERS, 2) if np.diag(stated).all() else ():
        mixed = np.zeros((3, 3))
        for entry, read in zip(order, other, strict=True):
            mixed = set_entry(mixed, INERTIA[read], stated[INERTIA[entry]])
        words = f"its inertias {', '.join(order)} read as {', '.join(other)}"
        yield words, replace(body, inertia=axes @ mixed @ axes.T)


def list_frame_mistakes(robot: Robot, level: Level) -> Iterator[RobotMistake]:
    """Confusions of joints' frames and axes, rotors and gravity that are easily made."""
    yield from _confuse_all(robot, "joints", _confuse_joint)
    if level != "links":
        yield from _confuse_all(robot, "rotors", _confuse_rotor)
        yield from _exchange_rotors(robot)
    for number, joint in enumerate(robot.joints):
        for words, mimic in _confuse_mimic(joint):
            name = name_part(robot, "joints", number)
            yield RobotMistake(
                f"{name}: {words}", put_value(robot, ("joints", number, "mimic"), mimic)
            )
    size = float(np.linalg.norm(robot.gravity))
    for axis, sign in product(range(3), (-1, 1)) if size else ():
        if axis != np.abs(robot.gravity).argmax():
            words = f"gravity along {AXES[axis]}, {sign * size:.6g} m/s^2"
            yield RobotMistake(words, replace(robot, gravity=sign * size * np.eye(3)[axis]))


def _confuse_all(
    robot: Robot, kind: str, confuse: Callable[[Any], Iterable[tuple[str, Any]]]
) -> Iterator[RobotMistake]:
    """Confusions of one part, and the same of all parts of a kind where there are several.

    confuse: yields words and the changed part, equally many for all parts, in one order.
    """
    parts = getattr(robot, kind)
    for together in zip(*map(confuse, parts), strict=True):
        words = together[0][0]
        for number, (_, changed) in enumerate(together):
            name = name_part(robot, kind, number)
            yield RobotMistake(f"{name}: {words}", put_value(robot, (kind, number), changed))
        if len(together) > 1:
            all_changed = put_value(robot, (kind,), tuple(changed for _, changed in together))
            yield RobotMistake(f"{EVERY[kind]}: {words}", all_changed, several=True)


def _confuse_joint(joint: Joint) -> Iterator[tuple[str, Joint]]:
    """Words on what a joint's frame may be taken for, and the joint so."""
    turn, position = joint.placement.rotation, joint.placement.position
    x, y, z = map(rotate_about, np.eye(3), roll_pitch_yaw(turn))
    yield "its axis the other way", replace(joint, axis=-joint.axis)
    yield "its axis in the frame of the link before", replace(joint, axis=turn.T @ joint.axis)
    for axis, unit in zip(AXES, np.eye(3), strict=True):
        yield f"its axis along {axis}", replace(joint, axis=unit)
    for words, other, place in (
        ("its place left out", turn, 0 * position),
        ("its frame turned the other way", turn.T, position),
        ("its frame not turned", np.eye(3), position),
        ("its rpy turned in the other order, about x last", x @ y @ z, position),
    ):
        yield words, replace(joint, placement=Placement(other, place))


def _confuse_rotor(rotor: Rotor) -> Iterator[tuple[str, Rotor]]:
    """Words on what a rotor's inertia and ratio may be taken for, and the rotor so."""
    for words, by in (
        ("the ratio once where its square belongs", abs(rotor.ratio)),
        ("its ratio left out", rotor.ratio**2),
        ("divided by its ratio's square", rotor.ratio**4),
    ):
        yield words, replace(rotor, inertia=rotor.inertia / by)


def _exchange_rotors(robot: Robot) -> Iterator[RobotMistake]:
    """Two joints' rotors, each with the other's inertia and ratio."""
    for i, j in combinations(range(len(robot.rotors)), 2):
        first, second = robot.rotors[i], robot.rotors[j]
        rotors = list(robot.rotors)
        rotors[i] = replace(first, inertia=second.inertia, ratio=second.ratio)
        rotors[j] = replace(second, inertia=first.inertia, ratio=first.ratio)
        names = " and ".join(name_part(robot, "rotors", place) for place in (i, j))
        yield RobotMistake(f"{names} exchanged", replace(robot, rotors=tuple(rotors)))


def _confuse_mimic(joint: Joint) -> Iterator[tuple[str, Any]]:
    """Words on how a joint that follows another may do so instead."""
    if (mimic := joint.mimic) is None:
        return
    by, offset = mimic.multiplier, mimic.offset
    for words, multiplier, moved in (
        ("its multiplier with the opposite sign", -by, offset),
        ("its multiplier left out", 1.0, offset),
        ("its multiplier twice", by**2, offset),
        ("its offset left out", by, 0.0),
        ("its offset with the opposite sign", by, -offset),
    ):
        yield words, replace(mimic, multiplier=multiplier, offset=moved)

"""What may be wrong in equations of a robot: one number, or one thing taken for another."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import combinations
from typing import Any, Literal

import numpy as np

from crosscheck.cost.springs import rotors_of
from crosscheck.models.robot.robot import (
    BASE,
    Joint,
    JointStage,
    Placement,
    Robot,
    RobotBody,
    Rotor,
)

AXES = "xyz"
MOMENTS = {"xx": (0, 0), "yy": (1, 1), "zz": (2, 2)}
PRODUCTS = {"xy": (0, 1), "xz": (0, 2), "yz": (1, 2)}
INERTIA = MOMENTS | PRODUCTS
Kind = Literal["bodies", "joints", "rotors", "stages"]


Part = RobotBody | Joint | Rotor
# Values of a number that somebody may have written by mistake, as parts of the right one.
USUAL = {-1.0: "with the opposite sign", 0.0: "left out", 0.5: "half", 2.0: "twice"}
ALIKE = 1e-6  # of numbers that are the same one


@dataclass(frozen=True)
class RobotNumber:
    """A number of a robot, on which its equations depend by at most its square.

    step: a size of it, by which differences are taken; put: the robot with another value of it.
    factor: whether the number is a factor, 1, of several numbers of the file.
    """

    name: str
    unit: str
    value: float
    step: float
    put: Callable[[float], Robot]
    factor: bool = False

    def words(self, value: float) -> str:
        """The number with another value, in words that complete `with ...`."""
        shown = 0.0 if abs(value) < 1e-7 * self.step else value
        if self.factor:
            near = [words for usual, words in USUAL.items() if abs(shown - usual) < ALIKE]
            return f"{self.name} {near[0] if near else f'times {shown:.6g}'}"
        own = f"{self.value:.6g} {self.unit}".rstrip()
        return f"{self.name} = {shown:.6g} {self.unit}".rstrip() + f" (file: {own})"


@dataclass(frozen=True)
class Confusion:
    """One thing taken for another: words that complete `with ...`, and the robot with it.

    several: whether in every part of a kind.
    """

    words: str
    robot: Robot
    several: bool = False


def numbers(robot: Robot) -> Iterator[RobotNumber]:
    """The numbers of bodies, joints' places, rotors, stages and gravity that may be wrong."""
    for number, body in enumerate(robot.bodies):
        yield from _of_body(robot, number, body)
    for number, joint in enumerate(robot.joints):
        for axis, own in enumerate(joint.placement.position.tolist()):
            moved = partial(_displaced, robot, number, axis)
            size = max(float(np.abs(joint.placement.position).max()), 0.1)
            yield RobotNumber(f"joint {joint.name}: its place, {AXES[axis]}", "m", own, size, moved)
    for number, rotor in enumerate(robot.rotors):
        name = f"rotor of {robot.joints[rotor.joint].name}"
        put = partial(_put, robot, "rotors", number)
        yield RobotNumber(
            f"{name}: inertia", "kg m^2", rotor.inertia, rotor.inertia, partial(put, "inertia")
        )
        size = max(abs(rotor.ratio), 1.0)
        yield RobotNumber(f"{name}: ratio", "", rotor.ratio, size, partial(put, "ratio"))
    for number, stage in enumerate(robot.stages):
        yield from _of_stage(robot, number, stage)
    for axis, own in enumerate(robot.gravity.tolist()):
        pulled = partial(_pulled, robot, axis)
        yield RobotNumber(f"gravity: {AXES[axis]}", "m/s^2", own, 10.0, pulled)
    yield from _factors(robot)


def _factors(robot: Robot) -> Iterator[RobotNumber]:
    """Factors of a number of every link, or of every rotor, where there are several."""
    several: tuple[tuple[str, Kind, str], ...] = (
        ("every link's mass", "bodies", "mass"),
        ("every link's inertia", "bodies", "inertia"),
        ("every link's centre of mass", "bodies", "com"),
        ("every rotor's inertia", "rotors", "inertia"),
        ("every rotor's ratio", "rotors", "ratio"),
    )
    for name, kind, field in several:
        parts = getattr(robot, kind)

        def put(by: float, kind: Kind = kind, field: str = field) -> Robot:
            own = getattr(robot, kind)
            scaled = [replace(part, **{field: by * getattr(part, field)}) for part in own]
            return _with_all(robot, kind, scaled)

        if len(parts) > 1:
            yield RobotNumber(name, "", 1.0, 1.0, put, factor=True)


def _of_stage(robot: Robot, number: int, stage: JointStage) -> Iterator[RobotNumber]:
    """The inertias of sun and planets of a stage, in the form in which they are given."""
    name = f"stage of {robot.joints[stage.joint].name}"
    for part in ("sun", "planet"):
        for what, unit in (("inertia", "kg m^2"), ("equivalent mass", "kg")):
            field = f"{part}_{what}_{unit}".replace(" ", "_").replace("^", "")
            own = getattr(stage.gears, field)

            def put(value: float, field: str = field) -> Robot:
                gears = stage.gears.model_copy(update={field: value})
                return _put(robot, "stages", number, "gears", gears)

            if own is not None:
                yield RobotNumber(f"{name}: {what} of {part}", unit, own, own, put)


def _of_body(robot: Robot, number: int, body: RobotBody) -> Iterator[RobotNumber]:
    link, put = link_of(robot, number), partial(_put, robot, "bodies", number)

    def put_entry(field: str, place: tuple[int, ...], value: float) -> Robot:
        """The robot with another entry in the body's centre or inertia."""
        return put(field, _with(getattr(body, field), place, value))

    yield RobotNumber(f"{link}: mass", "kg", body.mass, body.mass, partial(put, "mass"))
    reach = _reach(body)
    for axis, own in enumerate(body.com.tolist()):
        entry = partial(put_entry, "com", (axis,))
        yield RobotNumber(f"{link}: centre of mass, {AXES[axis]}", "m", own, reach, entry)
    size = float(np.trace(body.inertia)) or body.mass * reach**2
    for key, place in INERTIA.items():
        own, entry = float(body.inertia[place]), partial(put_entry, "inertia", place)
        yield RobotNumber(f"{link}: I{key}", "kg m^2", own, size, entry)


def _reach(body: RobotBody) -> float:
    """A length of a body [m], never 0."""
    return max(float(np.abs(body.com).max()), 0.01)


def confusions(robot: Robot) -> Iterator[Confusion]:
    """Confusions of frames, signs and places that are easily taken for each other."""
    links = [link_of(robot, number) for number in range(len(robot.bodies))]
    bodies = list(map(_bodies, robot.bodies, robot.joints))
    yield from _of_each(robot, "bodies", "every link", links, bodies)
    names = [f"joint {joint.name}" for joint in robot.joints]
    yield from _of_each(robot, "joints", "every joint", names, list(map(_joints, robot.joints)))
    names = [f"rotor of {robot.joints[rotor.joint].name}" for rotor in robot.rotors]
    yield from _of_each(robot, "rotors", "every rotor", names, list(map(_rotors, robot.rotors)))
    yield from _mimics(robot)
    for number, rotor in enumerate(robot.rotors):
        name = f"rotor of {robot.joints[rotor.joint].name}"
        seen = {robot.frames[rotor.stator].body}
        for stator, frame in robot.frames.items():
            if frame.body in seen:
                continue
            seen.add(frame.body)  # one link of each body
            words = f"on {stator}" if frame.body != BASE else f"on the ground, {stator}"
            moved = _put(robot, "rotors", number, "stator", stator)
            yield Confusion(f"{name}: its stator {words}", moved)
        for roll, axis in ((1, "y, z, x"), (2, "z, x, y")):
            rolled = _put(robot, "rotors", number, "axis", np.roll(rotor.axis, roll))
            yield Confusion(f"{name}: its axis in another order, {axis}", rolled)
    for stage in robot.stages:
        name = f"stage of {robot.joints[stage.joint].name}"
        others = tuple(other for other in robot.stages if other is not stage)
        sun, planets = rotors_of(robot, stage)
        for words, pair in (
            ("its ratio z_r / z_s, that of a carrier held", (sun.ratio - 1, planets.ratio)),
            ("its sun turning the other way", (-sun.ratio, planets.ratio)),
            ("its planets turning the other way", (sun.ratio, -planets.ratio)),
            ("its planets turning as on the carrier", (sun.ratio, planets.ratio - 1)),
        ):
            turned = [replace(own, ratio=k) for own, k in zip((sun, planets), pair, strict=True)]
            changed_robot = replace(robot, rotors=(*robot.rotors, *turned), stages=others)
            yield Confusion(f"{name}: {words}", changed_robot)


def steiner(mass: float, com: np.ndarray) -> np.ndarray:
    """Inertia (3, 3) that a point mass [kg] at com [m] has about the origin."""
    return mass * (com @ com * np.eye(3) - np.outer(com, com))


def _of_each(
    robot: Robot,
    kind: Kind,
    every: str,
    names: list[str],
    confused: list[Iterator[tuple[str, Any]]],
) -> Iterator[Confusion]:
    """Confusions of one part, and the same of all parts of a kind where there are several.

    confused: of each part words and the part so, alike in number and order.
    """
    for together in zip(*confused, strict=True):
        words = together[0][0]
        for number, (_, changed) in enumerate(together):
            yield Confusion(f"{names[number]}: {words}", with_part(robot, kind, number, changed))
        if len(together) > 1:
            changed_robot = _with_all(robot, kind, [changed for _, changed in together])
            yield Confusion(f"{every}: {words}", changed_robot, several=True)


def _joints(joint: Joint) -> Iterator[tuple[str, Joint]]:
    """Words on what a joint's frame may be taken for, and the joint so."""
    turn, position = joint.placement.rotation, joint.placement.position
    yield "its axis the other way", replace(joint, axis=-joint.axis)
    for words, other in (
        ("its frame turned the other way", turn.T),
        ("its frame not turned", np.eye(3)),
        ("its rpy turned in the other order, about x last", _other_order(turn)),
    ):
        yield words, replace(joint, placement=Placement(other, position))
    yield (
        "its place turned with its frame",
        replace(joint, placement=Placement(turn, turn @ position)),
    )


def _other_order(turn: np.ndarray) -> np.ndarray:
    """The rotation by the same roll, pitch and yaw, but about z first and about x last."""
    pitch = -np.arcsin(np.clip(turn[2, 0], -1.0, 1.0))
    roll, yaw = np.arctan2(turn[2, 1], turn[2, 2]), np.arctan2(turn[1, 0], turn[0, 0])
    found = np.eye(3)
    for axis, angle in enumerate((roll, pitch, yaw)):
        i, j = (axis + 1) % 3, (axis + 2) % 3
        own = np.eye(3)
        own[i, i] = own[j, j] = np.cos(angle)
        own[j, i] = np.sin(angle)
        own[i, j] = -own[j, i]
        found = found @ own
    return found


def _rotors(rotor: Rotor) -> Iterator[tuple[str, Rotor]]:
    """Words on what a rotor's inertia and ratio may be taken for, and the rotor so."""
    yield (
        "the ratio once where its square belongs",
        replace(rotor, inertia=rotor.inertia / abs(rotor.ratio)),
    )
    yield "its ratio left out", replace(rotor, inertia=rotor.inertia / rotor.ratio**2)


def _mimics(robot: Robot) -> Iterator[Confusion]:
    """Confusions of how joints follow others."""
    for number, joint in enumerate(robot.joints):
        own = joint.mimic
        if own is None:
            continue
        for words, multiplier, offset in (
            ("its multiplier with the opposite sign", -own.multiplier, own.offset),
            ("its multiplier left out", 1.0, own.offset),
            ("its offset left out", own.multiplier, 0.0),
            ("its offset with the opposite sign", own.multiplier, -own.offset),
            ("its offset multiplied too", own.multiplier, own.multiplier * own.offset),
        ):
            mimic = replace(own, multiplier=multiplier, offset=offset)
            changed = with_part(robot, "joints", number, replace(joint, mimic=mimic))
            yield Confusion(f"joint {joint.name}: {words}", changed)


def _bodies(body: RobotBody, joint: Joint) -> Iterator[tuple[str, RobotBody]]:
    """Words on what a body's numbers may be taken for, and the body so."""
    about = steiner(body.mass, body.com)
    diagonal = np.diag(np.diag(body.inertia))
    yield (
        "its inertia about the joint, taken for that about the centre of mass",
        replace(body, inertia=body.inertia + about),
    )
    yield (
        "its inertia about the centre of mass, taken for that about the joint",
        replace(body, inertia=body.inertia - about),
    )
    yield (
        "all products of inertia with the opposite sign",
        replace(body, inertia=2 * diagonal - body.inertia),
    )
    for keys in (MOMENTS, PRODUCTS):
        for one, other in combinations(keys, 2):
            inertia = body.inertia
            for key, source in ((one, other), (other, one)):
                inertia = _with(inertia, INERTIA[key], float(body.inertia[INERTIA[source]]))
            yield f"I{one} and I{other} exchanged", replace(body, inertia=inertia)
    for words, turn in (
        ("the frame of the link before it", joint.placement.rotation),
        ("its own frame, read as that of the link before", joint.placement.rotation.T),
    ):
        turned = turn @ body.inertia @ turn.T
        yield f"its inertia in {words}", replace(body, inertia=turned)
        yield f"its centre of mass in {words}", replace(body, com=turn @ body.com)
        yield (
            f"its inertia and centre of mass in {words}",
            RobotBody(body.mass, turn @ body.com, turned),
        )


def link_of(robot: Robot, number: int) -> str:
    """The URDF's name of the link that a joint moves."""
    return next(name for name, frame in robot.frames.items() if frame.body == number)


def with_part(robot: Robot, kind: Kind, number: int, part: object) -> Robot:
    """The robot with another body, joint, rotor or stage in place of one of these."""
    parts: list[object] = list(getattr(robot, kind))
    parts[number] = part
    changed: dict[str, Any] = {kind: tuple(parts)}
    return replace(robot, **changed)


def _with_all(robot: Robot, kind: Kind, parts: Sequence[Part]) -> Robot:
    """The robot with other bodies, joints or rotors."""
    changed: dict[str, Any] = {kind: tuple(parts)}
    return replace(robot, **changed)


def _displaced(robot: Robot, number: int, axis: int, value: float) -> Robot:
    """The robot with another coordinate of a joint's place on the link before it."""
    own = robot.joints[number].placement
    placement = Placement(own.rotation, _with(own.position, (axis,), value))
    return _put(robot, "joints", number, "placement", placement)


def _put(robot: Robot, kind: Kind, number: int, field: str, value: object) -> Robot:
    """The robot with another value in a field of one of its parts."""
    return with_part(robot, kind, number, replace(getattr(robot, kind)[number], **{field: value}))


def _pulled(robot: Robot, axis: int, value: float) -> Robot:
    return replace(robot, gravity=_with(robot.gravity, (axis,), value))


def _with(values: np.ndarray, place: tuple[int, ...], value: float) -> np.ndarray:
    """The values with another at a place; of a symmetric matrix at its mirror image too."""
    changed = values.copy()
    changed[place] = changed[place[::-1]] = value
    return changed

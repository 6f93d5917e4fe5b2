"""What may be wrong in equations of a robot: one number, or one thing taken for another."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from itertools import combinations
from typing import Any, Literal

import numpy as np

from crosscheck.cost.springs import rotors_of
from crosscheck.models.robot.robot import BASE, Joint, JointStage, Placement, Robot, RobotBody

AXES = "xyz"
MOMENTS = {"xx": (0, 0), "yy": (1, 1), "zz": (2, 2)}
PRODUCTS = {"xy": (0, 1), "xz": (0, 2), "yz": (1, 2)}
INERTIA = MOMENTS | PRODUCTS
Kind = Literal["bodies", "joints", "rotors", "stages"]


@dataclass(frozen=True)
class RobotNumber:
    """A number of a robot, on which its equations depend by at most its square.

    step: a size of it, by which differences are taken; put: the robot with another value of it.
    """

    name: str
    unit: str
    value: float
    step: float
    put: Callable[[float], Robot]


@dataclass(frozen=True)
class Confusion:
    """One thing taken for another: words that complete `with ...`, and the robot with it."""

    words: str
    robot: Robot


def numbers(robot: Robot) -> Iterator[RobotNumber]:
    """The numbers of masses, centres, inertias, rotors, stages and gravity that may be wrong."""
    for number, body in enumerate(robot.bodies):
        yield from _of_body(robot, number, body)
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
    reach = max(float(np.abs(body.com).max()), 0.01)
    for axis, own in enumerate(body.com.tolist()):
        entry = partial(put_entry, "com", (axis,))
        yield RobotNumber(f"{link}: centre of mass, {AXES[axis]}", "m", own, reach, entry)
    size = float(np.trace(body.inertia))
    for key, place in INERTIA.items():
        own, entry = float(body.inertia[place]), partial(put_entry, "inertia", place)
        yield RobotNumber(f"{link}: I{key}", "kg m^2", own, size, entry)


def confusions(robot: Robot) -> Iterator[Confusion]:
    """Confusions of frames, signs and places that are easily taken for each other."""
    for number, (body, joint) in enumerate(zip(robot.bodies, robot.joints, strict=True)):
        link = link_of(robot, number)
        for words, changed in _bodies(body, joint):
            yield Confusion(f"{link}: {words}", with_part(robot, "bodies", number, changed))
        turn, position = joint.placement.rotation, joint.placement.position
        other_way, straight = Placement(turn.T, position), Placement(np.eye(3), position)
        for words, other in (
            ("its axis the other way", replace(joint, axis=-joint.axis)),
            ("its frame turned the other way", replace(joint, placement=other_way)),
            ("its frame not turned", replace(joint, placement=straight)),
        ):
            turned_joint = with_part(robot, "joints", number, other)
            yield Confusion(f"joint {joint.name}: {words}", turned_joint)
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
    yield "all products of inertia negated", replace(body, inertia=2 * diagonal - body.inertia)
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

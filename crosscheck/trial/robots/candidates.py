"""What may be wrong in equations of a robot: one number, or one thing taken for another."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from itertools import combinations

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
    """One thing taken for another: words that complete `right with ...`, and the robot so."""

    words: str
    robot: Robot


def numbers(robot: Robot) -> Iterator[RobotNumber]:
    """Masses, centres, inertias, rotors, stages and gravity."""
    for number, body in enumerate(robot.bodies):
        yield from _of_body(robot, number, body)
    for number, rotor in enumerate(robot.rotors):
        name = f"rotor of {robot.joints[rotor.joint].name}"

        def inertia(value: float, at: int = number) -> Robot:
            return with_rotor(robot, at, replace(robot.rotors[at], inertia=value))

        def ratio(value: float, at: int = number) -> Robot:
            return with_rotor(robot, at, replace(robot.rotors[at], ratio=value))

        yield RobotNumber(f"{name}: inertia", "kg m^2", rotor.inertia, rotor.inertia, inertia)
        yield RobotNumber(f"{name}: ratio", "", rotor.ratio, max(abs(rotor.ratio), 1.0), ratio)
    for number, stage in enumerate(robot.stages):
        yield from _of_stage(robot, number, stage)
    for axis in range(3):

        def gravity(value: float, at: int = axis) -> Robot:
            return replace(robot, gravity=_with(robot.gravity, at, value))

        own = float(robot.gravity[axis])
        yield RobotNumber(f"gravity: {AXES[axis]}", "m/s^2", own, 10.0, gravity)


def _of_stage(robot: Robot, number: int, stage: JointStage) -> Iterator[RobotNumber]:
    """Inertias of sun and planets, in the form in which they are given."""
    name = f"stage of {robot.joints[stage.joint].name}"
    for part in ("sun", "planet"):
        for what, unit in (("inertia", "kg m^2"), ("equivalent mass", "kg")):
            field = f"{part}_{what}_{unit}".replace(" ", "_").replace("^", "")
            own = getattr(stage.gears, field)

            def put(value: float, field: str = field) -> Robot:
                gears = stage.gears.model_copy(update={field: value})
                changed = replace(stage, gears=gears)
                before, after = robot.stages[:number], robot.stages[number + 1 :]
                return replace(robot, stages=(*before, changed, *after))

            if own is not None:
                yield RobotNumber(f"{name}: {what} of {part}", unit, own, own, put)


def _of_body(robot: Robot, number: int, body: RobotBody) -> Iterator[RobotNumber]:
    link = link_of(robot, number)

    def mass(value: float) -> Robot:
        return with_body(robot, number, replace(body, mass=value))

    yield RobotNumber(f"{link}: mass", "kg", body.mass, body.mass, mass)
    reach = max(float(np.abs(body.com).max()), 0.01)
    for axis in range(3):

        def com(value: float, at: int = axis) -> Robot:
            return with_body(robot, number, replace(body, com=_with(body.com, at, value)))

        name = f"{link}: centre of mass, {AXES[axis]}"
        yield RobotNumber(name, "m", float(body.com[axis]), reach, com)
    size = float(np.trace(body.inertia))
    for key, place in INERTIA.items():

        def inertia(value: float, at: tuple[int, int] = place) -> Robot:
            changed = _symmetric(body.inertia, at, value)
            return with_body(robot, number, replace(body, inertia=changed))

        yield RobotNumber(f"{link}: I{key}", "kg m^2", float(body.inertia[place]), size, inertia)


def confusions(robot: Robot) -> Iterator[Confusion]:
    """Frames, signs and places that are easily taken for each other."""
    for number, (body, joint) in enumerate(zip(robot.bodies, robot.joints, strict=True)):
        link = link_of(robot, number)
        for words, changed in _bodies(body, joint):
            yield Confusion(f"{link}: {words}", with_body(robot, number, changed))
        turn = joint.placement.rotation
        for words, other in (
            ("its axis the other way", replace(joint, axis=-joint.axis)),
            ("its frame turned the other way", _placed(joint, turn.T, joint.placement.position)),
            ("its frame not turned", _placed(joint, np.eye(3), joint.placement.position)),
        ):
            joints = (*robot.joints[:number], other, *robot.joints[number + 1 :])
            yield Confusion(f"joint {joint.name}: {words}", replace(robot, joints=joints))
    for number, rotor in enumerate(robot.rotors):
        name = f"rotor of {robot.joints[rotor.joint].name}"
        for stator, words in _stators(robot, rotor):
            changed_rotor = replace(rotor, stator=stator)
            yield Confusion(f"{name}: its stator {words}", with_rotor(robot, number, changed_rotor))
        for roll, axis in ((1, "y, z, x"), (2, "z, x, y")):
            rolled = replace(rotor, axis=np.roll(rotor.axis, roll))
            words = f"its axis in another order, {axis}"
            yield Confusion(f"{name}: {words}", with_rotor(robot, number, rolled))
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


def _bodies(body: RobotBody, joint: Joint) -> Iterator[tuple[str, RobotBody]]:
    """What a body's numbers may be taken for."""
    about = body.mass * (body.com @ body.com * np.eye(3) - np.outer(body.com, body.com))
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
                inertia = _symmetric(inertia, INERTIA[key], float(body.inertia[INERTIA[source]]))
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


def _stators(robot: Robot, rotor: Rotor) -> Iterator[tuple[str, str]]:
    """Links that the stator may be on instead, one of each body; and words."""
    seen = {robot.frames[rotor.stator].body}
    for name, frame in robot.frames.items():
        if frame.body not in seen:
            seen.add(frame.body)
            yield name, f"on {name}" if frame.body != BASE else f"on the ground, {name}"


def link_of(robot: Robot, number: int) -> str:
    """The URDF's name of the link that a joint moves."""
    return next(name for name, frame in robot.frames.items() if frame.body == number)


def with_body(robot: Robot, number: int, body: RobotBody) -> Robot:
    """The robot with another body in a place."""
    return replace(robot, bodies=(*robot.bodies[:number], body, *robot.bodies[number + 1 :]))


def with_rotor(robot: Robot, number: int, rotor: Rotor) -> Robot:
    """The robot with another rotor in a place."""
    return replace(robot, rotors=(*robot.rotors[:number], rotor, *robot.rotors[number + 1 :]))


def _placed(joint: Joint, rotation: np.ndarray, position: np.ndarray) -> Joint:
    return replace(joint, placement=Placement(rotation, position))


def _with(values: np.ndarray, place: int, value: float) -> np.ndarray:
    changed = values.copy()
    changed[place] = value
    return changed


def _symmetric(matrix: np.ndarray, place: tuple[int, int], value: float) -> np.ndarray:
    changed = matrix.copy()
    changed[place] = changed[place[::-1]] = value
    return changed

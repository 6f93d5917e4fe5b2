"""Possible errors in equations of a robot: a wrong number, or one thing mistaken for another."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import combinations, product
from typing import Any, Literal

import numpy as np
from scipy.spatial.transform import Rotation

from crosscheck.models.robot.robot import (
    BASE,
    Joint,
    JointStage,
    Placement,
    Robot,
    RobotBody,
    Rotor,
    compute_point_inertia,
)
from crosscheck.models.robot.urdf import roll_pitch_yaw
from crosscheck.planning.springs import stage_rotors

AXES = "xyz"
MOMENTS = {"xx": (0, 0), "yy": (1, 1), "zz": (2, 2)}
PRODUCTS = {"xy": (0, 1), "xz": (0, 2), "yz": (1, 2)}
INERTIA = MOMENTS | PRODUCTS
PartKind = Literal["bodies", "joints", "rotors", "stages"]


RobotPart = RobotBody | Joint | Rotor
# Values of a number that somebody may have written by mistake, as parts of the right one.
USUAL = {-1.0: "with the opposite sign", 0.0: "left out", 0.5: "half", 2.0: "twice"}
# Factors between units: of a screw's ratio, or of any number.
UNITS = {
    1e3: "1000 times as large: another unit?",
    1e-3: "1/1000 of it: another unit?",
    2 * np.pi: "2 pi times as large: turns taken for radians?",
    0.5 / np.pi: "1/(2 pi) of it: turns taken for radians?",
    np.pi / 180: "pi/180 of it: degrees taken for radians?",
    180 / np.pi: "180/pi times as large: radians taken for degrees?",
}
# The same of numbers of one unit alone.
UNITS_OF = {
    "kg": {
        2.20462: "2.20462 times as large: pounds?",
        1 / 2.20462: "1/2.20462 of it: taken for pounds?",
    },
    "m": {
        1e2: "100 times as large: centimetres?",
        1e-2: "1/100 of it: taken for centimetres?",
    },
}
# Masses and inertias of a stage, by their fields.
STAGE_FIELDS = {
    f"{part}_{what}_{unit}".replace(" ", "_").replace("^", ""): (part, what, unit)
    for part in ("sun", "planet")
    for what, unit in (("inertia", "kg m^2"), ("equivalent mass", "kg"))
}
FAR = 10  # largest distance of a joint or centre, over the longest distance in the file
AS_IT_STANDS = "its inertia as it stands, not turned by the rpy of its inertial frame"
TYPED = 2e-5  # relative tolerance of unit factors, which are often typed with five digits
ALIKE = 1e-6  # relative tolerance between equal numbers


@dataclass(frozen=True)
class RobotNumber:
    """A number of a robot, on which its equations depend by at most its square.

    step: a size of it, by which differences are taken; put: the robot with another value of it.
    factor: whether the number is a factor, 1, of several numbers of the file in the unit; curved:
    whether equations depend on it in another way than by its square.
    """

    name: str
    unit: str
    value: float
    step: float
    put: Callable[[float], Robot]
    factor: bool = False
    curved: bool = False

    def words(self, value: float) -> str:
        """The number with another value, in words that complete `with ...`."""
        shown = 0.0 if abs(value) < 1e-7 * self.step else value
        if self.factor:
            near = [words for usual, words in USUAL.items() if abs(shown - usual) < ALIKE]
            return f"{self.name} {near[0] if near else f'{shown:.6g} times as large'}"
        file_value = f"{self.value:.6g} {self.unit}".rstrip()
        words = f"{self.name} = {shown:.6g} {self.unit}".rstrip()
        unit = self.describe_unit(shown)
        return f"{words} (file: {file_value}){unit and f', {unit}'}"

    def describe_unit(self, value: float) -> str:
        """Words on a value that is the number in another unit; '' for none."""
        right = self.value
        units = UNITS | UNITS_OF.get(self.unit, {})
        near = (w for by, w in units.items() if right and abs(value / (by * right) - 1) < TYPED)
        return next(near, "")


@dataclass(frozen=True)
class FrameMistake:
    """One thing taken for another: words that complete `with ...`, and the robot with it.

    several: whether in every part of a kind.
    """

    words: str
    robot: Robot
    several: bool = False


def list_numbers(robot: Robot) -> Iterator[RobotNumber]:
    """The numbers of bodies, joints' places, rotors, stages and gravity that may be wrong."""
    for number, body in enumerate(robot.bodies):
        yield from _body_numbers(robot, number, body)
    for number, joint in enumerate(robot.joints):
        for axis, value in enumerate(joint.placement.position.tolist()):
            moved = partial(_move_joint, robot, number, axis)
            size = max(float(np.abs(joint.placement.position).max()), 0.1)
            yield RobotNumber(
                f"joint {joint.name}: its place, {AXES[axis]}", "m", value, size, moved
            )

        def scale(by: float, number: int = number, joint: Joint = joint) -> Robot:
            scaled = Placement(joint.placement.rotation, by * joint.placement.position)
            return _set_field(robot, "joints", number, "placement", scaled)

        yield RobotNumber(f"joint {joint.name}: its place", "m", 1.0, 1.0, scale, factor=True)
        yield from _curved_numbers(robot, number, joint)
    for number, rotor in enumerate(robot.rotors):
        name = f"rotor of {robot.joints[rotor.joint].name}"
        put = partial(_set_field, robot, "rotors", number)
        yield RobotNumber(
            f"{name}: inertia", "kg m^2", rotor.inertia, rotor.inertia, partial(put, "inertia")
        )
        size = max(abs(rotor.ratio), 1.0)
        yield RobotNumber(f"{name}: ratio", "", rotor.ratio, size, partial(put, "ratio"))
    for number, stage in enumerate(robot.stages):
        yield from _stage_numbers(robot, number, stage)
    for axis, value in enumerate(robot.gravity.tolist()):
        pulled = partial(_set_gravity, robot, axis)
        yield RobotNumber(f"gravity: {AXES[axis]}", "m/s^2", value, 10.0, pulled)
    yield from _factors(robot)


def _factors(robot: Robot) -> Iterator[RobotNumber]:
    """Factors of a number of every link, or of every rotor, where there are several."""
    several: tuple[tuple[str, PartKind, str, str], ...] = (
        ("every link's mass", "bodies", "mass", "kg"),
        ("every link's inertia", "bodies", "inertia", "kg m^2"),
        ("every link's centre of mass", "bodies", "com", "m"),
        ("every rotor's inertia", "rotors", "inertia", "kg m^2"),
        ("every rotor's ratio", "rotors", "ratio", ""),
    )
    for name, kind, field, unit in several:
        parts = getattr(robot, kind)

        def put(by: float, kind: PartKind = kind, field: str = field) -> Robot:
            current_parts = getattr(robot, kind)
            scaled = [replace(part, **{field: by * getattr(part, field)}) for part in current_parts]
            return _replace_parts(robot, kind, scaled)

        if len(parts) > 1:
            yield RobotNumber(name, unit, 1.0, 1.0, put, factor=True)


def _curved_numbers(robot: Robot, number: int, joint: Joint) -> Iterator[RobotNumber]:
    """Angles of a joint's frame, a sliding axis' length, and how a joint follows another."""
    name, placement = f"joint {joint.name}", joint.placement
    angles = roll_pitch_yaw(placement.rotation)
    for place, angle in enumerate(("roll", "pitch", "yaw")):

        def turn(value: float, place: int = place) -> Robot:
            turned = set_entry(angles, (place,), value)
            frame = Placement(rotate_by(turned, (0, 1, 2)), placement.position)
            return _set_field(robot, "joints", number, "placement", frame)

        value = float(angles[place])
        yield RobotNumber(f"{name}: its {angle}", "rad", value, 1.0, turn, curved=True)
    if joint.kind == "prismatic":

        def stretch(by: float) -> Robot:
            return _set_field(robot, "joints", number, "axis", by * joint.axis)

        yield RobotNumber(f"{name}: its axis", "", 1.0, 1.0, stretch, factor=True, curved=True)
    mimic = joint.mimic
    if mimic is not None:
        for field, unit in (("multiplier", ""), ("offset", "rad")):

            def follow(value: float, field: str = field) -> Robot:
                changed: dict[str, Any] = {field: value}
                return _set_field(robot, "joints", number, "mimic", replace(mimic, **changed))

            value = float(getattr(mimic, field))
            yield RobotNumber(f"{name}: its {field}", unit, value, 1.0, follow, curved=True)


def _stage_numbers(robot: Robot, number: int, stage: JointStage) -> Iterator[RobotNumber]:
    """The inertias of sun and planets of a stage, in the form in which they are given."""
    name = f"stage of {robot.joints[stage.joint].name}"
    for field, (part, what, unit) in STAGE_FIELDS.items():
        value = getattr(stage.gears, field)

        def put(value: float, field: str = field) -> Robot:
            gears = stage.gears.model_copy(update={field: value})
            return _set_field(robot, "stages", number, "gears", gears)

        if value is not None:
            yield RobotNumber(f"{name}: {what} of {part}", unit, value, value, put)


def _body_numbers(robot: Robot, number: int, body: RobotBody) -> Iterator[RobotNumber]:
    link, put = get_link_name(robot, number), partial(_set_field, robot, "bodies", number)

    def put_entry(field: str, place: tuple[int, ...], value: float) -> Robot:
        """The robot with another entry in the body's centre or inertia."""
        return put(field, set_entry(getattr(body, field), place, value))

    yield RobotNumber(f"{link}: mass", "kg", body.mass, body.mass, partial(put, "mass"))
    for field, what, unit in (
        ("com", "its centre of mass", "m"),
        ("inertia", "its inertia", "kg m^2"),
    ):
        values = getattr(body, field)

        def scale(by: float, field: str = field, values: np.ndarray = values) -> Robot:
            return put(field, by * values)

        yield RobotNumber(f"{link}: {what}", unit, 1.0, 1.0, scale, factor=True)
    reach = _reach(body)
    for axis, value in enumerate(body.com.tolist()):
        entry = partial(put_entry, "com", (axis,))
        yield RobotNumber(f"{link}: centre of mass, {AXES[axis]}", "m", value, reach, entry)
    size = float(np.trace(body.inertia)) or body.mass * reach**2
    for key, place in INERTIA.items():
        value, entry = float(body.inertia[place]), partial(put_entry, "inertia", place)
        yield RobotNumber(f"{link}: I{key}", "kg m^2", value, size, entry)


def _reach(body: RobotBody) -> float:
    """A length of a body [m], never 0."""
    return max(float(np.abs(body.com).max()), 0.01)


def generate_frame_mistakes(robot: Robot, *, are_rotors_bodies: bool) -> Iterator[FrameMistake]:
    """Confusions of joints' frames and axes, rotors and gravity that are easily made.

    are_rotors_bodies: whether stators and axes of rotors matter.
    """
    names = [f"joint {joint.name}" for joint in robot.joints]
    yield from _part_mistakes(
        robot, "joints", "every joint", names, list(map(_joint_mistakes, robot.joints))
    )
    names = [f"rotor of {robot.joints[rotor.joint].name}" for rotor in robot.rotors]
    yield from _part_mistakes(
        robot, "rotors", "every rotor", names, list(map(_rotor_mistakes, robot.rotors))
    )
    yield from _chain_mistakes(robot)
    yield from _order_mistakes(robot)
    yield from _mimic_mistakes(robot)
    yield from _gravity_mistakes(robot)
    if are_rotors_bodies:
        words = "on the link before its joint, along the joint's axis"
        usual_rotors = (_place_rotor_usually(robot, rotor) for rotor in robot.rotors)
        confused = [iter([(words, usual)]) for usual in usual_rotors]
        yield from _part_mistakes(robot, "rotors", "every rotor", names, confused)
    for number, rotor in enumerate(robot.rotors if are_rotors_bodies else ()):
        name = f"rotor of {robot.joints[rotor.joint].name}"
        seen = {robot.frames[rotor.stator].body}
        for stator, frame in robot.frames.items():
            if frame.body in seen:
                continue
            seen.add(frame.body)  # one link of each body
            words = f"on {stator}" if frame.body != BASE else f"on the ground, {stator}"
            moved = _set_field(robot, "rotors", number, "stator", stator)
            yield FrameMistake(f"{name}: its stator {words}", moved)
        for roll, axis in ((1, "y, z, x"), (2, "z, x, y")):
            rolled = _set_field(robot, "rotors", number, "axis", np.roll(rotor.axis, roll))
            yield FrameMistake(f"{name}: its axis in another order, {axis}", rolled)
        for axis, unit in zip(AXES, np.eye(3), strict=True):
            turned = _set_field(robot, "rotors", number, "axis", unit)
            yield FrameMistake(f"{name}: its axis {axis} of its stator", turned)
    yield from _stage_mistakes(robot)


def _place_rotor_usually(robot: Robot, rotor: Rotor) -> Rotor:
    """The rotor where files have it that say nothing of its place."""
    joint = robot.joints[rotor.joint]
    parent = next(name for name, frame in robot.frames.items() if frame.body == joint.parent)
    axis = joint.placement.rotation @ joint.axis
    return replace(rotor, stator=parent, axis=robot.frames[parent].placement.rotation.T @ axis)


def _stage_mistakes(robot: Robot) -> Iterator[FrameMistake]:
    """Confusions of one planetary stage, and the same of every stage where there are several."""
    stages, confused = robot.stages, [_rotor_pair_mistakes(robot, each) for each in robot.stages]
    for together in zip(*confused, strict=True):
        words = together[0][0]
        for stage, (_, pair) in zip(stages, together, strict=True):
            others = tuple(other for other in stages if other is not stage)
            changed_robot = replace(robot, rotors=(*robot.rotors, *pair), stages=others)
            yield FrameMistake(f"stage of {robot.joints[stage.joint].name}: {words}", changed_robot)
        if len(stages) > 1:
            rotors = [rotor for _, pair in together for rotor in pair]
            changed_robot = replace(robot, rotors=(*robot.rotors, *rotors), stages=())
            yield FrameMistake(f"every stage: {words}", changed_robot, several=True)


def _rotor_pair_mistakes(
    robot: Robot, stage: JointStage
) -> Iterator[tuple[str, tuple[Rotor, Rotor]]]:
    """Words on what a stage's sun and planets may be taken for, and the rotors that they are so."""
    sun, planets = stage_rotors(robot, stage)
    gears = stage.gears
    whole_ratio = float(np.trunc(sun.ratio))
    single_inertia = planets.inertia / gears.planet_count
    for words, ratios in (
        ("its ratio z_r / z_s, that of a carrier held", (sun.ratio - 1, planets.ratio)),
        ("its sun's ratio rounded down, as by integer division", (whole_ratio, planets.ratio)),
        ("its sun turning the other way", (-sun.ratio, planets.ratio)),
        ("its planets turning the other way", (sun.ratio, -planets.ratio)),
        ("its planets turning as on the carrier", (sun.ratio, planets.ratio - 1)),
        (
            "its planets rolling by the sun's teeth",
            (sun.ratio, 1 - gears.sun_teeth / gears.planet_teeth),
        ),
    ):
        yield words, (replace(sun, ratio=ratios[0]), replace(planets, ratio=ratios[1]))
    yield "one planet for all", (sun, replace(planets, inertia=single_inertia))


def _chain_mistakes(robot: Robot) -> Iterator[FrameMistake]:
    """A tree taken for a chain, or a joint on a link that stands on the same one as it.

    Joints that begin a branch are on the end of the branch before it.
    """
    chained = list(robot.joints)
    branches = [k for k, joint in enumerate(robot.joints) if joint.parent != k - 1]
    for number in branches:
        joint = chained[number] = replace(robot.joints[number], parent=number - 1)
        words = f"joint {joint.name}: on {get_link_name(robot, number - 1)}, as in a chain"
        yield FrameMistake(words, replace_part(robot, "joints", number, joint))
    for number, joint in enumerate(robot.joints):
        for other in range(number - 1):
            if robot.joints[other].parent == joint.parent:
                words = (
                    f"joint {joint.name}: on {get_link_name(robot, other)}, which stands beside it"
                )
                moved = _set_field(robot, "joints", number, "parent", other)
                yield FrameMistake(words, moved)
    if len(branches) > 1:
        words = "every joint: on the link before it, as in a chain"
        yield FrameMistake(words, _replace_parts(robot, "joints", chained), several=True)


def _order_mistakes(robot: Robot) -> Iterator[FrameMistake]:
    """Joints that turn before the constant transform of their table, as in classic DH.

    Each link then ends where the next joint begins, and what it carries is placed there.
    """
    ends = dict(enumerate(joint.placement for joint in robot.joints))
    ends[BASE] = Placement(np.eye(3), np.zeros(3))
    joints = [replace(joint, placement=ends[joint.parent]) for joint in robot.joints]
    bodies = [
        RobotBody(body.mass, R @ body.com + place, R @ body.inertia @ R.T)
        for number, body in enumerate(robot.bodies)
        for R, place in [(ends[number].rotation, ends[number].position)]
    ]
    rotors = []
    for rotor in robot.rotors:
        frame = robot.frames[rotor.stator]
        link = frame.placement.rotation
        rotors.append(replace(rotor, axis=link.T @ ends[frame.body].rotation @ link @ rotor.axis))
    words = "every joint: turned before its constant transform, as of classic DH with modified DH's"
    moved = replace(robot, joints=tuple(joints), bodies=tuple(bodies), rotors=tuple(rotors))
    yield FrameMistake(f"{words} table", moved, several=True)


def _gravity_mistakes(robot: Robot) -> Iterator[FrameMistake]:
    size = float(np.linalg.norm(robot.gravity))
    for axis, sign in product(range(3), (-1, 1)) if size else ():
        gravity = sign * size * np.eye(3)[axis]
        if np.abs(gravity).argmax() != np.abs(robot.gravity).argmax():
            words = f"gravity along {AXES[axis]}, {sign * size:.6g} m/s^2"
            yield FrameMistake(words, replace(robot, gravity=gravity))


def _part_mistakes(
    robot: Robot,
    kind: PartKind,
    every: str,
    names: list[str],
    confused: list[Iterator[tuple[str, Any]]],
) -> Iterator[FrameMistake]:
    """Confusions of one part, and the same of all parts of a kind where there are several.

    confused: of each part words and the part so, alike in number and order.
    """
    for together in zip(*confused, strict=True):
        words = together[0][0]
        for number, (_, changed) in enumerate(together):
            yield FrameMistake(
                f"{names[number]}: {words}", replace_part(robot, kind, number, changed)
            )
        if len(together) > 1:
            changed_robot = _replace_parts(robot, kind, [changed for _, changed in together])
            yield FrameMistake(f"{every}: {words}", changed_robot, several=True)


def _joint_mistakes(joint: Joint) -> Iterator[tuple[str, Joint]]:
    """Words on what a joint's frame may be taken for, and the joint so."""
    turn, position = joint.placement.rotation, joint.placement.position
    yield "its axis the other way", replace(joint, axis=-joint.axis)
    yield "its place left out", replace(joint, placement=Placement(turn, np.zeros(3)))
    yield "its axis in the frame of the link before", replace(joint, axis=turn.T @ joint.axis)
    for axis, unit in zip(AXES, np.eye(3), strict=True):
        yield f"its axis {axis}", replace(joint, axis=unit)
    for words, other in (
        ("its frame turned the other way", turn.T),
        ("its frame not turned", np.eye(3)),
        (
            "its rpy turned in the other order, about x last",
            rotate_by(roll_pitch_yaw(turn), (2, 1, 0)),
        ),
        ("its quaternion w, x, y, z read as x, y, z, w", _roll_quaternion(turn, 1)),
        ("its quaternion x, y, z, w read as w, x, y, z", _roll_quaternion(turn, -1)),
    ):
        yield words, replace(joint, placement=Placement(other, position))
    yield (
        "its place turned with its frame",
        replace(joint, placement=Placement(turn, turn @ position)),
    )


def _roll_quaternion(turn: np.ndarray, places: int) -> np.ndarray:
    """The rotation by a quaternion x, y, z, w whose numbers are so many places further on."""
    moved = np.roll(Rotation.from_matrix(turn).as_quat(), places)
    rolled: np.ndarray = Rotation.from_quat(moved).as_matrix()
    return rolled


def rotate_by(angles: np.ndarray, order: Sequence[int]) -> np.ndarray:
    """The rotation by roll, pitch and yaw about fixed axes, in an order of these."""
    rotation = np.eye(3)
    for axis in order:
        i, j = (axis + 1) % 3, (axis + 2) % 3
        axis_rotation = np.eye(3)
        axis_rotation[i, i] = axis_rotation[j, j] = np.cos(angles[axis])
        axis_rotation[j, i] = np.sin(angles[axis])
        axis_rotation[i, j] = -axis_rotation[j, i]
        rotation = axis_rotation @ rotation
    return rotation


def _rotor_mistakes(rotor: Rotor) -> Iterator[tuple[str, Rotor]]:
    """Words on what a rotor's inertia and ratio may be taken for, and the rotor so."""
    yield (
        "the ratio once where its square belongs",
        replace(rotor, inertia=rotor.inertia / abs(rotor.ratio)),
    )
    yield "its ratio left out", replace(rotor, inertia=rotor.inertia / rotor.ratio**2)
    yield (
        "its ratio rounded down, as by integer division",
        replace(rotor, ratio=float(np.trunc(rotor.ratio)) or rotor.ratio),
    )
    yield "divided by its ratio's square", replace(rotor, inertia=rotor.inertia / rotor.ratio**4)
    yield "the sign of its ratio left out", replace(rotor, ratio=abs(rotor.ratio))


def _mimic_mistakes(robot: Robot) -> Iterator[FrameMistake]:
    """Confusions of how joints follow others."""
    for number, joint in enumerate(robot.joints):
        mimic = joint.mimic
        if mimic is None:
            continue
        by, offset = mimic.multiplier, mimic.offset
        for words, multiplier, moved in (
            ("its multiplier with the opposite sign", -by, offset),
            ("its multiplier left out", 1.0, offset),
            ("its multiplier twice", by**2, offset),
            ("the joint that it follows left out: it stands still", 0.0, offset),
            ("its offset left out", by, 0.0),
            ("its offset with the opposite sign", by, -offset),
            ("its offset multiplied too", by, by * offset),
        ):
            following = replace(mimic, multiplier=multiplier, offset=moved)
            changed = replace_part(robot, "joints", number, replace(joint, mimic=following))
            yield FrameMistake(f"joint {joint.name}: {words}", changed)


def generate_body_mistakes(
    body: RobotBody, joint: Joint, axes: np.ndarray
) -> Iterator[tuple[str, RobotBody]]:
    """Words on what a link's numbers may be taken for, and the link so.

    axes (3, 3): the rotation of those in which the file has its inertia.
    """
    yield "left out", RobotBody(0.0, body.com, 0 * body.inertia)
    yield "twice", RobotBody(2 * body.mass, body.com, 2 * body.inertia)
    about = compute_point_inertia(body.mass, body.com)
    stated = axes.T @ body.inertia @ axes
    diagonal = np.diag(np.diag(stated))
    yield AS_IT_STANDS, replace(body, inertia=stated)
    once = "its inertia turned once by the rpy of its inertial frame"
    yield f"{once}, R I for R I R'", replace(body, inertia=axes @ stated)
    yield f"{once}, I R' for R I R'", replace(body, inertia=stated @ axes.T)
    yield (
        "its inertia about the joint, taken for that about the centre of mass",
        replace(body, inertia=body.inertia + about),
    )
    yield (
        "its inertia about the centre of mass, taken for that about the joint",
        replace(body, inertia=body.inertia - about),
    )
    yield (
        "the parallel axis term m (c'c 1 - c c') with the opposite sign",
        replace(body, inertia=body.inertia - 2 * about),
    )
    yield "all products of inertia left out", replace(body, inertia=axes @ diagonal @ axes.T)
    yield (
        "all products of inertia with the opposite sign",
        replace(body, inertia=axes @ (2 * diagonal - stated) @ axes.T),
    )
    for first, second in combinations(range(3), 2):
        com = body.com.copy()
        com[[first, second]] = com[[second, first]]
        words = f"{AXES[first]} and {AXES[second]} of its centre of mass exchanged"
        yield words, replace(body, com=com)
    for keys in (MOMENTS, PRODUCTS):
        for first_key, second_key in combinations(keys, 2):
            exchanged = stated
            for key, source in ((first_key, second_key), (second_key, first_key)):
                exchanged = set_entry(exchanged, INERTIA[key], float(stated[INERTIA[source]]))
            inertia = axes @ exchanged @ axes.T
            yield f"I{first_key} and I{second_key} exchanged", replace(body, inertia=inertia)
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


def is_physical(robot: Robot, file_robot: Robot) -> bool:
    """Whether a robot is possible: no mass or inertia below that of points, nothing far away.

    A body that is none in the file already may be as little. Of a point or a thin rod in the file
    one moment may be given alone, for the others may turn nothing.
    """
    if _measure_reach(robot) > FAR * _measure_reach(file_robot):
        return False
    for body, file_body in zip(robot.bodies, file_robot.bodies, strict=True):
        positive, triangle = _excesses(body)
        file_positive, file_triangle = _excesses(file_body)
        least = min(positive, triangle) if file_triangle > ALIKE else positive
        if body is not file_body and least < min(file_positive, file_triangle, 0.0) - ALIKE:
            return False
    gears = [stage.gears.model_dump() for stage in robot.stages]
    values = [each[name] or 0.0 for each in gears for name in each if name in STAGE_FIELDS]
    return all(value >= 0 for value in (*(rotor.inertia for rotor in robot.rotors), *values))


def _measure_reach(robot: Robot) -> float:
    """The largest distance of a joint from the one before it, or of a centre from its joint [m]."""
    points = [joint.placement.position for joint in robot.joints]
    points += [body.com for body in robot.bodies]
    return max(float(np.linalg.norm(point)) for point in points)


def _excesses(body: RobotBody) -> tuple[float, float]:
    """The least of mass and moments, and what two moments are above the third, over their size."""
    moments = np.linalg.eigvalsh(body.inertia)
    size = max(float(np.abs(moments).max()), 1e-300)
    triangle = float(moments[0] + moments[1] - moments[2]) / size
    return float(min(moments[0] / size, np.sign(body.mass))), triangle


def list_equal_numbers(
    numbers: Iterable[RobotNumber], unit: str, value: float
) -> list[RobotNumber]:
    """Those of some numbers that have a unit and a value, which is not 0."""
    of_unit = (each for each in numbers if each.unit == unit and value and not each.factor)
    return [each for each in of_unit if abs(each.value - value) <= ALIKE * abs(value)]


def get_link_name(robot: Robot, number: int) -> str:
    """The URDF's name of the link that a joint moves."""
    return next(name for name, frame in robot.frames.items() if frame.body == number)


def replace_part(robot: Robot, kind: PartKind, number: int, part: object) -> Robot:
    """The robot with another body, joint, rotor or stage in place of one of these."""
    parts: list[object] = list(getattr(robot, kind))
    parts[number] = part
    changed: dict[str, Any] = {kind: tuple(parts)}
    return replace(robot, **changed)


def _replace_parts(robot: Robot, kind: PartKind, parts: Sequence[RobotPart]) -> Robot:
    """The robot with other bodies, joints or rotors."""
    changed: dict[str, Any] = {kind: tuple(parts)}
    return replace(robot, **changed)


def _move_joint(robot: Robot, number: int, axis: int, value: float) -> Robot:
    """The robot with another coordinate of a joint's place on the link before it."""
    old_placement = robot.joints[number].placement
    placement = Placement(old_placement.rotation, set_entry(old_placement.position, (axis,), value))
    return _set_field(robot, "joints", number, "placement", placement)


def _set_field(robot: Robot, kind: PartKind, number: int, field: str, value: object) -> Robot:
    """The robot with another value in a field of one of its parts."""
    return replace_part(
        robot, kind, number, replace(getattr(robot, kind)[number], **{field: value})
    )


def _set_gravity(robot: Robot, axis: int, value: float) -> Robot:
    return replace(robot, gravity=set_entry(robot.gravity, (axis,), value))


def set_entry(values: np.ndarray, place: tuple[int, ...], value: float) -> np.ndarray:
    """The values with another at a place; of a symmetric matrix at its mirror image too."""
    changed = values.copy()
    changed[place] = changed[place[::-1]] = value
    return changed

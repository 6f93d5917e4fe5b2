"""A robot with one thing taken for another: what may be wrong in its record, kind by kind.

A mistake is a row of the tables below: words that complete `with ...`, and the part that has it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations, permutations, product
from typing import Any, NamedTuple

import numpy as np

from crosscheck.analytic.robot.springs import stage_rotors
from crosscheck.models.robot import inertias
from crosscheck.models.robot.robot import (
    BASE,
    Joint,
    JointStage,
    Level,
    Placement,
    Robot,
    RobotBody,
    Rotor,
    compute_point_inertia,
)
from crosscheck.models.robot.urdf import read_urdf, roll_pitch_yaw
from crosscheck.trial.changes.numbers import (
    AXES,
    INERTIA,
    Path,
    get_link_name,
    get_value,
    name_part,
    put_value,
    rotate_by,
    set_entry,
)

ORDERS = [order for order in permutations(range(3)) if order != (0, 1, 2)]
UPPER = np.triu_indices(3)
EVERY = {"bodies": "every link", "joints": "every joint", "rotors": "every rotor"}
# Fields that parts may have exchanged, copied or shifted, by what they are called.
BODY_FIELDS: dict[str, tuple[Path, ...]] = {
    "mass": (("mass",),),
    "centre of mass": (("com",),),
    "inertia": (("inertia",),),
    "centre of mass and inertia": (("com",), ("inertia",)),
    "mass, centre and inertia": (("mass",), ("com",), ("inertia",)),
}
ROTOR_FIELDS: dict[str, tuple[Path, ...]] = {
    "ratio": (("ratio",),),
    "rotor's inertia": (("inertia",),),
    "rotor's ratio and inertia": (("ratio",), ("inertia",)),
}
TURN, PLACE = ("placement", "rotation"), ("placement", "position")
JOINT_FIELDS: dict[str, tuple[Path, ...]] = {
    "place": (PLACE,),
    "axis": (("axis",),),
    "frame's turn": (TURN,),
    "place and turn": (TURN, PLACE),
    "place, turn and axis": (TURN, PLACE, ("axis",)),
}


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

    @property
    def is_moved(self) -> bool:
        """Whether a fixed joint moves the link from the body's frame."""
        R = self.placement.rotation
        return bool(self.placement.position.any()) or not np.allclose(R, np.eye(3), atol=1e-6)

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


def list_part_mistakes(robot: Robot, part: BodyPart) -> dict[str, RobotBody]:
    """By words, what a link may be taken for, in the frame of its body."""
    joint = robot.joints[part.number]
    before = replace(joint, placement=part.placement) if part.is_moved else joint
    changed = dict(_confuse_body(part.in_link, before, part.turn))
    for link, place in _list_places_beyond(robot, part):
        moved = replace(part.in_link, com=place + part.in_link.com)
        changed[f"its centre of mass counted from {link}"] = moved
    bodies = {words: part.carry(body) for words, body in changed.items()}
    if part.is_moved:
        R, place = part.placement.rotation, part.placement.position
        for words, placement in (
            ("the place at which it is fixed left out", Placement(R, 0 * place)),
            ("the place at which it is fixed with the opposite sign", Placement(R, -place)),
            ("the turn of its fixed joint left out", Placement(np.eye(3), place)),
            ("the turn of its fixed joint the other way", Placement(R.T, place)),
        ):
            bodies[words] = part._replace(placement=placement).body
    return bodies


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


def _confuse_body(
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
    once = "its inertia turned once by the rpy of its inertial frame"
    inertia_of = {
        "its inertia as it stands, not turned by the rpy of its inertial frame": stated,
        f"{once}, R I for R I R'": axes @ stated,
        f"{once}, I R' for R I R'": stated @ axes.T,
        "its inertia about the joint, taken for that about the centre of mass": body.inertia
        + about,
        "its inertia about the centre of mass, taken for that about the joint": body.inertia
        - about,
        "the parallel axis term m (c'c 1 - c c') with the opposite sign": body.inertia - 2 * about,
        "all products of inertia left out": axes @ diagonal @ axes.T,
        "all products of inertia with the opposite sign": axes @ (2 * diagonal - stated) @ axes.T,
    }
    for first, second in combinations(INERTIA, 2):
        if (first[0] == first[1]) == (second[0] == second[1]):
            i, j = INERTIA[first], INERTIA[second]
            exchanged = set_entry(set_entry(stated, i, stated[j]), j, stated[i])
            inertia_of[f"I{first} and I{second} exchanged"] = axes @ exchanged @ axes.T
    for words, inertia in inertia_of.items():
        yield words, replace(body, inertia=inertia)
    for m, n in combinations(range(3), 2):
        order = list(range(3))
        order[m], order[n] = n, m
        words = f"{AXES[m]} and {AXES[n]} of its centre of mass exchanged"
        yield words, replace(body, com=body.com[order])
    for words, turn in (
        ("the frame of the link before it", joint.placement.rotation),
        ("its own frame, read as that of the link before", joint.placement.rotation.T),
    ):
        turned = turn @ body.inertia @ turn.T
        yield f"its inertia in {words}", replace(body, inertia=turned)
        yield f"its centre of mass in {words}", replace(body, com=turn @ body.com)
        both = RobotBody(body.mass, turn @ body.com, turned)
        yield f"its inertia and centre of mass in {words}", both


def list_frame_mistakes(robot: Robot, level: Level) -> Iterator[RobotMistake]:
    """Confusions of joints' frames and axes, rotors, stages and gravity that are easily made."""
    yield from _confuse_all(robot, "joints", _confuse_joint)
    if level != "links":
        yield from _confuse_all(robot, "rotors", _confuse_rotor)
    yield from _confuse_parents(robot)
    yield _confuse_order(robot)
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
    for i, j in combinations(range(3), 2):
        order = [{i: j, j: i}.get(axis, axis) for axis in range(3)]
        if abs(robot.gravity[i]) != abs(robot.gravity[j]) and robot.gravity[[i, j]].all():
            for sign, words in ((1, ""), (-1, ", with the opposite sign")):
                pulled = replace(robot, gravity=sign * robot.gravity[order])
                yield RobotMistake(f"{AXES[i]} and {AXES[j]} of gravity exchanged{words}", pulled)
    if level == "coupled":
        yield from _confuse_stators(robot)
    if level != "links":
        yield from _confuse_stages(robot)


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
    from scipy.spatial.transform import Rotation  # a third of a second, for robots alone

    turn, position = joint.placement.rotation, joint.placement.position
    quaternion = Rotation.from_matrix(turn).as_quat()
    yield "its axis the other way", replace(joint, axis=-joint.axis)
    yield "its axis in the frame of the link before", replace(joint, axis=turn.T @ joint.axis)
    for axis, unit in zip(AXES, np.eye(3), strict=True):
        yield f"its axis {axis}", replace(joint, axis=unit)
    for words, other, place in (
        ("its place left out", turn, 0 * position),
        ("its frame turned the other way", turn.T, position),
        ("its frame not turned", np.eye(3), position),
        (
            "its rpy turned in the other order, about x last",
            rotate_by(roll_pitch_yaw(turn), (2, 1, 0)),
            position,
        ),
        ("its quaternion w, x, y, z read as x, y, z, w", _read(np.roll(quaternion, 1)), position),
        ("its quaternion x, y, z, w read as w, x, y, z", _read(np.roll(quaternion, -1)), position),
        ("its place turned with its frame", turn, turn @ position),
    ):
        yield words, replace(joint, placement=Placement(other, place))


def _read(quaternion: np.ndarray) -> np.ndarray:
    """The rotation by a quaternion x, y, z, w."""
    from scipy.spatial.transform import Rotation

    rotation: np.ndarray = Rotation.from_quat(quaternion).as_matrix()
    return rotation


def _confuse_rotor(rotor: Rotor) -> Iterator[tuple[str, Rotor]]:
    """Words on what a rotor's inertia and ratio may be taken for, and the rotor so."""
    for words, by in (
        ("the ratio once where its square belongs", abs(rotor.ratio)),
        ("its ratio left out", rotor.ratio**2),
        ("divided by its ratio's square", rotor.ratio**4),
    ):
        yield words, replace(rotor, inertia=rotor.inertia / by)
    whole = float(np.trunc(rotor.ratio)) or rotor.ratio
    yield "its ratio rounded down, as by integer division", replace(rotor, ratio=whole)
    yield "the sign of its ratio left out", replace(rotor, ratio=abs(rotor.ratio))


def _confuse_parents(robot: Robot) -> Iterator[RobotMistake]:
    """Joints on links that stand beside them, and a tree taken for a chain."""
    chained = robot
    for number, joint in enumerate(robot.joints):
        path: Path = ("joints", number, "parent")
        for other in range(number - 1, -1, -1):
            is_beside = robot.joints[other].parent == joint.parent
            if other != joint.parent and (is_beside or other == number - 1):
                words = f"on {get_link_name(robot, other)}"
                usual = f" instead of {get_link_name(robot, joint.parent)}"
                words += ", as in a chain" if other == number - 1 else usual
                moved = put_value(robot, path, other)
                yield RobotMistake(f"{name_part(robot, 'joints', number)}: {words}", moved)
        chained = put_value(chained, path, number - 1)
    if sum(joint.parent != k - 1 for k, joint in enumerate(robot.joints)) > 1:
        yield RobotMistake(
            "every joint: on the link before it, as in a chain", chained, several=True
        )


def _confuse_order(robot: Robot) -> RobotMistake:
    """Joints that turn before the constant transform of their table, as in classic DH.

    Each link then ends where the next joint begins, and what it carries is placed there.
    """
    ends = dict(enumerate(joint.placement for joint in robot.joints))
    ends[BASE] = Placement(np.eye(3), np.zeros(3))
    joints = [replace(joint, placement=ends[joint.parent]) for joint in robot.joints]
    here = list_whole_bodies(robot)
    bodies = [each._replace(placement=ends[each.number]).body for each in here]
    rotors = []
    for rotor in robot.rotors:
        frame = robot.frames[rotor.stator]
        link = frame.placement.rotation
        rotors.append(replace(rotor, axis=link.T @ ends[frame.body].rotation @ link @ rotor.axis))
    words = "every joint: turned before its constant transform, as of classic DH with modified DH's"
    moved = replace(robot, joints=tuple(joints), bodies=tuple(bodies), rotors=tuple(rotors))
    return RobotMistake(f"{words} table", moved, several=True)


def _confuse_mimic(joint: Joint) -> Iterator[tuple[str, Any]]:
    """Words on how a joint that follows another may do so instead."""
    if (mimic := joint.mimic) is None:
        return
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
        yield words, replace(mimic, multiplier=multiplier, offset=moved)


def _confuse_stators(robot: Robot) -> Iterator[RobotMistake]:
    """Rotors on other links, or about other axes."""

    def place_usually(rotor: Rotor) -> Iterator[tuple[str, Rotor]]:
        joint = robot.joints[rotor.joint]
        parent = next(name for name, frame in robot.frames.items() if frame.body == joint.parent)
        axis = joint.placement.rotation @ joint.axis
        axis = robot.frames[parent].placement.rotation.T @ axis
        words = "on the link before its joint, along the joint's axis"
        yield words, replace(rotor, stator=parent, axis=axis)

    yield from _confuse_all(robot, "rotors", place_usually)
    for number, rotor in enumerate(robot.rotors):
        changed: dict[str, dict[str, Any]] = {}
        others = {frame.body: stator for stator, frame in reversed(list(robot.frames.items()))}
        for body, stator in others.items():  # one link of each body
            if body != robot.frames[rotor.stator].body:
                words = f"on {stator}" if body != BASE else f"on the ground, {stator}"
                changed[f"its stator {words}"] = {"stator": stator}
        for roll, axis in ((1, "y, z, x"), (2, "z, x, y")):
            changed[f"its axis in another order, {axis}"] = {"axis": np.roll(rotor.axis, roll)}
        for axis, unit in zip(AXES, np.eye(3), strict=True):
            changed[f"its axis {axis} of its stator"] = {"axis": unit}
        for words, fields in changed.items():
            moved = put_value(robot, ("rotors", number), replace(rotor, **fields))
            yield RobotMistake(f"{name_part(robot, 'rotors', number)}: {words}", moved)


def _confuse_stages(robot: Robot) -> Iterator[RobotMistake]:
    """Confusions of one planetary stage, and the same of every stage where there are several."""
    stages = robot.stages
    for together in zip(*(_confuse_stage(robot, each) for each in stages), strict=True):
        words = together[0][0]
        for number, (stage, (_, pair)) in enumerate(zip(stages, together, strict=True)):
            others = tuple(other for other in stages if other is not stage)
            changed = replace(robot, rotors=(*robot.rotors, *pair), stages=others)
            yield RobotMistake(f"{name_part(robot, 'stages', number)}: {words}", changed)
        if len(stages) > 1:
            rotors = tuple(rotor for _, pair in together for rotor in pair)
            changed = replace(robot, rotors=(*robot.rotors, *rotors), stages=())
            yield RobotMistake(f"every stage: {words}", changed, several=True)


def _confuse_stage(robot: Robot, stage: JointStage) -> Iterator[tuple[str, tuple[Rotor, Rotor]]]:
    """Words on what a stage's sun and planets may be taken for, and the rotors that they are so."""
    sun, planets = stage_rotors(robot, stage)
    gears = stage.gears
    for words, of_sun, of_planets in (
        ("its ratio z_r / z_s, that of a carrier held", sun.ratio - 1, planets.ratio),
        (
            "its sun's ratio rounded down, as by integer division",
            float(np.trunc(sun.ratio)),
            planets.ratio,
        ),
        ("its sun turning the other way", -sun.ratio, planets.ratio),
        ("its planets turning the other way", sun.ratio, -planets.ratio),
        ("its planets turning as on the carrier", sun.ratio, planets.ratio - 1),
        (
            "its planets rolling by the sun's teeth",
            sun.ratio,
            1 - gears.sun_teeth / gears.planet_teeth,
        ),
    ):
        yield words, (replace(sun, ratio=of_sun), replace(planets, ratio=of_planets))
    yield (
        "one planet for all",
        (sun, replace(planets, inertia=planets.inertia / gears.planet_count)),
    )
    swapped = gears.model_copy(
        update={
            f"{part}_{unit}": getattr(gears, f"{other}_{unit}")
            for part, other in (("sun", "planet"), ("planet", "sun"))
            for unit in ("equivalent_mass_kg", "inertia_kg_m2")
        }
    )
    swapped_sun, swapped_planets = stage_rotors(robot, replace(stage, gears=swapped))
    yield "sun's and planets' inertia exchanged", (swapped_sun, swapped_planets)


def list_joint_moves(robot: Robot) -> Iterator[RobotMistake]:
    """Places, axes and frames of joints: exchanged, copied, shifted, or their numbers reordered."""
    names = [name_part(robot, "joints", number) for number in range(len(robot.joints))]
    for words, changed in exchange_fields(names, robot.joints, JOINT_FIELDS):
        moved = robot
        for number, joint in changed.items():
            moved = put_value(moved, ("joints", number), joint)
        yield RobotMistake(words, moved)
    for number, joint in enumerate(robot.joints):
        for words, reordered in _reorder_joint(joint):
            moved = put_value(robot, ("joints", number), reordered)
            yield RobotMistake(f"{names[number]}: {words}", moved)


def _reorder_joint(joint: Joint) -> Iterator[tuple[str, Joint]]:
    """A joint's place, axis and rpy in other orders, or with one other sign."""
    position, angles = joint.placement.position, roll_pitch_yaw(joint.placement.rotation)
    for order in ORDERS:
        kept, listed = list(order), ", ".join(AXES[each] for each in order)
        yield f"its place in another order, {listed}", put_value(joint, PLACE, position[kept])
        yield f"its axis in another order, {listed}", replace(joint, axis=joint.axis[kept])
        words = f"its rpy in another order, about {listed}"
        yield words, put_value(joint, TURN, rotate_by(angles[kept]))
    for place, name in enumerate(("roll", "pitch", "yaw")):
        signs = 1 - 2 * np.eye(3)[place]
        words = f"{AXES[place]} of its axis with the opposite sign"
        yield words, replace(joint, axis=signs * joint.axis)
        yield (
            f"its {name} with the opposite sign",
            put_value(joint, TURN, rotate_by(signs * angles)),
        )


def list_body_exchanges(parts: Sequence[BodyPart]) -> Iterator[tuple[str, dict[int, RobotBody]]]:
    """Numbers of links that are exchanged, shifted or in another order, by the part's number."""
    bodies, names = [part.in_link for part in parts], [part.name for part in parts]
    yield from exchange_fields(names, bodies, BODY_FIELDS)
    together: dict[str, dict[int, RobotBody]] = {}
    for n, body in enumerate(bodies):
        for words, other in _reorder_body(body):
            together.setdefault(words, {})[n] = other
            yield f"{names[n]}: {words}", {n: other}
    for words, changed in together.items():
        if len(changed) > 1:
            yield f"every link: {words}", changed


def _reorder_body(body: RobotBody) -> Iterator[tuple[str, RobotBody]]:
    """A link's numbers in other orders that are no exchange of two."""
    for order in ORDERS:
        listed = ", ".join(AXES[axis] for axis in order)
        if all(axis != place for place, axis in enumerate(order)):
            words = f"its centre of mass in another order, {listed}"
            yield words, replace(body, com=body.com[list(order)])
        inertia = body.inertia[np.ix_(order, order)]
        yield f"the axes of its inertia in another order, {listed}", replace(body, inertia=inertia)
    numbers = body.inertia[UPPER]
    for order in inertias.ORDERS.values():
        listed = ", ".join(inertias.SLOTS[slot][1:] for slot in np.argsort(order))
        inertia = np.zeros((3, 3))
        inertia[UPPER] = inertia.T[UPPER] = numbers[list(order)]
        yield f"its six inertias read in the order {listed}", replace(body, inertia=inertia)


def exchange_fields(
    names: Sequence[str], records: Sequence[Any], fields: dict[str, tuple[Path, ...]]
) -> Iterator[tuple[str, dict[int, Any]]]:
    """Records with fields of others: exchanged, taken from another one, shifted by one."""
    count = len(records)
    for what, paths in fields.items():
        values = [[get_value(record, path) for path in paths] for record in records]
        moves = dict[str, dict[int, int]]()  # from where each record has the fields
        for m, n in combinations(range(count), 2):
            # Of records that share a number fewer fields say as much.
            if not any(np.array_equal(a, b) for a, b in zip(values[m], values[n], strict=True)):
                moves[f"{names[m]} and {names[n]}: {what} exchanged"] = {m: n, n: m}
                moves[f"{names[m]}: {what} of {names[n]}"] = {m: n}
                moves[f"{names[n]}: {what} of {names[m]}"] = {n: m}
        for by, which in ((1, "next"), (-1, "one before")) if count > 2 else ():
            shifted = {n: (n + by) % count for n in range(count)}
            moves[f"every part has the {what} of the {which}"] = shifted
        if count > 2:
            moves[f"{what} of all in the opposite order"] = {n: count - 1 - n for n in range(count)}
        for words, sources in moves.items():
            changed = dict(enumerate(records))
            for number, source in sources.items():
                for path, value in zip(paths, values[source], strict=True):
                    changed[number] = put_value(changed[number], path, value)
            yield words, {number: changed[number] for number in sources}

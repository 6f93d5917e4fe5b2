"""Numbers of a robot that are exchanged, shifted, copied or in another order, in any field alike.

Terms are a linear sum over ten parameters of each body (mass, first moments, inertia about the
joint) and three of each rotor (J n^2, J n, J). So any mistake in bodies and rotors is
a change of these, and all changes are tried at once. Places and axes of joints are tried one by
one.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import combinations, permutations
from typing import Any, NamedTuple

import numpy as np

from crosscheck.models.robot import inertias
from crosscheck.models.robot.robot import (
    Level,
    Placement,
    Robot,
    RobotBody,
    Rotor,
    compute_point_inertia,
)
from crosscheck.models.robot.urdf import roll_pitch_yaw
from crosscheck.planning.springs import stage_rotors
from crosscheck.trial.changes.kane import BodyPart, DynamicsTerms, KaneSum
from crosscheck.trial.changes.numbers import (
    AXES,
    INERTIA,
    FrameMistake,
    replace_part,
    rotate_by,
    set_entry,
)

BODY_SIZE, ROTOR_SIZE = 10, 3  # parameters of each
UPPER = np.triu_indices(3)
ORDERS = [order for order in permutations(range(3)) if order != (0, 1, 2)]
Changed = Mapping[int, Any]  # values of a field by the number of the part that has them


class PieceChange(NamedTuple):
    """A change of parameters (10 bodies + 3 rotors,), in words that complete `with ...`."""

    words: str
    change: np.ndarray


class Spinner(NamedTuple):
    """A rotor, a sun or the planets of a stage, by its name in words."""

    name: str
    rotor: Rotor


def list_spinners(robot: Robot) -> list[Spinner]:
    """All rotors of a robot, those of its stages among them."""
    spinners = [Spinner(robot.joints[each.joint].name, each) for each in robot.rotors]
    for stage in robot.stages:
        joint = robot.joints[stage.joint].name
        names = f"the sun of {joint}", f"the planets of {joint}"
        spinners += map(Spinner, names, stage_rotors(robot, stage))
    return spinners


def list_unit_bodies() -> Iterator[RobotBody]:
    """Bodies whose parameters add up with any factors to those of every body.

    Each is of mass 1 (for 0 has no centre), so that a parameter's effect is one less the first's.
    """
    yield RobotBody(1.0, np.zeros(3), np.zeros((3, 3)))
    for com in np.eye(3):
        yield RobotBody(1.0, com, -compute_point_inertia(1.0, com))
    for i, j in zip(*UPPER, strict=True):
        yield RobotBody(1.0, np.zeros(3), set_entry(np.zeros((3, 3)), (int(i), int(j)), 1.0))


def list_rotor_effects(kane: KaneSum, level: Level) -> Iterator[list[DynamicsTerms]]:
    """Effects of J n^2, J n and J on the terms, for each spinner."""
    for _, rotor in list_spinners(kane.robot):
        forward, backward, still = (
            kane.move_rotor(replace(rotor, ratio=ratio, inertia=1.0), level).compute_terms()
            for ratio in (1.0, -1.0, 0.0)
        )
        each = list(zip(forward, backward, still, strict=True))
        square = DynamicsTerms(*((a + b) / 2 - c for a, b, c in each))
        yield [square, DynamicsTerms(*((a - b) / 2 for a, b, _ in each)), still]


def list_piece_changes(robot: Robot, parts: Sequence[BodyPart]) -> Iterator[PieceChange]:
    """Every change of links' and rotors' numbers."""
    spinners = list_spinners(robot)
    first = BODY_SIZE * len(robot.bodies)
    size = first + ROTOR_SIZE * len(spinners)

    def change_bodies(changed: Changed) -> np.ndarray:
        change = np.zeros(size)
        for number, body in changed.items():
            part = parts[number]
            start = BODY_SIZE * part.number
            after, before = _body_parameters(part.carry(body)), _body_parameters(part.body)
            change[start : start + BODY_SIZE] += after - before
        return change

    def change_rotors(changed: Changed) -> np.ndarray:
        change = np.zeros(size)
        for number, parameters in changed.items():
            start = first + ROTOR_SIZE * number
            change[start : start + ROTOR_SIZE] = parameters - _rotor_parameters(
                spinners[number].rotor
            )
        return change

    for words, changed in _list_body_changes(parts):
        yield PieceChange(words, change_bodies(changed))
    for words, changed in _list_rotor_changes(robot, spinners):
        yield PieceChange(words, change_rotors(changed))


def _body_parameters(body: RobotBody) -> np.ndarray:
    about = body.inertia + compute_point_inertia(body.mass, body.com)
    return np.array([body.mass, *body.mass * body.com, *about[UPPER]])


def _rotor_parameters(rotor: Rotor) -> np.ndarray:
    return rotor.inertia * np.array([rotor.ratio**2, rotor.ratio, 1.0])


def _list_body_changes(parts: Sequence[BodyPart]) -> Iterator[tuple[str, Changed]]:
    bodies, names = [part.in_link for part in parts], [part.name for part in parts]
    fields = {
        "mass": ("mass",),
        "centre of mass": ("com",),
        "inertia": ("inertia",),
        "centre of mass and inertia": ("com", "inertia"),
        "mass, centre and inertia": ("mass", "com", "inertia"),
    }
    for what, keys in fields.items():
        values = [[getattr(body, key) for key in keys] for body in bodies]
        for words, changed in move_values(names, values, what):
            yield (
                words,
                {
                    n: replace(bodies[n], **dict(zip(keys, each, strict=True)))
                    for n, each in changed.items()
                },
            )
    entries = [(n, (axis,)) for n in range(len(parts)) for axis in range(3)]
    for (m, a), (n, b) in combinations(entries, 2):
        if m != n and bodies[m].com[a] != bodies[n].com[b]:
            words = f"{AXES[a[0]]} of {names[m]}'s and {AXES[b[0]]} of {names[n]}'s centre of mass"
            yield f"{words} exchanged", _exchange_entries(bodies, "com", (m, a), (n, b))
    for key, place in INERTIA.items():
        for m, n in combinations(range(len(parts)), 2):
            if bodies[m].inertia[place] != bodies[n].inertia[place]:
                pair = (m, place), (n, place)
                words = f"I{key} of {names[m]} and of {names[n]} exchanged"
                yield words, _exchange_entries(bodies, "inertia", *pair)
    together: dict[str, dict[int, RobotBody]] = {}
    for n, body in enumerate(bodies):
        for words, other in _list_orders_within(body):
            together.setdefault(words, {})[n] = other
            yield f"{names[n]}: {words}", {n: other}
    for words, changed in together.items():
        if len(changed) > 1:
            yield f"every link: {words}", changed


def _exchange_entries(
    bodies: Sequence[RobotBody], field: str, left: tuple[int, Any], right: tuple[int, Any]
) -> Changed:
    (m, a), (n, b) = left, right
    changed = {}
    for number, place, value in (
        (m, a, getattr(bodies[n], field)[b]),
        (n, b, getattr(bodies[m], field)[a]),
    ):
        entries = set_entry(getattr(bodies[number], field), place, float(value))
        changed[number] = replace(bodies[number], **{field: entries})  # type: ignore[arg-type]
    return changed


def _list_orders_within(body: RobotBody) -> Iterator[tuple[str, RobotBody]]:
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
        inertia[UPPER] = numbers[list(order)]
        inertia.T[UPPER] = inertia[UPPER]
        yield f"its six inertias read in the order {listed}", replace(body, inertia=inertia)


def _list_rotor_changes(robot: Robot, spinners: Sequence[Spinner]) -> Iterator[tuple[str, Changed]]:
    rotors, names = [each.rotor for each in spinners], [each.name for each in spinners]
    fields: dict[str, tuple[str, ...]] = {"ratio": ("ratio",), "rotor's inertia": ("inertia",)}
    fields["rotor's ratio and inertia"] = ("ratio", "inertia")
    for what, keys in fields.items():
        values = [[getattr(rotor, key) for key in keys] for rotor in rotors]
        for words, moved in move_values(names, values, what):
            changed = {
                n: replace(rotors[n], **dict(zip(keys, each, strict=True)))
                for n, each in moved.items()
            }
            yield words, {n: _rotor_parameters(rotor) for n, rotor in changed.items()}
    terms = "in its joint's own term", "in its coupling with other joints"
    for n, rotor in enumerate(rotors):
        right, ratio = _rotor_parameters(rotor), abs(rotor.ratio)
        for place, words, by in (
            (0, f"the ratio once where its square belongs, {terms[0]} alone", 1 / ratio),
            (1, f"the ratio's square where it belongs once, {terms[1]}", ratio),
            (1, f"the ratio left out {terms[1]}", 1 / ratio),
            (1, "no coupling with other joints", 0.0),
            (1, "its coupling with other joints with the opposite sign", -1.0),
            (2, "its turning with the link that carries it left out", 0.0),
        ):
            parameters = right.copy()
            parameters[place] *= by
            yield f"rotor of {names[n]}: {words}", {n: parameters}
    together: list[tuple[int, list[Rotor]]] = []
    for number, stage in enumerate(robot.stages):
        gears = stage.gears
        swapped = gears.model_copy(
            update={
                f"{part}_{unit}": getattr(gears, f"{other}_{unit}")
                for part, other in (("sun", "planet"), ("planet", "sun"))
                for unit in ("equivalent_mass_kg", "inertia_kg_m2")
            }
        )
        swapped_pair = stage_rotors(robot, replace(stage, gears=swapped))
        together.append((len(robot.rotors) + 2 * number, list(swapped_pair)))
    words = "sun's and planets' inertia exchanged"
    pairs = [{k + m: _rotor_parameters(r) for m, r in enumerate(rotors)} for k, rotors in together]
    for stage, pair in zip(robot.stages, pairs, strict=True):
        yield f"stage of {robot.joints[stage.joint].name}: {words}", pair
    if len(pairs) > 1:
        yield f"every stage: {words}", dict(each for pair in pairs for each in pair.items())


def move_values(
    names: Sequence[str], values: Sequence[Any], what: str
) -> Iterator[tuple[str, dict[int, Any]]]:
    """Values of a field of several parts: exchanged, taken from another one, shifted by one."""
    count = len(names)
    for m, n in combinations(range(count), 2):
        if not _share_any(values[m], values[n]):
            yield f"{names[m]} and {names[n]}: {what} exchanged", {m: values[n], n: values[m]}
            yield f"{names[m]}: {what} of {names[n]}", {m: values[n]}
            yield f"{names[n]}: {what} of {names[m]}", {n: values[m]}
    if count > 2:
        for by, which in ((1, "next"), (-1, "one before")):
            moved = {n: values[(n + by) % count] for n in range(count)}
            yield f"every part has the {what} of the {which}", moved
        yield f"{what} of all in the opposite order", dict(enumerate(values[::-1]))


def _share_any(left: Any, right: Any) -> bool:
    """Whether two lists share a number or array: fewer fields then say as much."""
    return any(np.array_equal(a, b) for a, b in zip(left, right, strict=True))


def generate_joint_moves(robot: Robot) -> Iterator[FrameMistake]:
    """Places, axes and frames of joints: exchanged, copied, shifted, or their numbers reordered."""
    joints, names = robot.joints, [f"joint {joint.name}" for joint in robot.joints]

    def put(number: int, values: Sequence[Any]) -> Any:
        turn, position, axis = values
        return replace(joints[number], placement=Placement(turn, position), axis=axis)

    def get(number: int) -> list[Any]:
        joint = joints[number]
        return [joint.placement.rotation, joint.placement.position, joint.axis]

    whole = [get(number) for number in range(len(joints))]
    fields = {"place": (1,), "axis": (2,), "frame's turn": (0,), "place and turn": (0, 1)}
    fields["place, turn and axis"] = (0, 1, 2)
    for what, kept in fields.items():
        values = [[each[place] for place in kept] for each in whole]
        for words, moved in move_values(names, values, what):
            changed_robot = robot
            for number, taken in moved.items():
                parts = list(whole[number])
                for place, value in zip(kept, taken, strict=True):
                    parts[place] = value
                changed_robot = replace_part(changed_robot, "joints", number, put(number, parts))
            yield FrameMistake(words, changed_robot)
    entries = [(n, axis) for n in range(len(joints)) for axis in range(3)]
    for (m, a), (n, b) in combinations(entries, 2):
        left, right = whole[m][1][a], whole[n][1][b]
        if left != right and m != n:
            changed_robot = robot
            for number, axis, value in ((m, a, right), (n, b, left)):
                turn, position, along = whole[number]
                moved_joint = put(number, (turn, set_entry(position, (axis,), float(value)), along))
                changed_robot = replace_part(changed_robot, "joints", number, moved_joint)
            words = f"{AXES[a]} of {names[m]}'s and {AXES[b]} of {names[n]}'s place exchanged"
            yield FrameMistake(words, changed_robot)
    for number in range(len(joints)):
        change = partial(replace_part, robot, "joints", number)
        for words, reordered in _list_joint_orders(*whole[number]):
            yield FrameMistake(f"{names[number]}: {words}", change(put(number, reordered)))


def _list_joint_orders(
    turn: np.ndarray, position: np.ndarray, axis: np.ndarray
) -> Iterator[tuple[str, tuple[np.ndarray, np.ndarray, np.ndarray]]]:
    """A joint's place, axis and rpy in other orders, or with one other sign."""
    angles = roll_pitch_yaw(turn)
    for order in ORDERS:
        kept, listed = list(order), ", ".join(AXES[each] for each in order)
        yield f"its place in another order, {listed}", (turn, position[kept], axis)
        yield f"its axis in another order, {listed}", (turn, position, axis[kept])
        spun = rotate_by(angles[kept], (0, 1, 2))
        yield f"its rpy in another order, about {listed}", (spun, position, axis)
    for place in range(3):
        signs = 1 - 2 * np.eye(3)[place]
        name = ("roll", "pitch", "yaw")[place]
        yield f"{AXES[place]} of its axis with the opposite sign", (turn, position, signs * axis)
        spun = rotate_by(signs * angles, (0, 1, 2))
        yield f"its {name} with the opposite sign", (spun, position, axis)

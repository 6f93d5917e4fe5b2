"""Which number, or which thing taken for another, makes a difference: of all parts, or of one."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from crosscheck.analytic.robot.model import AnalyticRobot
from crosscheck.checks.robots.sizes import TOLERANCE
from crosscheck.models.robot.robot import (
    Level,
    Placement,
    Robot,
    RobotBody,
    compute_point_inertia,
)
from crosscheck.trial.robots.angle_sums import measure_rest
from crosscheck.trial.robots.candidates import (
    ALIKE,
    AS_IT_STANDS,
    USUAL,
    FrameMistake,
    RobotNumber,
    generate_body_mistakes,
    generate_frame_mistakes,
    get_link_name,
    is_physical,
    list_numbers,
)
from crosscheck.trial.robots.exchanges import (
    generate_joint_moves,
    list_piece_changes,
    list_rotor_effects,
    list_unit_bodies,
)
from crosscheck.trial.robots.judge import RobotEntry, RobotProblem, select_entry
from crosscheck.trial.robots.motions import ByPlace, MotionTable
from crosscheck.trial.robots.pieces import (
    BodyPart,
    DynamicsTerms,
    KaneSum,
    WorldBody,
    list_body_parts,
    list_unturned_bodies,
    list_whole_bodies,
)

# What an explanation may leave of each entry's largest difference; and of its size, by rounding.
LEFT, ROUNDING = 1e-5, 1e-12
CLOSE = 1e-4  # of a difference's norm that a number's effect may leave before it is tried
PROMISING = 0.9  # of a difference's norm that a curved number's first step may leave
STEPS = 12  # of Newton's method
NEAR = 1e-4  # of a curved number's step: over which its slope is taken
MATRICES = ("mass_matrix", "gravity")  # parts of q alone, by which robots are screened
MOST_SCREENED = 64  # places of a row, those of the largest differences, at which all are screened
Places = np.ndarray | slice  # of a row


@dataclass(frozen=True)
class Cause:
    """What makes a difference, in words that complete `with ...`.

    usual: whether the number is 0, has the other sign, is twice or half as large or is another of
    the file, so that somebody may well have written it. missing: name of a number that is 0.
    """

    words: str
    usual: bool
    missing: str = ""


class NumberEffect(NamedTuple):
    """What a change of a number by its step does to all terms: linear in it, and by its square."""

    number: RobotNumber
    linear: DynamicsTerms
    square: DynamicsTerms
    place: str = ""  # the one term of the balance in which it is made, in words


class MistakeEffect(NamedTuple):
    """What one thing taken for another does to all terms; several: in every part of a kind."""

    words: str
    several: bool
    change: DynamicsTerms


class ChangeTable:
    """What each change of a robot does to its terms at the states, for all levels."""

    def __init__(self, problem: RobotProblem) -> None:
        self.robot, self.states = problem.robot, problem.states
        self.bare = replace(self.robot, rotors=(), stages=())
        self.numbers = list(list_numbers(self.robot))
        self._numbers_by_level: dict[Level, list[NumberEffect]] = {}
        self._mistakes_by_level: dict[Level, list[MistakeEffect]] = {}
        self._bases: dict[Level, DynamicsTerms] = {}
        self.kane = KaneSum(self.bare, self.states.q, self.states.v)
        self._placed = [
            self.kane.compute_terms(number, self.kane.place_body(number, body))
            for number, body in enumerate(self.robot.bodies)
        ]

    @cached_property
    def piece_changes(self) -> tuple[np.ndarray, list[str]]:
        """Changes of the parameters of bodies and rotors (changes, parameters), and their words."""
        parts, bodies = list_body_parts(self.robot), list_whole_bodies(self.robot)
        changes = list(list_piece_changes(self.robot, parts))
        if len(parts) > len(bodies):
            changes += list_piece_changes(self.robot, bodies)
        by_words = {each.words: each.change for each in reversed(changes) if each.change.any()}
        size = len(changes[0].change) if changes else 0
        return np.reshape(list(by_words.values())[::-1], (-1, size)), list(by_words)[::-1]

    @cached_property
    def joint_moves(self) -> list[FrameMistake]:
        """Robots with joints whose places, axes or frames are exchanged or in another order."""
        return list(generate_joint_moves(self.robot))

    def change_body(self, number: int, body: RobotBody) -> DynamicsTerms:
        """What another body in the place of one does."""
        placed = self.kane.place_body(number, body)
        return self.kane.compute_terms(number, placed).minus(self._placed[number])

    def change_robot(self, robot: Robot, level: Level, bodies: Sequence[int] = ()) -> DynamicsTerms:
        """What another robot does at a level; bodies: numbers of those that alone are others."""
        if bodies:
            return add_terms(self.change_body(number, robot.bodies[number]) for number in bodies)
        return DynamicsTerms(*AnalyticRobot(robot, level).terms(*self.states[:2])).minus(
            self._base(level)
        )

    def list_number_effects(self, level: Level) -> list[NumberEffect]:
        """Of each number that changes something at a level."""
        if level not in self._numbers_by_level:
            effects = self._numbers_by_level[level] = []
            shared = {each.number.name: each for each in self._numbers_by_level.get("links", [])}
            for number in self._select_numbers(level):
                if number.name in shared and (number.bodies or level == "armature"):
                    effects.append(shared[number.name])
                    continue
                up, down = (
                    self.change_robot(
                        number.put(number.value + sign * number.step), level, number.bodies
                    )
                    for sign in (1, -1)
                )
                linear = DynamicsTerms(*((a - b) / 2 for a, b in zip(up, down, strict=True)))
                square = DynamicsTerms(*((a + b) / 2 for a, b in zip(up, down, strict=True)))
                effects.append(NumberEffect(number, linear, square))
        return self._numbers_by_level[level]

    def _select_numbers(self, level: Level) -> Iterator[RobotNumber]:
        for number in self.numbers:
            of_rotors = "rotor" in number.name or number.name.startswith("stage")
            if not number.curved and (level != "links" or not of_rotors):
                yield number

    def list_mistake_effects(self, level: Level) -> list[MistakeEffect]:
        """Of each thing that may be taken for another at a level."""
        if level not in self._mistakes_by_level:
            mistakes = self._mistakes_by_level[level] = list(self._body_mistakes)
            robot = self.bare if level == "links" else self.robot
            shared: dict[str, MistakeEffect] = {}
            if level == "armature" and all(joint.mimic is None for joint in robot.joints):
                shared = {each.words: each for each in self.list_mistake_effects("links")}
            mistakes += [
                shared.get(each.words)
                or MistakeEffect(each.words, each.several, self.change_robot(each.robot, level))
                for each in generate_frame_mistakes(robot, are_rotors_bodies=level == "coupled")
            ]
        return self._mistakes_by_level[level]

    @cached_property
    def _body_mistakes(self) -> list[MistakeEffect]:
        """Of each link as the URDF has it, then of bodies of which several links are fixed."""
        parts, bodies = list_body_parts(self.robot), list_whole_bodies(self.robot)
        mistakes = self._list_part_mistakes(parts, "")
        if len(parts) > len(bodies):
            mistakes += self._list_part_mistakes(bodies, ", with what is fixed to it")
        return mistakes

    def _list_part_mistakes(self, parts: Sequence[BodyPart], merged: str) -> list[MistakeEffect]:
        """Of each part, and the same of every one; merged: words on what the parts are."""
        rows = [self._list_mistakes_of(part) for part in parts]
        mistakes = [
            MistakeEffect(f"{part.name}{merged}: {words}", False, change)
            for part, row in zip(parts, rows, strict=True)
            for words, change in row.items()
            if words != AS_IT_STANDS or not _is_identity(part.turn)
        ]
        shared = [words for words in rows[0] if all(words in row for row in rows)]
        for words in shared if len(rows) > 1 else ():
            if words != AS_IT_STANDS or not all(_is_identity(part.turn) for part in parts):
                change = add_terms(row[words] for row in rows)
                mistakes.append(MistakeEffect(f"every link{merged}: {words}", True, change))
        return mistakes

    def _list_mistakes_of(self, part: BodyPart) -> dict[str, DynamicsTerms]:
        """By words, what each mistake in a part does to the terms."""
        number = part.number
        right = self.kane.compute_terms(number, self.kane.place_body(number, part.body))
        changed = self._list_changed_bodies(part)
        return {w: self.kane.compute_terms(number, b).minus(right) for w, b in changed.items()}

    def _list_changed_bodies(self, part: BodyPart) -> dict[str, WorldBody]:
        """By words, what a part may be taken for."""
        joint, number, pose = self.robot.joints[part.number], part.number, self.kane.poses
        is_moved = part.placement.position.any() or not _is_identity(part.placement.rotation)
        before = replace(joint, placement=part.placement) if is_moved else joint
        changed = {
            words: self.kane.place_body(number, part.carry(other))
            for words, other in generate_body_mistakes(part.in_link, before, part.turn)
        }
        turn = pose[number].rotation @ part.placement.rotation
        shift = pose[number].rotation @ part.placement.position
        unturned = list_unturned_bodies(turn, part.in_link)
        if self._has_inertial_axes:
            axes, link = part.turn, part.in_link
            stated = RobotBody(link.mass, axes.T @ link.com, axes.T @ link.inertia @ axes)
            unturned |= {
                f"{words}, by the axes of its inertial frame": body
                for words, body in list_unturned_bodies(turn @ axes, stated).items()
                if words.startswith("its inertia")
            }
        changed |= {w: b._replace(lever=b.lever + shift) for w, b in unturned.items()}
        if is_moved:
            R, place = part.placement.rotation, part.placement.position
            for words, placement in (
                ("the place at which it is fixed left out", Placement(R, 0 * place)),
                ("the place at which it is fixed with the opposite sign", Placement(R, -place)),
                ("the turn of its fixed joint left out", Placement(np.eye(3), place)),
                ("the turn of its fixed joint the other way", Placement(R.T, place)),
            ):
                body = part._replace(placement=placement).body
                changed[words] = self.kane.place_body(number, body)
        return changed

    @cached_property
    def _has_inertial_axes(self) -> bool:
        """Whether the file has the inertia of any link in other axes than the link's."""
        return not all(_is_identity(part.turn) for part in list_body_parts(self.robot))

    def generate_motion_changes(self, level: Level) -> Iterator[tuple[str, ByPlace]]:
        """Mistakes in Kane's sum in words, each with what it changes by the body that has it."""
        parts, bodies = list_body_parts(self.robot), list_whole_bodies(self.robot)
        kane = KaneSum(self.robot, self.states.q, self.states.v)
        table = MotionTable(kane, level)
        yield from table.generate({p.name: (p, self._list_changed_bodies(p)) for p in parts})
        if len(parts) > len(bodies):
            named = {f"{each.name}, with what is fixed to it": each for each in bodies}
            yield from table.generate(
                {name: (each, self._list_changed_bodies(each)) for name, each in named.items()}
            )

    def _base(self, level: Level) -> DynamicsTerms:
        if level not in self._bases:
            self._bases[level] = DynamicsTerms(
                *AnalyticRobot(self.robot, level).terms(*self.states[:2])
            )
        return self._bases[level]


def add_terms(several: Iterator[DynamicsTerms]) -> DynamicsTerms:
    """The sum of several terms."""
    return DynamicsTerms(*(np.sum(each, axis=0) for each in zip(*several, strict=True)))


class CauseSearch:
    """The search for what makes the difference between equations and a level.

    Rows hold the entries of all parts at all states over their sizes. Accelerations are held in
    the balance that they make, M a + bias + gravity - torques, on which numbers act by at most
    their square as well.
    """

    def __init__(self, problem: RobotProblem, level: Level, table: ChangeTable) -> None:
        self.problem, self.level, self.table = problem, level, table
        self.difference = self._compute_difference()
        self.allowed = self._compute_allowances()

    def row(self, change: DynamicsTerms) -> np.ndarray:
        """What a change of the terms makes of all parts, in one row."""
        mass, bias, gravity = change
        values, held = self.problem.answers.values, change.bias + change.gravity
        parts = {
            "mass_matrix": mass,
            "bias": bias,
            "gravity": gravity,
            "force": -self.problem.weights_in_force(gravity),
        }
        if "inverse_dynamics" in values:
            whole = bias if self.problem.answers.weightless else held
            parts["inverse_dynamics"] = _multiply(mass, self.problem.states.a) + whole
        if "acceleration" in values:
            parts["acceleration"] = _multiply(mass, values["acceleration"]) + held
        return self._join_parts(parts)

    def _compute_difference(self) -> np.ndarray:
        values = self.problem.answers.values
        right = self.problem.reference_values[self.level]
        parts = {part: values[part] - right[part] for part in self.problem.parts}
        if "acceleration" in parts:
            mass = AnalyticRobot(self.problem.robot, self.level).mass_matrix(self.problem.states.q)
            parts["acceleration"] = -_multiply(mass, parts["acceleration"])
        return self._join_parts(parts)

    def _join_parts(self, parts: dict[str, np.ndarray]) -> np.ndarray:
        sizes = self.problem.sizes[self.level]
        scaled = {
            part: parts[part] / sizes.entry_sizes("balance" if part == "acceleration" else part)
            for part in self.problem.parts
        }
        return np.concatenate([each.ravel() for each in scaled.values()])

    def _compute_allowances(self) -> np.ndarray:
        """What an explanation may leave at each place of a row.

        An entry's own difference decides, so that a large one elsewhere hides nothing here.
        """
        sizes, allowances, start = self.problem.sizes[self.level], list[np.ndarray](), 0
        for part in self.problem.parts:
            shape = self.problem.answers.values[part].shape
            stop = start + int(np.prod(shape))
            largest = np.abs(self.difference[start:stop].reshape(shape)).max(axis=0)
            rounding = sizes.tolerance(part) if part == "acceleration" else ROUNDING
            allowances.append(np.broadcast_to(np.maximum(rounding, LEFT * largest), shape).ravel())
            start = stop
        return np.concatenate(allowances)

    def can_explain(self, change: np.ndarray, places: Places = slice(None)) -> bool:
        """Whether a change of the row leaves nothing of the difference at some places of it."""
        left = np.abs(self.difference[places] - change[places])
        return bool((left <= self.allowed[places]).all())

    def select_places(self, part: str = "", entry: RobotEntry | None = None) -> np.ndarray:
        """Which places of a row belong to a part, or to an entry and its mirror image."""
        places = []
        for each in self.problem.parts:
            shape = self.problem.answers.values[each].shape
            inside = np.full(shape, entry is None and each == part)
            if entry is not None and each == entry.part:
                for place in {entry.place, entry.place[::-1]}:
                    select_entry(inside, place)[:] = True
            places.append(inside.ravel())
        return np.concatenate(places)

    def select_wrong_places(self, entries: Sequence[RobotEntry]) -> np.ndarray:
        """Which places of a row belong to some entries."""
        return np.any([self.select_places(entry=entry) for entry in entries], axis=0)

    @cached_property
    def _effects(self) -> tuple[list[NumberEffect], np.ndarray, np.ndarray]:
        """Effects, and what of a row (effects, places) each makes: linear in it, by its square."""
        effects = [
            NumberEffect(each.number, linear, square, place)
            for each in self.table.list_number_effects(self.level)
            for place, (linear, square) in self._list_places(each.linear, each.square)
        ]
        linear_rows = np.array([self.row(each.linear) for each in effects])
        return effects, linear_rows, np.array([self.row(each.square) for each in effects])

    @cached_property
    def _mistakes(self) -> list[tuple[MistakeEffect, np.ndarray]]:
        return [
            (each._replace(words=each.words + place), self.row(change))
            for each in self.table.list_mistake_effects(self.level)
            for place, (change,) in self._list_places(each.change)
        ]

    def _list_places(
        self, *changes: DynamicsTerms
    ) -> Iterator[tuple[str, tuple[DynamicsTerms, ...]]]:
        """Changes of all terms, and of each alone where a balance alone tells that it is wrong."""
        yield "", changes
        if set(self.problem.parts) != {"acceleration"}:
            return
        there = [n for n in range(3) if any(each[n].any() for each in changes)]
        for number in there if len(there) > 1 else ():
            name = DynamicsTerms._fields[number]
            yield (
                f", in its {name} alone",
                tuple(
                    DynamicsTerms(*(term * (n == number) for n, term in enumerate(each)))
                    for each in changes
                ),
            )

    def find_causes(self, places: Places = slice(None)) -> list[Cause]:
        """Every single change that leaves nothing of the difference in some places of the row."""
        numbers = list(self._number_causes(places))
        plain = [cause for number, cause in numbers if not number.factor]
        numbers_alone = plain or [cause for _, cause in numbers]  # a factor says no more than one
        causes = [*numbers_alone, *self._mistake_causes(places)]
        if isinstance(places, slice) and self.level == "coupled":
            causes += self._missing_pairs()
        if not any(cause.usual for cause in causes):
            causes += self._piece_causes(places)
        return causes

    def _number_causes(self, places: Places) -> Iterator[tuple[RobotNumber, Cause]]:
        effects, *changes = self._effects
        wrong, (linear, square) = self.difference[places], (each[:, places] for each in changes)
        allowed = CLOSE * np.linalg.norm(wrong)
        near = measure_rest(wrong, linear, square) <= 2 * allowed  # by any two factors
        for place in np.flatnonzero(near):
            number = effects[place].number
            by = _solve_step(linear[place], square[place], wrong)
            left = wrong - linear[place] * by - square[place] * by**2
            if by and np.linalg.norm(left) <= allowed:
                value = number.value + by * number.step
                whole = not effects[place].place
                if not self._is_possible(number, value):
                    continue
                if whole and not self._holds(number, value, places):
                    continue
                is_left_out = abs(value) < ALIKE * number.step and not number.factor
                missing = number.name if is_left_out else ""
                yield (
                    number,
                    Cause(
                        self._words(number, value) + effects[place].place,
                        self._is_usual(number, value),
                        missing,
                    ),
                )

    def _holds(self, number: RobotNumber, value: float, places: Places) -> bool:
        """Whether the difference is nothing with a value, by the terms with that itself."""
        level: Level = "links" if number.bodies else self.level
        change = self.table.change_robot(number.put(value), level, number.bodies)
        return self.can_explain(self.row(change), places)

    def _is_possible(self, number: RobotNumber, value: float) -> bool:
        """Whether there can be such a robot, or somebody leaves the number out or doubles it."""
        robot = number.put(value)
        usual = any(abs(value - by * number.value) < ALIKE * number.step for by in USUAL if by >= 0)
        if not (usual or is_physical(robot, self.problem.robot)):
            return False
        return "acceleration" not in self.problem.parts or self._is_regular(robot)

    def find_curved_causes(self) -> Iterator[Cause]:
        """Numbers on which the terms depend in another way, each solved for by Newton's method."""
        for number in self.table.numbers:
            value = self._solve_curved(number) if number.curved else None
            if value is not None:
                yield Cause(self._words(number, value), self._is_usual(number, value))

    def _solve_curved(self, number: RobotNumber) -> float | None:
        """The value with which the difference is nothing; None for none that is found."""

        def left(value: float) -> np.ndarray:
            change = self.table.change_robot(number.put(value), self.level)
            return self.difference - self.row(change)

        value = _find_root(left, number.value, number.step)
        return value if value is not None and (np.abs(left(value)) <= self.allowed).all() else None

    def find_acceleration_causes(self, row: int) -> Iterator[Cause]:
        """Numbers with other values of which one row of the accelerations alone is right."""
        states, values = self.problem.states, self.problem.answers.values["acceleration"][:, row]
        base = DynamicsTerms(*AnalyticRobot(self.problem.robot, self.level).terms(*states[:2]))
        size = self.problem.sizes[self.level].acceleration[:, row]
        for effect in self.table.list_number_effects(self.level):
            number = effect.number

            def left(by: float, effect: NumberEffect = effect) -> np.ndarray:
                mass, bias, gravity = (
                    term + by * first + by**2 * second
                    for term, first, second in zip(base, effect.linear, effect.square, strict=True)
                )
                pushed = states.torques - self.problem.spring_torques - bias - gravity
                try:
                    right = np.linalg.solve(mass, pushed[..., None])[:, row, 0]
                except np.linalg.LinAlgError:
                    return np.full_like(values, np.nan)
                return (values - right) / size

            by = _find_root(left, 0.0, 1.0)
            if by and np.abs(left(by)).max() <= LEFT * np.abs(left(0.0)).max():
                value = number.value + by * number.step
                if self._is_possible(number, value):
                    yield Cause(self._words(number, value), self._is_usual(number, value))

    def find_inertia_causes(self, places: Places = slice(None)) -> Iterator[Cause]:
        """The six inertias of a link together."""
        for number, body in enumerate(self.problem.robot.bodies):
            size = float(np.trace(body.inertia)) or body.mass * 1e-4
            units = [_symmetric_unit(k) * size for k in range(6)]
            changes = [
                self.row(self.table.change_body(number, replace(body, inertia=body.inertia + unit)))
                for unit in units
            ]
            columns = np.stack([each[places] for each in changes], axis=1)
            fit, _, rank, _ = np.linalg.lstsq(columns, self.difference[places], rcond=1e-10)
            if not self.can_explain(np.stack(changes, axis=1) @ fit, places):
                continue
            inertia = body.inertia + np.tensordot(fit, units, axes=1)
            yield Cause(
                _describe_inertia(self._link(number), body, inertia, rank == 6), usual=False
            )

    def _link(self, number: int) -> str:
        return get_link_name(self.problem.robot, number)

    def _is_regular(self, robot: Robot) -> bool:
        """Whether a robot has accelerations: of none at all every balance holds."""
        mass = AnalyticRobot(robot, self.level).mass_matrix(self.problem.states.q)
        scaled = mass / self.problem.sizes[self.level].mass_matrix
        return bool((np.linalg.eigvalsh(scaled)[:, 0] > TOLERANCE).all())

    def _words(self, number: RobotNumber, value: float) -> str:
        same = self._equal_number_name(number, value)
        return number.words(value) + (f", {same}" if same else "")

    def _is_usual(self, number: RobotNumber, value: float) -> bool:
        usual = any(abs(value - by * number.value) < ALIKE * number.step for by in USUAL)
        of_unit = bool(number.describe_unit(value))
        return usual or of_unit or bool(self._equal_number_name(number, value))

    def _equal_number_name(self, number: RobotNumber, value: float) -> str:
        """The name of another number of the file that the value is, with its unit; '' for none."""
        if abs(value) < ALIKE * number.step or not number.unit:
            return ""
        names = [
            other.name
            for other in self.table.numbers
            if other.unit == number.unit
            and other.name != number.name
            and abs(other.value - value) <= ALIKE * abs(value)
        ]
        return f"as {names[0]}" if names else ""

    def _mistake_causes(self, places: Places) -> list[Cause]:
        mistakes = [
            mistake
            for mistake, changed in self._mistakes
            if np.abs(changed[places]).max(initial=0.0) > TOLERANCE
            and self.can_explain(changed, places)
        ]
        single = [each for each in mistakes if not each.several]
        return [Cause(each.words, usual=True) for each in single or mistakes]

    @cached_property
    def _piece_rows(self) -> np.ndarray:
        """What each parameter of a body and of a rotor makes of the row (parameters, places)."""
        kane, rows = self.table.kane, list[np.ndarray]()
        for number in range(len(self.problem.robot.bodies)):
            first, *others = (
                self.row(kane.compute_terms(number, kane.place_body(number, body)))
                for body in list_unit_bodies()
            )
            rows += [first, *(each - first for each in others)]
        for effects in list_rotor_effects(self.problem.robot, self.level, self.problem.states):
            rows += map(self.row, effects)
        return np.stack(rows)

    def _piece_causes(self, places: Places) -> Iterator[Cause]:
        """Numbers of links and rotors that are exchanged, shifted or in another order."""
        changes, words = self.table.piece_changes
        inside = np.arange(self.difference.size)[places]
        largest = np.argsort(-np.abs(self.difference[inside]))[:MOST_SCREENED]
        screened = inside[largest]
        left = np.abs(changes @ self._piece_rows[:, screened] - self.difference[screened])
        for number in np.flatnonzero((left <= 2 * self.allowed[screened]).all(axis=1)):
            if self.can_explain(changes[number] @ self._piece_rows, places):
                yield Cause(words[number], usual=True)

    def find_joint_moves(self, places: Places = slice(None)) -> Iterator[Cause]:
        """Places, axes and frames of joints that are exchanged, or in another order."""
        wrong = np.zeros(self.difference.size, bool)
        wrong[places] = np.abs(self.difference[places]) > self.allowed[places]
        part = next((p for p in MATRICES if wrong[self.select_places(p)].any()), "")
        for move in self.table.joint_moves:
            if part and not self._agrees_at_first_state(move.robot, part):
                continue
            if self.can_explain(self.row(self.table.change_robot(move.robot, self.level)), places):
                yield Cause(move.words, usual=True)

    def find_gravity_causes(self) -> Iterator[Cause]:
        """Gravity along another direction than an axis."""
        robot, effects = self.problem.robot, self.table.list_number_effects(self.level)
        axes = [each for each in effects if each.number.name.startswith("gravity: ")]
        columns = np.stack([self.row(each.linear) / each.number.step for each in axes], axis=1)
        fit, _, rank, _ = np.linalg.lstsq(columns, self.difference, rcond=1e-10)
        if rank == len(axes) and self.can_explain(columns @ fit):
            vector, right = robot.gravity + fit, float(np.linalg.norm(robot.gravity))
            shown = ", ".join(f"{each:.6g}" for each in vector)
            size = float(np.linalg.norm(vector))
            tilted = (
                ", of the right size: a tilted base?" if abs(size - right) < ALIKE * right else ""
            )
            yield Cause(f"gravity = ({shown}) m/s^2{tilted}", usual=bool(tilted))

    def find_motion_causes(self, several: Sequence[Places]) -> Iterator[tuple[int, Cause]]:
        """Mistakes in Kane's sum at some bodies or joints, and the places that each explains.

        several: of the row, by number; of each mistake the first ones are told that it explains.
        """
        inside = [np.arange(self.difference.size)[places] for places in several]
        wholes = list[str]()
        for words, changes in self.table.generate_motion_changes(self.level):
            rows_by_words: dict[str, dict[str, np.ndarray]] = {}
            for name, change in changes.items():
                for place, (placed,) in self._list_places(change):
                    rows_by_words.setdefault(words + place, {})[name] = self.row(placed)
            for full_words, rows in rows_by_words.items():
                stacked = np.array(list(rows.values()))
                for number, places in enumerate(inside):
                    if not (chosen := self._choose_rows(stacked[:, places], places)):
                        continue
                    there = [name for name, row in rows.items() if row.any()]
                    whole = f"{_join_names([list(rows)[n] for n in chosen], there)}: {full_words}"
                    if not any(whole.startswith(each) for each in wholes):  # a place says no more
                        wholes.append(whole)
                        yield number, Cause(whole, usual=True)
                    break

    def _choose_rows(self, rows: np.ndarray, places: np.ndarray) -> list[int]:
        """Which of some changes (changes, places), each made once, leave nothing at the places."""
        there = np.flatnonzero(np.abs(rows).max(axis=1, initial=0.0) > TOLERANCE)
        screened = np.argsort(-np.abs(self.difference[places]))[:MOST_SCREENED]
        sampled, wrong = rows[there][:, screened], self.difference[places][screened]
        if not there.size:
            return []
        fit = np.linalg.lstsq(sampled.T, wrong, rcond=1e-10)[0]
        picks = np.vstack([np.eye(there.size), np.ones(there.size), np.clip(np.rint(fit), 0, 1)])
        left = np.abs(picks @ sampled - wrong) <= 2 * self.allowed[places][screened]
        for number in np.flatnonzero(left.all(axis=1)):
            if (
                np.abs(self.difference[places] - picks[number] @ rows[there])
                <= self.allowed[places]
            ).all():
                return list(there[picks[number] > 0])
        return []

    def _agrees_at_first_state(self, robot: Robot, part: str) -> bool:
        """Whether another robot has the user's M or gravity at the first state."""
        q, user_value = self.problem.states.q[:1], self.problem.answers.values[part][0]
        least = LEFT * np.abs(user_value - self.problem.reference_values[self.level][part][0]).max()
        moved = getattr(AnalyticRobot(robot, self.level), part)(q)[0]
        if part == "gravity":
            moved = moved + self.problem.spring_torques[0]
        rounding = TOLERANCE * np.abs(user_value).max()
        return bool(np.abs(moved - user_value).max() <= least + rounding)

    def _missing_pairs(self) -> Iterator[Cause]:
        """Couplings of two joints by a rotor or stage, if M lacks one of these and nothing else."""
        if "mass_matrix" not in self.problem.parts:
            return
        robot, q, names = self.problem.robot, self.problem.states.q, self.problem.names
        places = self.select_places("mass_matrix")
        if np.abs(self.difference[~places]).max(initial=0.0) > TOLERANCE:
            return
        sizes, bare = self.problem.sizes[self.level].mass_matrix, self.table.bare
        gears = [("rotor", item.joint, replace(bare, rotors=(item,))) for item in robot.rotors]
        gears += [("stage", item.joint, replace(bare, stages=(item,))) for item in robot.stages]
        for kind, joint, alone in gears:
            pair = AnalyticRobot(alone, "coupled").mass_matrix(q)
            pair = (pair - AnalyticRobot(alone, "links").mass_matrix(q)) / sizes
            for i, j in zip(*np.triu_indices(len(names), 1), strict=True):
                missing_coupling, row = np.zeros_like(pair), np.zeros_like(self.difference)
                missing_coupling[:, i, j] = missing_coupling[:, j, i] = -pair[:, i, j]
                row[places] = missing_coupling.ravel()
                if np.abs(missing_coupling).max() > TOLERANCE and self.can_explain(row):
                    item = robot.joints[joint].name
                    yield Cause(
                        f"no coupling of {names[i]} and {names[j]} in M by the {kind} of {item}",
                        usual=True,
                    )

    def links(self) -> Iterator[str]:
        """Links whose mass, first moments and inertia about the joint make the difference."""
        for number, body in enumerate(self.problem.robot.bodies):
            changed = [
                self.row(self.table.change_body(number, other)) for other in _vary_parameters(body)
            ]
            columns = np.stack(changed, axis=1)
            fit = np.linalg.lstsq(columns, self.difference, rcond=1e-10)[0]
            if self.can_explain(columns @ fit):
                yield self._link(number)


def _join_names(names: Sequence[str], there: Sequence[str]) -> str:
    """Names of bodies or joints at which something is wrong, of those at which it may be."""
    kinds = {"joint ": "every joint", "rotor of ": "every rotor", "": "every link"}
    for begin, every in kinds.items():
        alike = [name for name in there if name.startswith(begin)]
        if len(names) > 1 and list(names) == alike:
            return every
    return " and ".join(names)


def _describe_inertia(link: str, body: RobotBody, inertia: np.ndarray, is_unique: bool) -> str:
    """A link's inertia beside the right one, in words."""
    if not is_unique:
        return f"{link}: its inertia about the centre of mass another one"
    right, moments = np.linalg.eigvalsh(body.inertia), np.linalg.eigvalsh(inertia)
    size = float(right[-1]) or 1.0
    if np.abs(right - moments).max() < LEFT * size:
        return f"{link}: its inertia turned: the right principal moments about other axes"
    changed = [
        f"I{'xyz'[i]}{'xyz'[j]} = {inertia[i, j]:.6g} (file: {body.inertia[i, j]:.6g})"
        for i, j in zip(*np.triu_indices(3), strict=True)
        if abs(inertia[i, j] - body.inertia[i, j]) > LEFT * size
    ]
    impossible = (
        ""
        if moments[0] >= 0 and moments[0] + moments[1] >= moments[2]
        else ("; no body has these: are its six numbers mixed up?")
    )
    return f"{link}: its inertia {', '.join(changed)}{impossible}"


def _symmetric_unit(number: int) -> np.ndarray:
    unit = np.zeros((3, 3))
    i, j = np.transpose(np.triu_indices(3))[number]
    unit[i, j] = unit[j, i] = 1.0
    return unit


def _find_root(left: Callable[[float], np.ndarray], begin: float, size: float) -> float | None:
    """The number with which least is left, by Gauss and Newton; None where the first step fails."""
    value, near = begin, NEAR * size
    for step in range(STEPS):
        here, slope = left(value), (left(value + near) - left(value - near)) / (2 * near)
        square = float(slope @ slope)
        if not 0 < square < np.inf:
            return None
        by = -float(slope @ here) / square
        if not step and np.linalg.norm(here + by * slope) > PROMISING * np.linalg.norm(here):
            return None
        value += float(np.clip(by, -size, size))
        if abs(by) < 1e-10 * size:
            break
    return value


def _is_identity(turn: np.ndarray) -> bool:
    return bool(np.allclose(turn, np.eye(3), rtol=0.0, atol=ALIKE))


def _multiply(matrix: np.ndarray, vector: np.ndarray) -> np.ndarray:
    product: np.ndarray = np.einsum("sij,sj->si", matrix, vector)
    return product


def _solve_step(linear: np.ndarray, square: np.ndarray, difference: np.ndarray) -> float:
    """x that makes linear x + square x^2 nearest to a difference; 0 if it changes nothing."""
    coefficients = [
        2 * square @ square,
        3 * linear @ square,
        linear @ linear - 2 * square @ difference,
        -linear @ difference,
    ]
    if not coefficients[2] and not coefficients[0]:
        return 0.0
    largest = max(map(abs, coefficients))
    trimmed = [each if abs(each) > 1e-24 * largest else 0.0 for each in coefficients]
    roots = np.roots(np.trim_zeros(trimmed, "f"))
    real = roots[np.abs(roots.imag) <= 1e-6 * (1 + np.abs(roots.real))].real
    if not real.size:
        return 0.0
    left = [np.linalg.norm(difference - linear * x - square * x**2) for x in real]
    return float(real[int(np.argmin(left))])


def _vary_parameters(body: RobotBody) -> Iterator[RobotBody]:
    """The body with more of each of the ten parameters on which equations depend linearly."""
    moments = body.mass * body.com
    about = body.inertia + compute_point_inertia(body.mass, body.com)
    size, inertia = 0.1 * body.mass, 0.1 * float(np.trace(about))
    for number in range(10):
        mass, first, second = body.mass, moments.copy(), about.copy()
        if number == 0:
            mass += size
        elif number < 4:
            first[number - 1] += size * max(float(np.abs(body.com).max()), 0.01)
        else:
            second += inertia * _symmetric_unit(number - 4)
        com = first / mass
        yield RobotBody(mass, com, second - compute_point_inertia(mass, com))

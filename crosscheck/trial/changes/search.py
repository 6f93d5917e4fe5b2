"""Search for the wrong number or the mix-up that explains a difference, in all parts or one."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import islice
from typing import NamedTuple

import numpy as np

from crosscheck.analytic.robot.model import AnalyticRobot
from crosscheck.checks.robots.sizes import TOLERANCE
from crosscheck.models.robot.robot import (
    Level,
    Placement,
    Robot,
    RobotBody,
    Rotor,
    compute_point_inertia,
)
from crosscheck.trial.changes.exchanges import (
    generate_joint_moves,
    list_piece_changes,
    list_rotor_effects,
    list_spinners,
    list_unit_bodies,
)
from crosscheck.trial.changes.kane import (
    BodyPart,
    KaneSum,
    WorldBody,
    list_body_parts,
    list_unturned_bodies,
    list_whole_bodies,
)
from crosscheck.trial.changes.motions import ByPlace, MotionTable
from crosscheck.trial.changes.numbers import (
    ALIKE,
    AS_IT_STANDS,
    AXES,
    USUAL,
    FrameMistake,
    RobotNumber,
    generate_body_mistakes,
    generate_frame_mistakes,
    get_link_name,
    is_physical,
    list_equal_numbers,
    list_numbers,
)
from crosscheck.trial.changes.pairs import PairSearch
from crosscheck.trial.changes.problem import LEFT, ROUNDING, ChangeProblem, DynamicsTerms, Places
from crosscheck.trial.changes.variants import compute_variants
from crosscheck.trial.changes.waves import measure_rest

# Largest residual of a number's effect that is worth a try, over the difference's norm.
CLOSE = 1e-4
PROMISING = 0.9  # largest residual after a first Newton step, relative to the one before
STEPS = 12  # steps of Newton's method
NEAR = 1e-4  # step of differentiation, relative to that of the number
SLENDER = 1e-9  # inertia of a thin rod about its own axis, over its largest moment of inertia
MOST_EQUAL_PAIRS = 12  # pairs that explain a difference, at which the search stops
LEAST_STATES = 3  # states for screening where two factors are free
LEAST_ROWS = 12  # rows of one part at which changes are screened
MOST_SCREENED = 64  # places of a row, those of the largest differences, at which all are screened


@dataclass(frozen=True)
class Cause:
    """The cause of a difference, in words that complete `with ...`.

    usual: whether the number is 0, has the other sign, is twice or half as large or is another of
    the file, so that somebody may well have written it. missing: name of a number that is 0.
    """

    words: str
    usual: bool
    missing: str = ""


class NumberEffect(NamedTuple):
    """First- and second-order effect of one step of a number on all terms."""

    linear: DynamicsTerms
    square: DynamicsTerms


class MistakeEffect(NamedTuple):
    """One thing taken for another: what it does to all terms, or the robot that has it.

    several: whether in every part of a kind.
    """

    words: str
    several: bool
    change: DynamicsTerms | Robot


class ChangeTable:
    """Effect of each change of a robot on its terms at the states, for all levels."""

    def __init__(self, problem: ChangeProblem) -> None:
        self.robot, self.states = problem.robot, problem.states
        self.bare = replace(self.robot, rotors=(), stages=())
        self.numbers = list(list_numbers(self.robot))
        count, size = self.states.q.shape
        self.few = slice(min(count, -(-LEAST_ROWS // size)))  # states at which all are screened
        # The same where factors are free, or some of many bodies may be wrong.
        self.several = slice(min(count, max(LEAST_STATES, MOST_SCREENED // size)))
        self._effects: dict[tuple[str, Level], NumberEffect] = {}
        self._bases: dict[Level, DynamicsTerms] = {}
        self._screened_rotors: dict[Level, list[dict[str, DynamicsTerms]]] = {}
        self.kane = KaneSum(self.robot, self.states.q, self.states.v)
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
        """Change of the terms if another body takes the place of one."""
        placed = self.kane.place_body(number, body)
        return self.kane.compute_terms(number, placed).minus(self._placed[number])

    def change_robot(self, robot: Robot, level: Level) -> DynamicsTerms:
        """Change of the terms for another robot at a level, body by body where that is enough."""
        if not self._has_same_motion(robot):
            return DynamicsTerms(*AnalyticRobot(robot, level).terms(*self.states[:2])).minus(
                self._base(level)
            )
        here = self.robot
        changes = [
            self.change_body(number, body)
            for number, body in enumerate(robot.bodies)
            if body is not here.bodies[number]
        ]
        if level != "links":
            right = others = self._spinners
            if robot.rotors is not here.rotors or robot.stages is not here.stages:
                others = {id(each.rotor): each.rotor for each in list_spinners(robot)}
            lost = [rotor for key, rotor in right.items() if key not in others]
            rotors = [rotor for key, rotor in others.items() if key not in right]
            rotors += [replace(rotor, inertia=-rotor.inertia) for rotor in lost]
            changes += [self.kane.move_rotor(rotor, level).compute_terms() for rotor in rotors]
        return add_terms(changes) if changes else self._base(level).minus(self._base(level))

    def _has_same_motion(self, robot: Robot) -> bool:
        """Whether a robot has other bodies or rotors alone."""
        here = self.robot
        return robot.joints is here.joints and robot.gravity is here.gravity

    def screen_robots(self, robots: Sequence[Robot], level: Level, states: slice) -> DynamicsTerms:
        """Changes for other robots (robots, states, ...), by another derivation, for screening."""
        q, v = (each[states] for each in self.states[:2])
        changes, base = compute_variants(robots, level, q, v), self._base(level)
        return DynamicsTerms(*(a - b[states] for a, b in zip(changes, base, strict=True)))

    def select_numbers(self, level: Level) -> list[RobotNumber]:
        """The numbers that may change something at a level, by their square at most."""
        rotors = ("rotor of", "every rotor", "stage of") if level == "links" else ()
        numbers = [number for number in self.numbers if not number.curved]
        return [number for number in numbers if not number.name.startswith(rotors)]

    def find_number_effect(self, number: RobotNumber, level: Level) -> NumberEffect:
        """Effect of a number at a level."""
        key = number.name, level
        if key not in self._effects:
            changes = [
                self.change_robot(number.put(number.value + sign * number.step), level)
                for sign in (1, -1)
            ]
            self._effects[key] = _halve(*changes)
        return self._effects[key]

    def screen_numbers(self, level: Level) -> NumberEffect:
        """The effects (numbers, several states, ...) of the numbers of a level."""
        numbers = self.select_numbers(level)
        robots = [[each.put(each.value + by * each.step) for each in numbers] for by in (1, -1)]
        up, down = (self.screen_robots(each, level, self.several) for each in robots)
        return _halve(up, down)

    def list_mistakes(self, level: Level) -> list[MistakeEffect]:
        """Each thing that may be taken for another at a level."""
        robot = self.bare if level == "links" else self.robot
        mistakes = list(self._body_mistakes)
        for each in generate_frame_mistakes(robot, are_rotors_bodies=level == "coupled"):
            is_moved = not self._has_same_motion(each.robot)
            change = each.robot if is_moved else self.change_robot(each.robot, level)
            mistakes.append(MistakeEffect(each.words, each.several, change))
        return mistakes

    def screen_mistakes(self, mistakes: Sequence[MistakeEffect], level: Level) -> DynamicsTerms:
        """Effects of mistakes (mistakes, few states, ...)."""
        robots = [each.change for each in mistakes if isinstance(each.change, Robot)]
        moved = zip(*self.screen_robots(robots, level, self.few), strict=True)
        changes = [
            next(moved) if isinstance(each.change, Robot) else [t[self.few] for t in each.change]
            for each in mistakes
        ]
        return DynamicsTerms(*map(np.array, zip(*changes, strict=True)))

    @cached_property
    def _body_mistakes(self) -> list[MistakeEffect]:
        """Mistakes in each link of the URDF, then in bodies of several links fixed together."""
        parts, bodies = list_body_parts(self.robot), list_whole_bodies(self.robot)
        mistakes = self._list_part_mistakes(parts, "")
        if len(parts) > len(bodies):
            mistakes += self._list_part_mistakes(bodies, ", with what is fixed to it")
        return mistakes

    def _list_part_mistakes(self, parts: Sequence[BodyPart], merged: str) -> list[MistakeEffect]:
        """Mistakes in one link, then the same in all; merged: suffix for links welded together."""
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
        changed = self._list_changed_bodies(part, self.kane)
        for link, place in self._list_frames_beyond(part):
            moved = replace(part.in_link, com=place + part.in_link.com)
            words = f"its centre of mass counted from {link}"
            changed[words] = self.kane.place_body(number, part.carry(moved))
        return {w: self.kane.compute_terms(number, b).minus(right) for w, b in changed.items()}

    def _list_frames_beyond(self, part: BodyPart) -> Iterator[tuple[str, np.ndarray]]:
        """Links that are fixed to a part or that move on it, and their places in its frame."""
        at = part.placement
        places = {
            name: frame.placement.position
            for name, frame in self.robot.frames.items()
            if frame.body == part.number and name != part.name
        }
        for number, joint in enumerate(self.robot.joints):
            if joint.parent == part.number:
                places[get_link_name(self.robot, number)] = joint.placement.position
        for name, place in places.items():
            shift = at.rotation.T @ (place - at.position)
            if shift.any():
                yield name, shift

    def _list_changed_bodies(self, part: BodyPart, kane: KaneSum) -> dict[str, WorldBody]:
        """By words, what a part may be taken for."""
        joint, number = self.robot.joints[part.number], part.number
        is_moved = part.placement.position.any() or not _is_identity(part.placement.rotation)
        before = replace(joint, placement=part.placement) if is_moved else joint
        changed = {
            words: kane.place_body(number, part.carry(other))
            for words, other in generate_body_mistakes(part.in_link, before, part.turn)
        }
        turn = kane.poses[number].rotation @ part.placement.rotation
        shift = kane.poses[number].rotation @ part.placement.position
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
                changed[words] = kane.place_body(number, body)
        return changed

    @cached_property
    def _has_inertial_axes(self) -> bool:
        """Whether the file has the inertia of any link in other axes than the link's."""
        return not all(_is_identity(part.turn) for part in list_body_parts(self.robot))

    def generate_motion_changes(
        self, level: Level, only: Collection[str]
    ) -> Iterator[tuple[str, ByPlace]]:
        """Mistakes in Kane's sum in some words, each with what it changes by what has it."""
        for table in self._list_motion_tables(slice(None), only):
            rotors = table.list_rotor_changes(level)
            for words, changes in table.list_changes():
                yield words, {**changes, **rotors.pop(words, {})}
            yield from rotors.items()

    def screen_motions(self, level: Level) -> Iterator[tuple[str, DynamicsTerms]]:
        """The words of all of these, and what they change (bodies, few states, ...)."""
        tables = self._screened_motions
        if level not in self._screened_rotors:
            self._screened_rotors[level] = [
                {words: _stack_terms(c) for words, c in table.list_rotor_changes(level).items()}
                for table, _ in tables
            ]
        for (_, of_bodies), of_rotors in zip(tables, self._screened_rotors[level], strict=True):
            rotors = dict(of_rotors)
            for words, stacked in of_bodies:
                more = [rotors.pop(words)] if words in rotors else []
                yield words, DynamicsTerms(*map(np.concatenate, zip(stacked, *more, strict=True)))
            yield from rotors.items()

    @cached_property
    def _screened_motions(self) -> list[tuple[MotionTable, list[tuple[str, DynamicsTerms]]]]:
        return [
            (table, [(words, _stack_terms(changes)) for words, changes in table.list_changes()])
            for table in self._list_motion_tables(self.several, None)
        ]

    def _list_motion_tables(
        self, states: slice, only: Collection[str] | None
    ) -> Iterator[MotionTable]:
        """Changes for the links of the URDF, then for bodies of several links fixed together."""
        kane = KaneSum(self.robot, self.states.q[states], self.states.v[states])
        parts, bodies = list_body_parts(self.robot), list_whole_bodies(self.robot)
        named = [{each.name: each for each in parts}]
        if len(parts) > len(bodies):
            named.append({f"{each.name}, with what is fixed to it": each for each in bodies})
        for each in named:
            changed = {
                name: (part, self._list_changed_bodies(part, kane)) for name, part in each.items()
            }
            yield MotionTable(kane, changed, only)

    @cached_property
    def _spinners(self) -> dict[int, Rotor]:
        """Rotors of the robot and of its stages, by identity."""
        return {id(each.rotor): each.rotor for each in list_spinners(self.robot)}

    def _base(self, level: Level) -> DynamicsTerms:
        if level not in self._bases:
            self._bases[level] = DynamicsTerms(
                *AnalyticRobot(self.robot, level).terms(*self.states[:2])
            )
        return self._bases[level]


def _stack_terms(changes: ByPlace) -> DynamicsTerms:
    """Changes of the terms by name as arrays (names, states, ...)."""
    return DynamicsTerms(*map(np.array, zip(*changes.values(), strict=True)))


def _halve(up: DynamicsTerms, down: DynamicsTerms) -> NumberEffect:
    """First- and second-order effect on the terms, from a step up and a step down."""
    pairs = list(zip(up, down, strict=True))
    linear, square = ([(a + sign * b) / 2 for a, b in pairs] for sign in (-1, 1))
    return NumberEffect(DynamicsTerms(*linear), DynamicsTerms(*square))


def add_terms(several: Iterable[DynamicsTerms]) -> DynamicsTerms:
    """The sum of several terms."""
    return DynamicsTerms(*(np.sum(each, axis=0) for each in zip(*several, strict=True)))


class CauseSearch:
    """The search for what makes the difference between equations and a level."""

    def __init__(self, problem: ChangeProblem, table: ChangeTable | None = None) -> None:
        self.problem, self.level = problem, problem.level
        self.table = table or ChangeTable(problem)
        self.difference, self.allowed = problem.difference, problem.allowed
        self.row, self.can_explain = problem.lay_out, problem.can_explain
        self.select_screened = problem.select_screened

    def _find_survivors(self, rows: np.ndarray, places: Places) -> list[int]:
        """Numbers of the rows (changes, places at few states) that explain the difference there."""
        at, chosen = self.select_screened(places, self.table.few)
        left = np.abs(rows[:, chosen] - self.difference[at]) - 2 * self.allowed[at]
        return np.flatnonzero((left <= TOLERANCE).all(axis=1)).tolist()

    @cached_property
    def number_rows(self) -> list[tuple[np.ndarray, np.ndarray]]:
        """First- and second-order effect of each number on the row at several states.

        With effects on single terms too where only a balance shows that something is wrong.
        """
        several, effects = self.table.several, self.table.screen_numbers(self.level)
        pairs = [changes for _, changes in self._list_places(*effects)]
        return [(self.row(linear, several), self.row(square, several)) for linear, square in pairs]

    @cached_property
    def mistakes(self) -> tuple[list[MistakeEffect], list[np.ndarray]]:
        """Mistakes, and their effect on the row at few states, in all terms and in each."""
        mistakes, few = self.table.list_mistakes(self.level), self.table.few
        changes = self._list_places(self.table.screen_mistakes(mistakes, self.level))
        return mistakes, [self.row(change, few) for _, (change,) in changes]

    @cached_property
    def _move_rows(self) -> list[np.ndarray]:
        """Effect of each move of a joint on the row at few states, in all terms and in each."""
        robots, few = [each.robot for each in self.table.joint_moves], self.table.few
        changes = self._list_places(self.table.screen_robots(robots, self.level, few))
        return [self.row(change, few) for _, (change,) in changes]

    def _list_places(
        self, *changes: DynamicsTerms
    ) -> Iterator[tuple[str, tuple[DynamicsTerms, ...]]]:
        """Changes of all terms, then of each alone if only a balance shows the error."""
        yield "", changes
        if not self.problem.is_balance_alone:
            return
        fields = DynamicsTerms._fields
        least = [TOLERANCE * self.problem.sizes[name].max() for name in fields]
        largest = np.max(
            [[np.abs(term).max(initial=0.0) for term in each] for each in changes], axis=0
        )
        there = np.flatnonzero(largest > least)
        for number in there if len(there) > 1 else ():
            name = fields[number]
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
        wrong = self.difference[places]
        allowed = CLOSE * np.linalg.norm(wrong)
        at, chosen = self.select_screened(places, self.table.several)
        near = np.zeros(len(self.number_rows[0][0]), bool)
        for rows in self.number_rows:  # by any two factors
            near |= measure_rest(self.difference[at], *(r[:, chosen] for r in rows)) <= 2 * allowed
        numbers = self.table.select_numbers(self.level)
        for number in [numbers[place] for place in np.flatnonzero(near)]:
            for where, changes in self._list_places(
                *self.table.find_number_effect(number, self.level)
            ):
                linear, square = (self.row(change)[places] for change in changes)
                by = _solve_step(linear, square, wrong)
                left = np.linalg.norm(wrong - linear * by - square * by**2)
                value = number.value + by * number.step
                if not by or left > allowed or not self.is_possible(number, value):
                    continue
                if not where and not self._holds(number, value, places):
                    continue
                is_left_out = abs(value) < ALIKE * number.step and not number.factor
                words, usual = (
                    self.describe_value(number, value) + where,
                    self.is_usual(number, value),
                )
                yield number, Cause(words, usual, number.name if is_left_out else "")

    def _holds(self, number: RobotNumber, value: float, places: Places) -> bool:
        """Whether a value explains the difference, by terms computed with the value itself."""
        change = self.table.change_robot(number.put(value), self.level)
        return self.can_explain(self.row(change), places)

    def is_possible(self, number: RobotNumber, value: float) -> bool:
        """Whether such a robot is possible, or the value is what omitting or doubling it gives."""
        robot = number.put(value)
        usual = any(abs(value - by * number.value) < ALIKE * number.step for by in USUAL if by >= 0)
        usual |= value * number.value > 0 and bool(number.describe_unit(value))
        if not (usual or is_physical(robot, self.problem.robot)):
            return False
        return "acceleration" not in self.problem.parts or self._is_regular(robot)

    def find_pair_causes(self, places: Places = slice(None)) -> list[Cause]:
        """Two changes at once that leave nothing of the difference, at least one of them usual.

        Those come first of which both are.
        """
        pairs = dict(islice(self._pairs.find_pairs(places), MOST_EQUAL_PAIRS))
        causes = [Cause(f"two changes: {words}", usual) for words, usual in pairs.items()]
        return sorted(causes, key=lambda cause: not cause.usual)

    @cached_property
    def _pairs(self) -> PairSearch:
        return PairSearch(self)

    def find_curved_causes(self) -> Iterator[Cause]:
        """Numbers on which the terms depend in another way, each solved for by Newton's method."""
        for number in self.table.numbers:
            value = self._solve_curved(number) if number.curved else None
            if value is not None:
                yield Cause(self.describe_value(number, value), self.is_usual(number, value))

    def _solve_curved(self, number: RobotNumber) -> float | None:
        """The value with which the difference is nothing; None for none that is found."""

        def left(value: float) -> np.ndarray:
            change = self.table.change_robot(number.put(value), self.level)
            return self.difference - self.row(change)

        value = _find_root(left, number.value, number.step)
        return value if value is not None and (np.abs(left(value)) <= self.allowed).all() else None

    def find_acceleration_causes(self, row: int) -> Iterator[Cause]:
        """Numbers with other values of which one row of the accelerations alone is right."""
        states, values = self.problem.states, self.problem.values["acceleration"][:, row]
        base = DynamicsTerms(*AnalyticRobot(self.problem.robot, self.level).terms(*states[:2]))
        for number in self.table.select_numbers(self.level):
            effect = self.table.find_number_effect(number, self.level)

            def left(by: float, effect: NumberEffect = effect) -> np.ndarray:
                mass, bias, gravity = (
                    term + by * first + by**2 * second
                    for term, first, second in zip(base, effect.linear, effect.square, strict=True)
                )
                pushed = states.torques - bias - gravity
                try:
                    right = np.linalg.solve(mass, pushed[..., None])[:, row, 0]
                except np.linalg.LinAlgError:
                    return np.full_like(values, np.nan)
                return values - right

            by = _find_root(left, 0.0, 1.0)
            if by and np.abs(left(by)).max() <= LEFT * np.abs(left(0.0)).max():
                value = number.value + by * number.step
                if self.is_possible(number, value):
                    yield Cause(self.describe_value(number, value), self.is_usual(number, value))

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
        scaled = mass / self.problem.sizes["mass_matrix"]
        return bool((np.linalg.eigvalsh(scaled)[:, 0] > TOLERANCE).all())

    def describe_value(self, number: RobotNumber, value: float) -> str:
        """The number with a value, in words that complete `with ...`."""
        same = self._equal_number_name(number, value)
        return number.words(value) + (f", {same}" if same else "")

    def is_usual(self, number: RobotNumber, value: float) -> bool:
        """Whether a value is one that a person may well have written by mistake."""
        usual = any(abs(value - by * number.value) < ALIKE * number.step for by in USUAL)
        of_unit = bool(number.describe_unit(value))
        return usual or of_unit or bool(self._equal_number_name(number, value))

    def _equal_number_name(self, number: RobotNumber, value: float) -> str:
        """The number of the file that a value is, or is more or less by, in words; '' for none."""
        if abs(value) < ALIKE * number.step or not number.unit or number.factor:
            return ""
        others = [each for each in self.table.numbers if each.name != number.name]
        if equal := list_equal_numbers(others, number.unit, value):
            return f"as {equal[0].name}"
        step = value - number.value
        if any(abs(value - by * number.value) < ALIKE * number.step for by in USUAL):
            return ""
        equal = list_equal_numbers(others, number.unit, abs(step))
        return f"{'less' if step < 0 else 'more'} by {equal[0].name}" if equal else ""

    def _mistake_causes(self, places: Places) -> list[Cause]:
        mistakes, rows_by_place = self.mistakes
        survivors = {n for rows in rows_by_place for n in self._find_survivors(rows, places)}
        causes: dict[bool, list[Cause]] = {False: [], True: []}
        for mistake in [mistakes[number] for number in sorted(survivors)]:
            change = mistake.change
            if isinstance(change, Robot):
                change = self.table.change_robot(change, self.level)
            for where, (placed,) in self._list_places(change):
                row = self.row(placed)
                has_effect = np.abs(row[places]).max(initial=0.0) > TOLERANCE
                if has_effect and self.can_explain(row, places):
                    causes[mistake.several].append(Cause(mistake.words + where, usual=True))
        return causes[False] or causes[True]

    @cached_property
    def _piece_rows(self) -> list[tuple[str, np.ndarray]]:
        """Effect of each parameter of a body or rotor on the row (parameters, places).

        In all terms, then in each alone, named in words.
        """
        kane, effects = self.table.kane, list[DynamicsTerms]()
        for number in range(len(self.problem.robot.bodies)):
            first, *others = (
                kane.compute_terms(number, kane.place_body(number, body))
                for body in list_unit_bodies()
            )
            effects += [first, *(each.minus(first) for each in others)]
        for of_rotor in list_rotor_effects(kane, self.level):
            effects += of_rotor
        stacked = DynamicsTerms(*map(np.array, zip(*effects, strict=True)))
        return [(where, self.row(placed)) for where, (placed,) in self._list_places(stacked)]

    def _piece_causes(self, places: Places) -> Iterator[Cause]:
        """Numbers of links and rotors that are exchanged, shifted or in another order."""
        changes, words = self.table.piece_changes
        inside = np.arange(self.difference.size)[places]
        largest = np.argsort(-np.abs(self.difference[inside]))[:MOST_SCREENED]
        screened = inside[largest]
        for where, rows in self._piece_rows:
            left = np.abs(changes @ rows[:, screened] - self.difference[screened])
            for number in np.flatnonzero((left <= 2 * self.allowed[screened]).all(axis=1)):
                if self.can_explain(changes[number] @ rows, places):
                    yield Cause(words[number] + where, usual=True)

    def find_joint_moves(self, places: Places = slice(None)) -> Iterator[Cause]:
        """Places, axes and frames of joints that are exchanged, or in another order."""
        survivors = {n for rows in self._move_rows for n in self._find_survivors(rows, places)}
        for move in [self.table.joint_moves[number] for number in sorted(survivors)]:
            change = self.table.change_robot(move.robot, self.level)
            for where, (placed,) in self._list_places(change):
                if self.can_explain(self.row(placed), places):
                    yield Cause(move.words + where, usual=True)

    def find_gravity_causes(self) -> Iterator[Cause]:
        """Gravity along another direction than an axis."""
        robot, numbers = self.problem.robot, self.table.select_numbers(self.level)
        axes = [each for each in numbers if each.name.startswith("gravity: ")]
        effects = [self.table.find_number_effect(each, self.level).linear for each in axes]
        columns = np.stack([self.row(each) for each in effects], axis=1) / axes[0].step
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

        several: of the row, by number; each mistake is reported with the first ones it explains.
        """
        inside = [np.arange(self.difference.size)[places] for places in several]
        wholes = list[str]()
        only = self._find_motion_words(inside)
        for words, changes in self.table.generate_motion_changes(self.level, only) if only else ():
            rows_by_words: dict[str, dict[str, np.ndarray]] = {}
            for name, change in changes.items():
                for place, (placed,) in self._list_places(change):
                    rows_by_words.setdefault(words + place, {})[name] = self.row(placed)
            for full_words, rows in rows_by_words.items():
                stacked = np.array(list(rows.values()))
                for number, places in enumerate(inside):
                    if not (chosen := self._choose_rows(stacked[:, places], places)):
                        continue
                    there = [n for n, row in rows.items() if np.abs(row).max() > TOLERANCE]
                    whole = f"{_join_names([list(rows)[n] for n in chosen], there)}: {full_words}"
                    if not any(whole.startswith(each) for each in wholes):  # a place says no more
                        wholes.append(whole)
                        yield number, Cause(whole, usual=True)
                    break

    def _find_motion_words(self, several: Sequence[np.ndarray]) -> set[str]:
        """The mistakes that leave nothing of the difference at a few states in some places."""
        screened = [self.select_screened(places, self.table.several) for places in several]
        survivors = set[str]()
        for words, changes in self.table.screen_motions(self.level):
            for _, (placed,) in self._list_places(changes):
                rows = self.row(placed, self.table.several)
                if any(self._choose_rows(rows[:, chosen], at) for at, chosen in screened):
                    survivors.add(words)
        return survivors

    def _choose_rows(self, rows: np.ndarray, places: np.ndarray) -> list[int]:
        """Numbers of the changes (changes, places) that together explain the places, each once."""
        there = np.flatnonzero(np.abs(rows).max(axis=1, initial=0.0) > TOLERANCE)
        if not there.size:
            return []
        screened = np.argsort(-np.abs(self.difference[places]))[:MOST_SCREENED]
        sampled, wrong = rows[there][:, screened], self.difference[places][screened]
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

    def _missing_pairs(self) -> Iterator[Cause]:
        """Couplings of two joints by a rotor or stage, if M lacks one of these and nothing else."""
        if "mass_matrix" not in self.problem.parts:
            return
        robot, q, names = (
            self.problem.robot,
            self.problem.states.q,
            self.problem.robot.coordinate_names,
        )
        places = self.problem.select_part("mass_matrix")
        if np.abs(self.difference[~places]).max(initial=0.0) > TOLERANCE:
            return
        sizes, bare = self.problem.sizes["mass_matrix"], self.table.bare
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
        at, _ = self.select_screened(slice(None), self.table.several)
        for number, body in enumerate(self.problem.robot.bodies):
            others = [self.table.change_body(number, each) for each in _vary_parameters(body)]
            columns = np.stack([self.row(each) for each in others], axis=1)
            few = columns[at] @ np.linalg.lstsq(columns[at], self.difference[at], rcond=1e-10)[0]
            least = np.linalg.norm(few - self.difference[at])  # that any values leave there
            if least > 2 * np.linalg.norm(self.allowed[at]):
                continue
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
    least = -SLENDER * moments[2]
    remark = ""
    if moments[0] < least or moments[0] + moments[1] - moments[2] < least:
        remark = "; no body has these: are its six numbers mixed up?"
    elif moments[0] < -least:
        axis = int(np.abs(np.linalg.eigh(inertia)[1][:, 0]).argmax())
        remark = f": a slender rod along {AXES[axis]}"
    return f"{link}: its inertia {', '.join(changed)}{remark}"


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


def _solve_step(linear: np.ndarray, square: np.ndarray, difference: np.ndarray) -> float:
    """x that makes linear x + square x^2 nearest to a difference; 0 if it changes nothing.

    Of two that do alike, as a ratio of either sign, the smaller one.
    """
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
    left = np.array([np.linalg.norm(difference - linear * x - square * x**2) for x in real])
    alike = real[left <= left.min() + ROUNDING * np.linalg.norm(difference)]
    return float(alike[int(np.argmin(np.abs(alike)))])


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


def find_causes(problem: ChangeProblem) -> list[Cause]:
    """Changes of which each alone explains all, the likeliest first."""
    return sorted(CauseSearch(problem).find_causes(), key=lambda cause: not cause.usual)

"""Which number, or which thing taken for another, makes a difference: of all parts, or of one."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from crosscheck.analytic.robot.model import AnalyticRobot
from crosscheck.checks.robots.sizes import TOLERANCE
from crosscheck.models.robot.robot import Level, Robot, RobotBody
from crosscheck.trial.robots.candidates import (
    ALIKE,
    USUAL,
    FrameMistake,
    RobotNumber,
    generate_frame_mistakes,
    get_link_name,
    is_physical,
    list_numbers,
    replace_part,
    steiner,
)
from crosscheck.trial.robots.judge import RobotEntry, RobotProblem, select_entry

# What an explanation may leave of each entry's largest difference; and of its size, by rounding.
LEFT, ROUNDING = 1e-5, 1e-12
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


@dataclass(frozen=True)
class _NumberEffect:
    """What a change of a number by its step does to a row: linear in it, and by its square."""

    number: RobotNumber
    linear: np.ndarray
    square: np.ndarray


class CauseSearch:
    """The search for what makes the difference between equations and a level.

    Rows hold the entries of all parts at all states over their sizes. Accelerations are held in
    the balance that they make, M a + bias + gravity - torques, on which numbers act by at most
    their square as well.
    """

    def __init__(self, problem: RobotProblem, level: Level) -> None:
        self.problem, self.level = problem, level
        robot = problem.robot
        self.robot = robot if level != "links" else replace(robot, rotors=(), stages=())
        self.base = self.row(self.robot)
        self.difference = self._user_row() - self.base
        self.allowed = self._compute_allowances()

    def row(self, robot: Robot) -> np.ndarray:
        """The parts by the project's own derivation of a robot, in one row."""
        q, v, a, torques = self.problem.states
        mass, bias, gravity = AnalyticRobot(robot, self.level).terms(q, v)
        held = bias + gravity
        values = self.problem.answers.values
        parts = {
            "mass_matrix": mass,
            "bias": bias,
            "gravity": gravity,
            "force": self.problem.loads_in_force - self.problem.weights_in_force(gravity),
        }
        if "inverse_dynamics" in values:
            whole = bias if self.problem.answers.weightless else held
            parts["inverse_dynamics"] = np.einsum("sij,sj->si", mass, a) + whole
        if "acceleration" in values:
            accelerated = np.einsum("sij,sj->si", mass, values["acceleration"])
            parts["acceleration"] = accelerated + held - torques
        return self._join_parts(parts)

    def _user_row(self) -> np.ndarray:
        values = dict(self.problem.answers.values)
        if "acceleration" in values:
            values["acceleration"] = np.zeros_like(values["acceleration"])
        return self._join_parts(values)

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

    @cached_property
    def _effects(self) -> list[_NumberEffect]:
        effects = []
        for number in list_numbers(self.robot):
            up, down = (
                self.row(number.put(number.value + sign * number.step)) - self.base
                for sign in (1, -1)
            )
            effects.append(_NumberEffect(number, (up - down) / 2, (up + down) / 2))
        return effects

    @cached_property
    def _mistake_effects(self) -> list[tuple[FrameMistake, np.ndarray]]:
        return [
            (each, self.row(each.robot) - self.base) for each in generate_frame_mistakes(self.robot)
        ]

    def find_causes(self, places: Places = slice(None)) -> list[Cause]:
        """Every single change that leaves nothing of the difference in some places of the row."""
        causes = [*self._number_causes(places), *self._mistake_causes(places)]
        if isinstance(places, slice) and self.level == "coupled":
            causes += self._missing_pairs()
        return causes

    def _number_causes(self, places: Places) -> Iterator[Cause]:
        for effect in self._effects:
            number, linear, square = effect.number, effect.linear, effect.square
            if number.factor and not isinstance(places, slice):
                continue  # which says no more of one part than one of its numbers
            by = _solve_step(linear[places], square[places], self.difference[places])
            if by and self.can_explain(linear * by + square * by**2, places):
                value = number.value + by * number.step
                if not self._is_usual(number, value) and not is_physical(number.put(value)):
                    continue
                if "acceleration" in self.problem.parts and not self._is_regular(number.put(value)):
                    continue
                missing = number.name if abs(value) < ALIKE * number.step else ""
                yield Cause(self._words(number, value), self._is_usual(number, value), missing)

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
        return usual or bool(self._equal_number_name(number, value))

    def _equal_number_name(self, number: RobotNumber, value: float) -> str:
        """The name of another number of the file that the value is, with its unit; '' for none."""
        if abs(value) < ALIKE * number.step or not number.unit:
            return ""
        names = [
            other.name
            for other in (effect.number for effect in self._effects)
            if other.unit == number.unit
            and other.name != number.name
            and abs(other.value - value) <= ALIKE * abs(value)
        ]
        return f"as {names[0]}" if names else ""

    def _mistake_causes(self, places: Places) -> list[Cause]:
        mistakes = [
            confusion
            for confusion, changed in self._mistake_effects
            if np.abs(changed[places]).max(initial=0.0) > TOLERANCE
            and self.can_explain(changed, places)
        ]
        single = [each for each in mistakes if not each.several]
        return [Cause(each.words, usual=True) for each in single or mistakes]

    def _missing_pairs(self) -> Iterator[Cause]:
        """Couplings of two joints by a rotor or stage, if M lacks one of these and nothing else."""
        if "mass_matrix" not in self.problem.parts:
            return
        robot, q, names = self.problem.robot, self.problem.states.q, self.problem.names
        places = self.select_places("mass_matrix")
        if np.abs(self.difference[~places]).max(initial=0.0) > TOLERANCE:
            return
        sizes = self.problem.sizes[self.level].mass_matrix
        bare = replace(robot, rotors=(), stages=())
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
        for number, body in enumerate(self.robot.bodies):
            changed = [
                replace_part(self.robot, "bodies", number, other)
                for other in _vary_parameters(body)
            ]
            columns = np.stack([self.row(each) - self.base for each in changed], axis=1)
            fit = np.linalg.lstsq(columns, self.difference, rcond=1e-10)[0]
            if self.can_explain(columns @ fit):
                yield get_link_name(self.robot, number)


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
    about = body.inertia + steiner(body.mass, body.com)
    size, inertia = 0.1 * body.mass, 0.1 * float(np.trace(about))
    for number in range(10):
        mass, first, second = body.mass, moments.copy(), about.copy()
        if number == 0:
            mass += size
        elif number < 4:
            first[number - 1] += size * max(float(np.abs(body.com).max()), 0.01)
        else:
            i, j = np.transpose(np.triu_indices(3))[number - 4]
            second[i, j] += inertia
            second[j, i] = second[i, j]
        com = first / mass
        yield RobotBody(mass, com, second - steiner(mass, com))

"""Which number, or which thing taken for another, makes a difference: of all parts, or of one."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from crosscheck.analytic.robot.model import AnalyticRobot
from crosscheck.cost.agreement import TOLERANCE
from crosscheck.models.robot.robot import Level, Robot, RobotBody
from crosscheck.trial.robots.candidates import (
    ALIKE,
    USUAL,
    Confusion,
    RobotNumber,
    confusions,
    link_of,
    numbers,
    steiner,
    with_part,
)
from crosscheck.trial.robots.judge import RobotEntry, RobotProblem, at_entry

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
        self.difference = self._own_row() - self.base
        self.allowed = self._allowed()

    def row(self, robot: Robot) -> np.ndarray:
        """The parts by the project's own derivation of a robot, in one row."""
        q, v, a, torques = self.problem.states
        mass, bias, gravity = AnalyticRobot(robot, self.level).terms(q, v)
        held = bias + gravity
        values = self.problem.answers.values
        found = {"mass_matrix": mass, "bias": bias, "gravity": gravity, "force": torques - gravity}
        if "inverse_dynamics" in values:
            whole = bias if self.problem.answers.weightless else held
            found["inverse_dynamics"] = np.einsum("sij,sj->si", mass, a) + whole
        if "acceleration" in values:
            accelerated = np.einsum("sij,sj->si", mass, values["acceleration"])
            found["acceleration"] = accelerated + held - torques
        return self._joined(found)

    def _own_row(self) -> np.ndarray:
        own = dict(self.problem.answers.values)
        if "acceleration" in own:
            own["acceleration"] = np.zeros_like(own["acceleration"])
        return self._joined(own)

    def _joined(self, found: dict[str, np.ndarray]) -> np.ndarray:
        sizes = self.problem.sizes[self.level]
        scaled = {
            part: found[part] / sizes.of("balance" if part == "acceleration" else part)
            for part in self.problem.parts
        }
        return np.concatenate([each.ravel() for each in scaled.values()])

    def _allowed(self) -> np.ndarray:
        """What an explanation may leave at each place of a row.

        An entry's own difference decides, so that a large one elsewhere hides nothing here.
        """
        sizes, found, start = self.problem.sizes[self.level], list[np.ndarray](), 0
        for part in self.problem.parts:
            shape = self.problem.answers.values[part].shape
            stop = start + int(np.prod(shape))
            largest = np.abs(self.difference[start:stop].reshape(shape)).max(axis=0)
            rounding = sizes.tolerance(part) if part == "acceleration" else ROUNDING
            found.append(np.broadcast_to(np.maximum(rounding, LEFT * largest), shape).ravel())
            start = stop
        return np.concatenate(found)

    def explains(self, change: np.ndarray, places: Places = slice(None)) -> bool:
        """Whether a change of the row leaves nothing of the difference at some places of it."""
        left = np.abs(self.difference[places] - change[places])
        return bool((left <= self.allowed[places]).all())

    def where(self, part: str = "", entry: RobotEntry | None = None) -> np.ndarray:
        """Which places of a row belong to a part, or to an entry and its mirror image."""
        places = []
        for each in self.problem.parts:
            shape = self.problem.answers.values[each].shape
            inside = np.full(shape, entry is None and each == part)
            if entry is not None and each == entry.part:
                for place in {entry.place, entry.place[::-1]}:
                    at_entry(inside, place)[:] = True
            places.append(inside.ravel())
        return np.concatenate(places)

    @cached_property
    def _effects(self) -> list[_NumberEffect]:
        found = []
        for number in numbers(self.robot):
            up, down = (
                self.row(number.put(number.value + sign * number.step)) - self.base
                for sign in (1, -1)
            )
            found.append(_NumberEffect(number, (up - down) / 2, (up + down) / 2))
        return found

    @cached_property
    def _confused(self) -> list[tuple[Confusion, np.ndarray]]:
        return [(each, self.row(each.robot) - self.base) for each in confusions(self.robot)]

    def causes(self, places: Places = slice(None)) -> list[Cause]:
        """Every single change that leaves nothing of the difference in some places of the row."""
        found = [*self._numbers(places), *self._confusions(places)]
        if isinstance(places, slice) and self.level == "coupled":
            found += self._missing_pairs()
        return found

    def _numbers(self, places: Places) -> Iterator[Cause]:
        for effect in self._effects:
            number, linear, square = effect.number, effect.linear, effect.square
            if number.factor and not isinstance(places, slice):
                continue  # which says no more of one part than one of its numbers
            by = _solved(linear[places], square[places], self.difference[places])
            if by and self.explains(linear * by + square * by**2, places):
                value = number.value + by * number.step
                missing = number.name if abs(value) < ALIKE * number.step else ""
                yield Cause(self._words(number, value), self._is_usual(number, value), missing)

    def _words(self, number: RobotNumber, value: float) -> str:
        same = self._same_as(number, value)
        return number.words(value) + (f", {same}" if same else "")

    def _is_usual(self, number: RobotNumber, value: float) -> bool:
        usual = any(abs(value - by * number.value) < ALIKE * number.step for by in USUAL)
        return usual or bool(self._same_as(number, value))

    def _same_as(self, number: RobotNumber, value: float) -> str:
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

    def _confusions(self, places: Places) -> list[Cause]:
        found = [
            confusion
            for confusion, changed in self._confused
            if np.abs(changed[places]).max(initial=0.0) > TOLERANCE
            and self.explains(changed, places)
        ]
        single = [each for each in found if not each.several]
        return [Cause(each.words, usual=True) for each in single or found]

    def _missing_pairs(self) -> Iterator[Cause]:
        """Couplings of two joints by a rotor or stage, if M lacks one of these and nothing else."""
        if "mass_matrix" not in self.problem.parts:
            return
        robot, q, names = self.problem.robot, self.problem.states.q, self.problem.names
        places = self.where("mass_matrix")
        if np.abs(self.difference[~places]).max(initial=0.0) > TOLERANCE:
            return
        sizes = self.problem.sizes[self.level].mass_matrix
        bare = replace(robot, rotors=(), stages=())
        gears = [("rotor", own.joint, replace(bare, rotors=(own,))) for own in robot.rotors]
        gears += [("stage", own.joint, replace(bare, stages=(own,))) for own in robot.stages]
        for kind, joint, alone in gears:
            pair = AnalyticRobot(alone, "coupled").mass_matrix(q)
            pair = (pair - AnalyticRobot(alone, "links").mass_matrix(q)) / sizes
            for i, j in zip(*np.triu_indices(len(names), 1), strict=True):
                wanted, row = np.zeros_like(pair), np.zeros_like(self.difference)
                wanted[:, i, j] = wanted[:, j, i] = -pair[:, i, j]
                row[places] = wanted.ravel()
                if np.abs(wanted).max() > TOLERANCE and self.explains(row):
                    own = robot.joints[joint].name
                    yield Cause(
                        f"no coupling of {names[i]} and {names[j]} in M by the {kind} of {own}",
                        usual=True,
                    )

    def links(self) -> Iterator[str]:
        """Links whose mass, first moments and inertia about the joint make the difference."""
        for number, body in enumerate(self.robot.bodies):
            changed = [with_part(self.robot, "bodies", number, other) for other in _ten(body)]
            columns = np.stack([self.row(each) - self.base for each in changed], axis=1)
            fit = np.linalg.lstsq(columns, self.difference, rcond=1e-10)[0]
            if self.explains(columns @ fit):
                yield link_of(self.robot, number)


def _solved(linear: np.ndarray, square: np.ndarray, difference: np.ndarray) -> float:
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


def _ten(body: RobotBody) -> Iterator[RobotBody]:
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

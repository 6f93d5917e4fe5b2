"""Equations of a robot beside its levels: which level they are of, and which entries differ."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from crosscheck.analytic.robot.model import AnalyticRobot
from crosscheck.checks.robot_states import RandomStates, RobotSizes
from crosscheck.findings import (
    ComparisonKey,
    Finding,
    Subject,
    make_check,
    make_failed_check,
    make_unfinished_check,
)
from crosscheck.models.errors import format_line
from crosscheck.models.robot.interface import RobotModel
from crosscheck.models.robot.robot import Level, Robot
from crosscheck.registry import build_robot_model, find_level_engines
from crosscheck.runner.outcomes import Failure
from crosscheck.trial.changes.problem import ChangeProblem
from crosscheck.trial.robots.answers import SPEEDS, RobotAnswers
from crosscheck.trial.robots.consistency import SLOPES, SelfDifference

SINGLE = ("mass_matrix", "bias", "gravity")  # elementary parts, from which the others are composed
JUDGED = (*SINGLE, "inverse_dynamics", "force", "acceleration")
LETTERS = {"mass_matrix": "M"}
OWN, AGAINST = "trial-own", "trial-states"
METRIC = "largest difference of an entry over the random states, over its natural size"


@dataclass(frozen=True)
class RobotEntry:
    """An entry of a part that differs from the level: by how much of its size, and its place.

    place: row and column of M, the row alone of other parts. Of a symmetric pair of M's entries
    that differ alike there is the upper one. remark: what the entry is beside the right one.
    """

    part: str
    name: str
    share: float
    place: tuple[int, ...]
    remark: str = ""


@dataclass(frozen=True)
class LevelDistance:
    """A level beside the equations: how many entries differ; largest and mean share of a size."""

    level: Level
    entries: int
    largest: float
    mean: float


@dataclass(frozen=True)
class RobotProblem:
    """Equations of a robot, by name, and their answers at states.

    sizes: by level, of each that equations may be of; stated: the level that these are to be of;
    self_differences: by part, how far it is from what the equations owe to themselves; friction
    (states, n): the torques that it takes, which those of the states are without; stiffness (n, n):
    of springs, whose torques stand beside the weights.
    """

    name: str
    robot: Robot
    states: RandomStates
    sizes: Mapping[Level, RobotSizes]
    answers: RobotAnswers
    stated: str
    self_differences: Mapping[str, SelfDifference] = field(default_factory=dict)
    friction: np.ndarray = field(default_factory=lambda: np.zeros(1))
    stiffness: np.ndarray = field(default_factory=lambda: np.zeros((1, 1)))

    @property
    def parts(self) -> tuple[str, ...]:
        """The quantities that the equations have answered, in the order of JUDGED."""
        return tuple(part for part in JUDGED if part in self.answers.values)

    @property
    def names(self) -> list[str]:
        """Names of the coordinates: of the joints that move them."""
        return self.robot.coordinate_names

    @cached_property
    def reference_values(self) -> dict[Level, Mapping[str, np.ndarray]]:
        """Values of each part by the project's own derivation, by level."""
        return {
            level: self.evaluate_model(AnalyticRobot(self.robot, level)) for level in self.sizes
        }

    def compare(self, level: Level) -> ChangeProblem:
        """The difference from a level, for the search of its causes."""
        sizes, parts = self.sizes[level], {*self.parts, "mass_matrix"}
        by_part = {part: sizes.entry_sizes(part) for part in parts - {"acceleration"}}
        return ChangeProblem(
            robot=self.robot,
            level=level,
            states=self.states._replace(torques=self.states.torques - self.spring_torques),
            values={part: self.answers.values[part] for part in self.parts},
            right=self.reference_values[level],
            sizes=by_part | {"acceleration": sizes.entry_sizes("balance")},
            tolerances={part: sizes.tolerance(part) for part in self.parts},
            is_weightless=self.answers.weightless,
            is_driven=self.answers.driven,
        )

    def are_alike(self, level: Level, other: Level) -> bool:
        """Whether two levels say the same of each part, as of a robot without rotors."""
        here, there = self.reference_values[level], self.reference_values[other]
        return all(np.array_equal(here[part], there[part]) for part in self.parts)

    def evaluate_model(self, model: RobotModel) -> dict[str, np.ndarray]:
        """Values of each part of the equations by a model, as the equations define them."""
        q, v, a, torques = self.states
        held, weights = self.spring_torques, self.spring_torques + model.gravity(q)
        meant = {
            "mass_matrix": lambda: model.mass_matrix(q),
            "bias": lambda: model.bias(q, v),
            "gravity": lambda: weights,
            "inverse_dynamics": lambda: (
                model.inverse_dynamics(q, v, a) + held - weights * self.answers.weightless
            ),
            "force": lambda: self.loads_in_force - self.weights_in_force(weights),
            "acceleration": lambda: model.forward_dynamics(q, v, torques - held),
        }
        return {part: meant[part]() for part in self.parts}

    @cached_property
    def spring_torques(self) -> np.ndarray:
        """Torques that hold the springs (states, n); 0 without springs."""
        q = self.states.q
        return q @ self.stiffness if self.stiffness.any() else 0 * q

    @property
    def loads_in_force(self) -> np.ndarray:
        """The motors' torques (states, n), less friction unless the bias has it."""
        taken = self.friction if self.answers.friction_in_bias else 0.0
        return self.states.torques + taken

    def weights_in_force(self, weights: np.ndarray) -> np.ndarray:
        """The weights (states, n), or 0 where force is the motors' torques alone."""
        return 0 * weights if self.answers.driven else weights

    def relative_errors(
        self, level: Level, reference_values: Mapping[str, np.ndarray]
    ) -> dict[str, np.ndarray]:
        """By part, the differences from what is right over their sizes (states, ...)."""
        sizes, answers = self.sizes[level], self.answers
        return {
            part: (answers.values[part] - reference_values[part])
            / sizes.entry_sizes(part, answers.sources[part])
            for part in self.parts
        }

    def find_self_places(self, part: str, level: Level) -> list[tuple[int, ...]]:
        """The entries of a part that do not keep what the equations owe to themselves."""
        if part not in self.self_differences:
            return []
        sizes = self._self_sizes(part, level)
        tolerance = SLOPES * self.sizes[level].tolerance(part)
        return self.self_differences[part].find_places(sizes, tolerance)

    def _self_sizes(self, part: str, level: Level) -> np.ndarray:
        """Sizes of what a part is compared with: of bias (states, n), of gravity's slopes too."""
        count = len(self.self_differences[part].values)
        sizes = self.sizes[level].entry_sizes(part, self.answers.sources[part])[:count]
        return sizes if part == "bias" else np.maximum(sizes[:, :, None], sizes[:, None, :])

    def self_error(self, part: str, level: Level) -> float:
        """The largest difference of a part from what it owes, beyond what may be, over its size."""
        difference = self.self_differences[part]
        beyond = np.maximum(np.abs(difference.values) - difference.allowed, 0.0)
        return float((beyond / self._self_sizes(part, level)).max())

    def find_indefinite_states(self, level: Level) -> list[int]:
        """The states at which the symmetric part of M has an eigenvalue that is not positive."""
        if "mass_matrix" not in self.answers.values:
            return []
        scaled = self.answers.values["mass_matrix"] / self.sizes[level].mass_matrix
        lowest = np.linalg.eigvalsh((scaled + scaled.swapaxes(1, 2)) / 2)[:, 0]
        return np.flatnonzero(lowest <= 0).tolist()

    def entries(self, level: Level) -> list[RobotEntry]:
        """The entries that differ from a level by more than rounding, the largest share first."""
        wrong_entries = [
            entry
            for part, errors in self.relative_errors(level, self.reference_values[level]).items()
            for entry in self._find_wrong_entries(part, errors, self.sizes[level].tolerance(part))
        ]
        return sorted(wrong_entries, key=lambda entry: -entry.share)

    def _find_wrong_entries(
        self, part: str, relative_errors: np.ndarray, tolerance: float
    ) -> Iterator[RobotEntry]:
        largest = np.abs(relative_errors).max(axis=0)
        for index in np.argwhere(~(largest <= tolerance)).tolist():
            place = tuple(index)
            mirrored = place[::-1]
            if place > mirrored and largest[mirrored] > tolerance:
                unlike = np.abs(
                    select_entry(relative_errors, place) - select_entry(relative_errors, mirrored)
                )
                if unlike.max() <= tolerance:
                    continue
            yield RobotEntry(part, self.entry_name(part, place), float(largest[place]), place)

    def entry_name(self, part: str, place: Sequence[int]) -> str:
        """An entry in words, such as M[shoulder, elbow]."""
        return f"{LETTERS.get(part, part)}[{', '.join(self.names[n] for n in place)}]"

    def distances(self) -> list[LevelDistance]:
        """Each level beside the equations, the stated one first, then that of the fewest entries.

        Of as many the one with the least mean; of several that agree the first. One large error
        must not choose a level from which right entries differ.
        """
        distances = []
        for level in self.sizes:
            relative_errors = self.relative_errors(level, self.reference_values[level])
            shares = np.concatenate(
                [np.abs(errors).max(axis=0).ravel() for errors in relative_errors.values()]
            )
            mean = float(shares.mean())
            distances.append(
                LevelDistance(level, len(self.entries(level)), float(shares.max()), mean)
            )

        def order(each: LevelDistance) -> tuple[bool, int, float]:
            return each.level != self.stated, each.entries, each.mean if each.entries else 0.0

        return sorted(distances, key=order)


def select_entry(values: np.ndarray, place: tuple[int, ...]) -> np.ndarray:
    """An entry of a part (states, ...) at all states, (states,)."""
    index: tuple[Any, ...] = (slice(None), *place)
    entry: np.ndarray = values[index]
    return entry


def collect_findings(problem: RobotProblem, level: Level) -> list[Finding]:
    """All checks: what the equations owe to themselves, then to every engine of the level."""
    lost = problem.answers.failures
    parts = [_failure_finding(problem, part, why) for part, why in lost.items()]
    self_checks = [*_self_checks(problem, level), *_own_checks(problem, level)]
    return [*parts, *self_checks, *_engine_findings(problem, level)]


def _failure_finding(problem: RobotProblem, part: str, why: Failure) -> Finding:
    about = _make_subject(problem, OWN, f"answers-{part}", "an answer at every state")
    return (make_unfinished_check if why.unfinished else make_failed_check)(about, f"{part}: {why}")


def _make_subject(
    problem: RobotProblem, family: str, quantity: str, against: str, engine: str = ""
) -> Subject:
    key = ComparisonKey(family, problem.robot.name, quantity, problem.name, engine)
    return Subject(key, "1", METRIC, against)


def _self_checks(problem: RobotProblem, level: Level) -> Iterator[Finding]:
    """Checks without an engine: the levels lend their sizes alone."""
    answers, sizes = problem.answers, problem.sizes[level]
    for part, again in answers.again.items():
        relative_errors = (answers.values[part] - again) / sizes.entry_sizes(
            part, answers.sources[part]
        )
        yield _check_errors(problem, f"repeatable-{part}", part, relative_errors, sizes)
    if "mass_matrix" in answers.values:
        mass = answers.values["mass_matrix"]
        relative_errors = (mass - mass.swapaxes(1, 2)) / sizes.mass_matrix
        yield _check_errors(problem, "symmetric", "mass_matrix", relative_errors, sizes)
        about = _make_subject(problem, OWN, "positive-definite", "first principles")
        if indefinite := len(problem.find_indefinite_states(level)):
            yield make_failed_check(about, f"an eigenvalue is not positive at {indefinite} states")
        else:
            yield make_check(about, measured=0.0, tolerance=0.0, basis="all eigenvalues positive")
    if answers.speeds is not None and "bias" in answers.values:
        size = sizes.entry_sizes("bias", answers.sources["bias"])[:, None]
        squares = np.array(SPEEDS)[:, None] ** 2
        relative_errors = (
            (answers.speeds - squares * answers.speeds[:, :1]) / size / np.maximum(squares, 1.0)
        )
        yield _check_errors(
            problem, "bias-quadratic", "bias", relative_errors.swapaxes(1, 2), sizes
        )


def _own_checks(problem: RobotProblem, level: Level) -> Iterator[Finding]:
    """Checks of the bias against M, and of gravity as a gradient."""
    names = {"bias": "bias-from-inertia", "gravity": "gravity-is-a-gradient"}
    sizes = problem.sizes[level]
    for part in problem.self_differences:
        about = _make_subject(problem, OWN, names[part], "first principles")
        measured, tolerance = problem.self_error(part, level), SLOPES * sizes.tolerance(part)
        basis = f"{sizes.basis(part)}, {SLOPES:.3g} times for differences of answers"
        yield make_check(about, measured=measured, tolerance=tolerance, basis=basis)


def _check_errors(
    problem: RobotProblem, quantity: str, part: str, relative_errors: np.ndarray, sizes: RobotSizes
) -> Finding:
    about = _make_subject(problem, OWN, quantity, "first principles")
    measured, tolerance = float(np.abs(relative_errors).max()), sizes.tolerance(part)
    return make_check(about, measured=measured, tolerance=tolerance, basis=sizes.basis(part))


def _engine_findings(problem: RobotProblem, level: Level) -> Iterator[Finding]:
    """Every part compared with every engine; one that raises fails there."""
    sizes = problem.sizes[level]
    for engine in find_level_engines(level):
        try:
            relative_errors = problem.relative_errors(
                level, problem.evaluate_model(build_robot_model(engine, problem.robot, level))
            )
        except Exception as error:  # whatever an engine raises is reported as a failure
            message = format_line(f"{engine} raised {type(error).__name__}: {error}")
            yield from (
                make_failed_check(_make_subject(problem, AGAINST, part, "", engine), message)
                for part in problem.parts
            )
            continue
        for part, errors in relative_errors.items():
            yield make_check(
                _make_subject(problem, AGAINST, part, "", engine),
                measured=float(np.abs(errors).max()),
                tolerance=sizes.tolerance(part),
                basis=sizes.basis(part),
            )


def has_engine_conflict(findings: Sequence[Finding]) -> bool:
    """Whether engines judge a part in different ways, so that one of them must be wrong."""
    verdicts: dict[str, set[str]] = {}
    for finding in findings:
        if finding.about.key.family == AGAINST:
            verdicts.setdefault(finding.quantity, set()).add(finding.verdict)
    return any(len(each) > 1 for each in verdicts.values())

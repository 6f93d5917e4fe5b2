"""Equations of a robot beside its levels: which level they are of, and which entries differ."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from crosscheck.analytic.robot.model import AnalyticRobot
from crosscheck.cost.agreement import DrawnStates
from crosscheck.cost.engines import engines, model_of
from crosscheck.findings import About, Finding, Key, checked, failed, unfinished
from crosscheck.models.errors import one_line
from crosscheck.models.robot.interface import RobotModel
from crosscheck.models.robot.robot import Level, Robot
from crosscheck.runner.outcomes import Failure
from crosscheck.trial.robots.answers import SPEEDS, RobotAnswers
from crosscheck.trial.robots.sizes import RobotSizes

SINGLE = ("mass_matrix", "bias", "gravity")  # of which the others are made
JUDGED = (*SINGLE, "inverse_dynamics", "force", "acceleration")
LETTERS = {"mass_matrix": "M"}
OWN, AGAINST = "trial-own", "trial-states"
METRIC = "largest difference of an entry over the random states, over its natural size"


@dataclass(frozen=True)
class RobotEntry:
    """An entry of a part that differs from the level: by how much of its size, and its place.

    place: row and column of M, the row alone of other parts. Of a symmetric pair of M's entries
    that differ alike there is the upper one. said: what the entry is beside the right one.
    """

    part: str
    name: str
    share: float
    place: tuple[int, ...]
    said: str = ""


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

    sizes: by level, of each that equations may be of; stated: the level that these are to be of.
    """

    name: str
    robot: Robot
    states: DrawnStates
    sizes: Mapping[Level, RobotSizes]
    answers: RobotAnswers
    stated: str

    @property
    def parts(self) -> tuple[str, ...]:
        """The quantities that the equations have answered, in the order of JUDGED."""
        return tuple(part for part in JUDGED if part in self.answers.values)

    @property
    def names(self) -> list[str]:
        """Names of the coordinates: of the joints that move them."""
        return [self.robot.joints[number].name for number in self.robot.coordinates]

    @cached_property
    def right(self) -> dict[Level, Mapping[str, np.ndarray]]:
        """What the project's own derivation says of each part, by level."""
        return {level: self.said(AnalyticRobot(self.robot, level)) for level in self.sizes}

    def said(self, model: RobotModel) -> dict[str, np.ndarray]:
        """What a model says of each part of the equations, in their meaning."""
        q, v, a, torques = self.states
        meant = {
            "mass_matrix": lambda: model.mass_matrix(q),
            "bias": lambda: model.bias(q, v),
            "gravity": lambda: model.gravity(q),
            "inverse_dynamics": lambda: model.inverse_dynamics(q, v, a) - self.left_out(model),
            "force": lambda: torques - model.gravity(q),
            "acceleration": lambda: model.forward_dynamics(q, v, torques),
        }
        return {part: meant[part]() for part in self.parts}

    def left_out(self, model: RobotModel) -> np.ndarray:
        """The weights, where inverse dynamics leaves them out; else 0."""
        weights = model.gravity(self.states.q)
        return weights if self.answers.weightless else 0 * weights

    def apart(self, level: Level, right: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
        """By part, the differences from what is right over their sizes (states, ...)."""
        sizes, own = self.sizes[level], self.answers
        return {
            part: (own.values[part] - right[part]) / sizes.of(part, own.sources[part])
            for part in self.parts
        }

    def entries(self, level: Level) -> list[RobotEntry]:
        """The entries that differ from a level by more than rounding, the largest share first."""
        found = [
            entry
            for part, own in self.apart(level, self.right[level]).items()
            for entry in self._beyond(part, own, self.sizes[level].tolerance(part))
        ]
        return sorted(found, key=lambda entry: -entry.share)

    def _beyond(self, part: str, apart: np.ndarray, tolerance: float) -> Iterator[RobotEntry]:
        largest = np.abs(apart).max(axis=0)
        for index in np.argwhere(~(largest <= tolerance)).tolist():
            place = tuple(index)
            mirrored = place[::-1]
            if place > mirrored and largest[mirrored] > tolerance:
                unlike = np.abs(at_entry(apart, place) - at_entry(apart, mirrored))
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
        found = []
        for level in self.sizes:
            apart = self.apart(level, self.right[level])
            shares = np.concatenate([np.abs(own).max(axis=0).ravel() for own in apart.values()])
            mean = float(shares.mean())
            found.append(LevelDistance(level, len(self.entries(level)), float(shares.max()), mean))

        def order(each: LevelDistance) -> tuple[bool, int, float]:
            return each.level != self.stated, each.entries, each.mean if each.entries else 0.0

        return sorted(found, key=order)


def at_entry(values: np.ndarray, place: tuple[int, ...]) -> np.ndarray:
    """An entry of a part (states, ...) at all states, (states,)."""
    index: tuple[Any, ...] = (slice(None), *place)
    found: np.ndarray = values[index]
    return found


def findings_of(problem: RobotProblem, level: Level) -> list[Finding]:
    """All checks: what the equations owe to themselves, then to every engine of the level."""
    lost = problem.answers.failures
    parts = [_not_answered(problem, part, why) for part, why in lost.items()]
    return [*parts, *_own(problem, level), *_against_engines(problem, level)]


def _not_answered(problem: RobotProblem, part: str, why: Failure) -> Finding:
    about = _about(problem, OWN, f"answers-{part}", "an answer at every state")
    return (unfinished if why.unfinished else failed)(about, f"{part}: {why}")


def _about(
    problem: RobotProblem, family: str, quantity: str, against: str, engine: str = ""
) -> About:
    key = Key(family, problem.robot.name, quantity, problem.name, engine)
    return About(key, "1", METRIC, against)


def _own(problem: RobotProblem, level: Level) -> Iterator[Finding]:
    """Checks without an engine: the levels lend their sizes alone."""
    own, sizes = problem.answers, problem.sizes[level]
    for part, again in own.again.items():
        apart = (own.values[part] - again) / sizes.of(part, own.sources[part])
        yield _checked(problem, f"repeatable-{part}", part, apart, sizes)
    if "mass_matrix" in own.values:
        mass = own.values["mass_matrix"]
        apart = (mass - mass.swapaxes(1, 2)) / sizes.mass_matrix
        yield _checked(problem, "symmetric", "mass_matrix", apart, sizes)
    if own.speeds is not None and "bias" in own.values:
        size = sizes.of("bias", own.sources["bias"])[:, None]
        squares = np.array(SPEEDS)[:, None] ** 2
        apart = (own.speeds - squares * own.speeds[:, :1]) / size / np.maximum(squares, 1.0)
        yield _checked(problem, "bias-quadratic", "bias", apart.swapaxes(1, 2), sizes)


def _checked(
    problem: RobotProblem, quantity: str, part: str, apart: np.ndarray, sizes: RobotSizes
) -> Finding:
    about = _about(problem, OWN, quantity, "first principles")
    measured, tolerance = float(np.abs(apart).max()), sizes.tolerance(part)
    return checked(about, measured=measured, tolerance=tolerance, basis=sizes.basis(part))


def _against_engines(problem: RobotProblem, level: Level) -> Iterator[Finding]:
    """Every part compared with every engine; one that raises fails there."""
    sizes = problem.sizes[level]
    for engine in [name for name, entry in engines().items() if entry.promises(level)]:
        try:
            apart = problem.apart(level, problem.said(model_of(engine, problem.robot, level)))
        except Exception as error:  # whatever an engine raises is told, and fails
            said = one_line(f"{engine} raised {type(error).__name__}: {error}")
            yield from (
                failed(_about(problem, AGAINST, part, "", engine), said) for part in problem.parts
            )
            continue
        for part, own in apart.items():
            yield checked(
                _about(problem, AGAINST, part, "", engine),
                measured=float(np.abs(own).max()),
                tolerance=sizes.tolerance(part),
                basis=sizes.basis(part),
            )


def engines_differ(findings: Sequence[Finding]) -> bool:
    """Whether engines judge a part in different ways, so that one of them must be wrong."""
    verdicts: dict[str, set[str]] = {}
    for finding in findings:
        if finding.about.key.family == AGAINST:
            verdicts.setdefault(finding.quantity, set()).add(finding.verdict)
    return any(len(each) > 1 for each in verdicts.values())

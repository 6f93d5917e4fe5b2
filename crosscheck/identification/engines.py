"""Whether the engines agree on the torques of a recorded motion: Findings, as of every check.

Each model is asked at some rows, at each rigid level that differs. Without agreement nothing is
judged.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from crosscheck.checks.answers import require_numbers
from crosscheck.checks.scales import check_share, share_of
from crosscheck.findings import ComparisonKey, Finding, Subject
from crosscheck.identification.mechanism import ComparedMechanism, RigidLevel
from crosscheck.models.pinocchio.regressor import LinkRegressor
from crosscheck.models.robot.robot import Robot
from crosscheck.planning.comparison import (
    Comparison,
    Results,
    collect_tasks,
    judge_comparisons,
    make_comparison,
)
from crosscheck.registry import build_robot_model, find_level_engines
from crosscheck.runner.outcomes import return_failures
from crosscheck.runner.workers import perform_all

ENGINE_ROWS = 1000
QUANTITY = "inverse_dynamics"
TOLERANCE = 1e-10  # share of the sum of a torque's terms; rounding explains 1e-15
REGRESSOR = "regressor"  # name of Pinocchio's regressor, by which links are estimated
Motion = tuple[np.ndarray, np.ndarray, np.ndarray]  # positions, rates, accelerations (rows, n)


@dataclass(frozen=True, eq=False)
class MotionTorques:
    """A task: the torques (rows, n) of a model along a motion."""

    model: str
    build: Callable[[], Any]
    motion: Motion

    @property
    def key(self) -> str:
        """The model: a comparison is of one motion."""
        return self.model

    @property
    def cost(self) -> float:
        """Estimated cost [s]."""
        return 0.05 + 5e-5 * self.motion[0].size

    @return_failures
    def perform(self) -> np.ndarray:
        """The torques, or a Failure where there are none."""
        answer = self.build().inverse_dynamics(*self.motion)
        return require_numbers(answer, "torques", self.motion[0].shape)


class _RegressorModel:
    """The torques of a robot's links by the regressor, with viscous friction."""

    def __init__(self, robot: Robot) -> None:
        self._regressor, self._friction = LinkRegressor(robot), robot.friction

    def inverse_dynamics(self, q: np.ndarray, v: np.ndarray, a: np.ndarray) -> np.ndarray:
        links: np.ndarray = self._regressor.compute(q, v, a) @ self._regressor.values
        return links + self._friction * v


def compare_engines(mechanism: ComparedMechanism, motion: Motion) -> list[Finding]:
    """Torques of every model against the reference's, at each rigid level that differs."""
    comparisons = [
        each for level in mechanism.levels for each in plan_level(mechanism, level, motion)
    ]
    outcomes = perform_all(collect_tasks(comparisons), os.cpu_count() or 1)
    return list(judge_comparisons(comparisons, Results(outcomes)))


def plan_level(
    mechanism: ComparedMechanism, level: RigidLevel, motion: Motion
) -> Iterator[Comparison]:
    """Comparisons of the first engine with all other models at a level."""
    rows = np.unique(np.linspace(0, len(motion[0]) - 1, ENGINE_ROWS).astype(int))
    q, v, a = (part[rows] for part in motion)
    models: list[tuple[str, Callable[[], Any]]] = [  # names, and what builds them
        (f"{engine}:{level.name}", partial(build_robot_model, engine, level.robot, level.level))
        for engine in find_level_engines(level.level)
    ]
    if level.level == "links":
        models.append((f"{REGRESSOR}:{level.name}", partial(_RegressorModel, level.robot)))
    models += mechanism.list_further_models(level.name)
    reference = MotionTorques(*models[0], (q, v, a))
    size = _measure_terms(level.robot, (q, v, a)).max(axis=0)
    size = np.where(size > 0, size, 1.0)
    for each in models[1:]:
        task = MotionTorques(*each, (q, v, a))
        case = f"{mechanism.name}/{level.name}"
        key = ComparisonKey("recording", case, QUANTITY, reference.model, task.model)
        about = Subject(key, "1", f"largest difference, over its terms' size, in {len(rows)} rows")

        def judge(about: Subject, expected: np.ndarray, torques: np.ndarray) -> Finding:
            basis = f"{TOLERANCE:.2g} of the sum of the sizes of a torque's terms"
            return check_share(about, share_of(torques - expected, size), TOLERANCE, basis)

        yield make_comparison(about, (reference, task), judge)


def _measure_terms(robot: Robot, motion: Motion) -> np.ndarray:
    """The sums (rows, n) of the magnitudes that each number of a body adds to a torque.

    Of a body that is the same all around its joint's axis the torque is nothing but what rounding
    leaves of these.
    """
    regressor = LinkRegressor(robot)
    sizes: np.ndarray = np.abs(regressor.compute(*motion)) @ np.abs(regressor.values)
    return sizes


def describe_engines(engines: Sequence[Finding]) -> Iterator[str]:
    """One line where all engines agree, with the largest difference; else one for each engine."""
    if all(finding.verdict == "agree" for finding in engines):
        furthest = max(engines, key=lambda finding: finding.measured or 0.0)
        others = f"the furthest of {len(engines)} comparisons is {furthest.right}"
        yield f"all engines agree; {others}: {format_difference(furthest)}"
        return
    for finding in engines:
        verdict = "agrees with" if finding.verdict == "agree" else "DIFFERS from"
        yield f"{finding.right} {verdict} {finding.left}: {format_difference(finding)}"


def describe_disagreement(engines: Sequence[Finding], what: str) -> Iterator[str]:
    """The engines that disagree, and the one that differs from all others."""
    wrong = [engine for engine in engines if engine.verdict != "agree"]
    # One that gave no number before those that are apart.
    worst = max(wrong, key=lambda engine: engine.measured or np.inf)
    yield (
        f"The engines do not agree on the {what}'s torques: {worst.right} and {worst.left},"
        f" {format_difference(worst)}. Nothing is said about the recording."
    )
    for level in dict.fromkeys(engine.left for engine in wrong):
        compared = [engine for engine in engines if engine.left == level]
        differing = [engine for engine in compared if engine.verdict != "agree"]
        if len(compared) == 1:  # of two nobody is alone
            continue
        if len(differing) == 1:
            yield f"{differing[0].right} stands alone: every other model agrees with {level}."
        elif len(differing) == len(compared):
            yield f"{level} stands alone: every other model differs from it."


def format_difference(finding: Finding) -> str:
    """The difference of an engine from the reference, or the reason why there is no number."""
    if finding.measured is None or finding.tolerance is None:
        return finding.note
    return (
        f"{finding.measured:.1e} of the torques' terms apart, at most {finding.tolerance:.1e} is"
        " rounding"
    )

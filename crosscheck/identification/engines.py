"""Whether the engines agree on a robot's torques along a recording: Findings, as of every check."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from crosscheck.checks.robots.case import ask, check_share, share_of
from crosscheck.findings import ComparisonKey, Finding, Subject
from crosscheck.identification.sampling import BandSample
from crosscheck.models.pinocchio.regressor import LinkRegressor
from crosscheck.models.robot.robot import RIGID, Level, Robot
from crosscheck.planning.comparison import (
    Comparison,
    ModelTask,
    Results,
    collect_tasks,
    judge_comparisons,
    make_comparison,
)
from crosscheck.registry import (
    build_robot_model,
    engine_of,
    find_level_engines,
    reference_engine,
)
from crosscheck.runner.outcomes import return_failures
from crosscheck.runner.tasks import RobotKey
from crosscheck.runner.workers import perform_all

ENGINE_ROWS = 1000
TOLERANCE = 1e-10  # of the sizes of a torque's terms, of which rounding explains 1e-15
REGRESSOR = "regressor:links"  # of Pinocchio, by which links are estimated
QUANTITY = "inverse_dynamics"
Motion = tuple[np.ndarray, np.ndarray, np.ndarray]  # positions, rates, accelerations (rows, n)


@dataclass(frozen=True, eq=False)
class TorqueTask:
    """What tasks on a robot's torques along a motion have in common; model: ``engine:level``."""

    model: str
    robot: Robot
    motion: Motion

    @property
    def key(self) -> RobotKey:
        """The model, and what it is asked: a comparison is of one robot."""
        return RobotKey(self.model, QUANTITY)

    @property
    def cost(self) -> float:
        """Estimated cost [s]."""
        return 0.05 + 5e-5 * self.motion[0].size


@dataclass(frozen=True, eq=False)
class MotionTorques(TorqueTask):
    """The torques (rows, n) of a model."""

    level: Level

    @return_failures
    def perform(self) -> np.ndarray:
        """The torques, or a Failure where there are none."""
        model = build_robot_model(engine_of(self.model), self.robot, self.level)
        return ask(model, QUANTITY, self.motion[0].shape, *self.motion)


class RegressorTorques(TorqueTask):
    """The torques of the URDF's links by the regressor, and the sizes of their terms."""

    @return_failures
    def perform(self) -> np.ndarray:
        """Torques, then the sums of the sizes of their terms (2, rows, n), or a Failure."""
        regressor = LinkRegressor(self.robot)
        slopes = regressor.compute(*self.motion)
        return np.stack([slopes @ regressor.values, np.abs(slopes) @ np.abs(regressor.values)])


def compare_engines(robot: Robot, samples: BandSample) -> list[Finding]:
    """Torques of every engine on the record against the reference's, level by level.

    The regressor's torques of the URDF's links are among them.
    """
    comparisons = list(plan_engines(robot, samples))
    outcomes = perform_all(collect_tasks(comparisons), os.cpu_count() or 1, lambda key: None)
    return list(judge_comparisons(comparisons, Results(outcomes)))


def plan_engines(robot: Robot, samples: BandSample) -> Iterator[Comparison]:
    """The comparison of each engine with the reference at each rigid level that differs."""
    rows = np.unique(np.linspace(0, len(samples.q) - 1, ENGINE_ROWS).astype(int))
    motion = samples.q[rows], samples.v[rows], samples.a[rows]
    links = RegressorTorques(REGRESSOR, robot, motion)
    for level in RIGID if robot.rotors or robot.stages else RIGID[:1]:
        reference = MotionTorques(f"{reference_engine()}:{level}", robot, motion, level)
        others = [
            MotionTorques(f"{engine}:{level}", robot, motion, level)
            for engine in find_level_engines(level)
            if engine != reference_engine()
        ]
        against: list[ModelTask] = [links, *others] if level == "links" else [*others]
        for other in against:
            case = f"{robot.name}/{level}"
            key = ComparisonKey("recording", case, QUANTITY, reference.model, other.model)
            metric = (
                f"largest difference, over the size of its terms, in {len(rows)} rows of the"
                " recording"
            )
            yield make_comparison(Subject(key, "1", metric), (links, reference, other), _judge)


def _judge(about: Subject, links: np.ndarray, expected: np.ndarray, other: np.ndarray) -> Finding:
    """The Finding of a difference of torques (rows, n); links (2, rows, n): and their sizes."""
    size = links[1].max(axis=0)
    size = np.where(size > 0, size, 1.0)
    torques = other[0] if other.ndim > expected.ndim else other
    measured = share_of(torques - expected, np.maximum(size, np.abs(expected).max(axis=0)))
    return check_share(about, measured, TOLERANCE, f"{TOLERANCE:g} of the size of a torque's terms")

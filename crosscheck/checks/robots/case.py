"""Models of a robot by level as its checks take them, and how to ask them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import combinations
from typing import Any, NamedTuple

import numpy as np

from crosscheck.checks.answers import require_numbers
from crosscheck.checks.robots.sizes import RobotSizes
from crosscheck.checks.robots.states import RandomStates
from crosscheck.findings import ComparisonKey, Finding, Subject, make_check
from crosscheck.models.experiment.scenario import Scenario
from crosscheck.models.robot.interface import RobotModel
from crosscheck.models.robot.robot import Level, Robot
from crosscheck.planning.comparison import Comparison, ModelTask, make_comparison

FIRST_PRINCIPLES = "first principles"
# Central differences of order 8 over steps that turn a joint by so much [rad]: of second harmonics,
# the highest of M in a rotation, they leave 3e-12; M and energy are of a slide's square at most.
WEIGHTS = 4 / 5, -1 / 5, 4 / 105, -1 / 280
TURN_RAD, SLIDE_M = 0.04, 0.1
SLOPE_STATES = 4  # number of states at which slopes are taken, the first ones
LEAST_RUN_S = 1e-8  # shortest run [s]: in less, joints move by little more than rounding


@dataclass(frozen=True)
class RobotLevel:
    """A robot at a level, the states at which its models answer, and what these states are worth.

    drive (free, n): generalized forces of each motor's torque; runs take run_s [s], so short that
    few steps resolve the meshes; free motions of all levels take motion_s [s] in motion_steps.
    scenarios: beginnings of those that a user chose, in as few steps.
    """

    robot: Robot
    level: Level
    states: RandomStates
    sizes: RobotSizes
    drive: np.ndarray
    run_s: float
    motion_s: float
    motion_steps: int
    scenarios: tuple[Scenario, ...] = ()

    @property
    def name(self) -> str:
        """Robot and level, as ids have them."""
        return f"{self.robot.name}/{self.level}"

    @property
    def has_runs(self) -> bool:
        """Whether steps that resolve meshes and friction move the joints by more than rounding."""
        return self.run_s >= LEAST_RUN_S

    @property
    def free(self) -> int:
        """How many coordinates are joints'; meshes' come behind them."""
        return len(self.robot.coordinates)

    @property
    def first(self) -> RandomStates:
        """The states at which slopes are taken."""
        return self.states.first(SLOPE_STATES)

    @property
    def turns(self) -> np.ndarray:
        """By coordinate (n,) how far all joints that it moves turn, per rad or m."""
        turns = np.zeros(self.states.q.shape[1])
        for number, joint in enumerate(self.robot.joints):
            if joint.kind == "revolute":
                by = 1.0 if joint.mimic is None else abs(joint.mimic.multiplier)
                turns[self.leader(number)] += by
        return turns

    def leader(self, number: int) -> int:
        """Number of the coordinate that moves a joint: its own, or that of the joint it mimics."""
        mimic = self.robot.joints[number].mimic
        return self.robot.coordinates.index(number if mimic is None else mimic.joint)

    @property
    def steps(self) -> np.ndarray:
        """By which each coordinate changes for slopes (n,)."""
        return np.where(self.turns > 0, TURN_RAD / np.maximum(self.turns, 1e-300), SLIDE_M)


RobotQuestion = Callable[[RobotModel, RobotLevel], np.ndarray]


class SampledRobot(NamedTuple):
    """A model of a robot, ``engine:level``, and the task that each question to it is."""

    model: str
    case: RobotLevel
    ask: Callable[[RobotQuestion], ModelTask]

    def over(self, size: str) -> str:
        """The words of a metric: a size over the random states."""
        return f"{size} over {len(self.case.states.q)} random states"


def group_by_level(models: Sequence[SampledRobot]) -> dict[Level, list[SampledRobot]]:
    """The models of each level, in their order."""
    groups: dict[Level, list[SampledRobot]] = {}
    for sampled in models:
        groups.setdefault(sampled.case.level, []).append(sampled)
    return groups


def pair_models(models: Sequence[SampledRobot]) -> Iterator[tuple[SampledRobot, SampledRobot]]:
    """Every two models of a level."""
    for at_level in group_by_level(models).values():
        yield from combinations(at_level, 2)


def plan_law(
    sampled: SampledRobot,
    quantity: str,
    questions: Sequence[RobotQuestion],
    judge: Callable[..., Finding],
    against: str = FIRST_PRINCIPLES,
) -> Comparison:
    """The comparison of one model with a law; judge takes the subject, the answers and the case."""
    key = ComparisonKey("invariants", sampled.case.name, quantity, sampled.model)
    about = Subject(key, "1", sampled.over("largest residual, over its terms' size,"), against)
    tasks = [sampled.ask(question) for question in questions]
    return make_comparison(about, tasks, partial(judge, case=sampled.case))


def ask(model: RobotModel, method: str, shape: tuple[int, ...], *given: np.ndarray) -> np.ndarray:
    """Answer of a method, if it is an array of numbers of this shape. Raises BadAnswer."""
    return require_numbers(getattr(model, method)(*given), method, shape)


def share_of(difference: np.ndarray, size: np.ndarray) -> float:
    """The largest part of its size that a difference is, 1e300 at most.

    0 for none; no number where a value is none, or two runs diverged; that one did is huge.
    """
    difference = np.abs(difference)
    with np.errstate(invalid="ignore"):
        parts = np.where(difference == 0, 0.0, difference / np.maximum(size, 1e-300))
    return float(np.minimum(parts, 1e300).max(initial=0.0))


def check_share(about: Subject, measured: float, tolerance: float, basis: str) -> Finding:
    """The Finding of a difference that is a part of a size."""
    return make_check(about, measured=measured, tolerance=tolerance, basis=basis, relative=measured)


def compute_slopes(
    function: Callable[[np.ndarray], Any], q: np.ndarray, steps: np.ndarray
) -> np.ndarray:
    """Slopes (n, states, ...) along each coordinate of a function of many q (states, n)."""
    shifts = np.array([sign * far for far in range(1, 5) for sign in (1, -1)])
    moved = q + (shifts[:, None] * np.eye(len(steps))[:, None, :] * steps)[:, :, None, :]
    values = function(moved.reshape(-1, len(steps)))
    values = values.reshape(*moved.shape[:3], *values.shape[1:])
    slopes: np.ndarray = sum(
        weight * (values[:, 2 * far] - values[:, 2 * far + 1]) for far, weight in enumerate(WEIGHTS)
    )
    return slopes / steps.reshape(-1, *[1] * (slopes.ndim - 1))

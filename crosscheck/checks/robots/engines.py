"""Every quantity of every two engines, at each level."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from crosscheck.checks.robots.case import (
    RobotLevel,
    RobotQuestion,
    SampledRobot,
    ask,
    check_share,
    pair_models,
    share_of,
)
from crosscheck.checks.robots.sizes import SIZE_WORDS
from crosscheck.findings import ComparisonKey, Finding, Subject
from crosscheck.models.robot.integration import integrate
from crosscheck.models.robot.interface import RobotModel
from crosscheck.planning.comparison import Comparison, make_comparison

RUNS, STEPS = 3, 5  # number of runs, from the first states; steps of a run


def mass_matrix(model: RobotModel, case: RobotLevel) -> np.ndarray:
    """M (states, n, n)."""
    q = case.states.q
    return ask(model, "mass_matrix", (*q.shape, q.shape[1]), q)


def bias(model: RobotModel, case: RobotLevel) -> np.ndarray:
    """Coriolis and centrifugal torques (states, n)."""
    q, v, *_ = case.states
    return ask(model, "bias", q.shape, q, v)


def gravity(model: RobotModel, case: RobotLevel) -> np.ndarray:
    """Torques that hold the weights (states, n)."""
    q = case.states.q
    return ask(model, "gravity", q.shape, q)


def inverse_dynamics(model: RobotModel, case: RobotLevel) -> np.ndarray:
    """Generalized forces that the states' accelerations need (states, n)."""
    q, v, a, _ = case.states
    return ask(model, "inverse_dynamics", q.shape, q, v, a)


def forward_dynamics(model: RobotModel, case: RobotLevel) -> np.ndarray:
    """Accelerations under the states' torques (states, n)."""
    q, v, _, torques = case.states
    return ask(model, "forward_dynamics", q.shape, q, v, torques)


def energy(model: RobotModel, case: RobotLevel) -> np.ndarray:
    """Kinetic energy and that of the weights (states,)."""
    q, v, *_ = case.states
    return ask(model, "energy", (len(q),), q, v)


def momentum(model: RobotModel, case: RobotLevel) -> np.ndarray:
    """Linear and angular momentum (states, 6)."""
    q, v, *_ = case.states
    return ask(model, "momentum", (len(q), 6), q, v)


def tip(model: RobotModel, case: RobotLevel) -> np.ndarray:
    """Places of the tip (states, 3)."""
    q = case.states.q
    return ask(model, "tip", (len(q), 3), q)


def run(model: RobotModel, case: RobotLevel) -> np.ndarray:
    """Coordinates (runs, n) after a short free motion in equal steps."""
    q, v, _, torques = case.states.first(RUNS)
    ends, _ = integrate(model, q, v, lambda time: 0 * torques, case.run_s, STEPS)
    return ends


QUESTIONS: tuple[RobotQuestion, ...] = (
    *(mass_matrix, bias, gravity, inverse_dynamics, forward_dynamics),
    *(energy, momentum, tip, run),
)


def plan(models: Sequence[SampledRobot]) -> Iterator[Comparison]:
    """Comparisons of the two models' answers to each question."""
    for left, right in pair_models(models):
        for question in QUESTIONS if left.case.has_runs else QUESTIONS[:-1]:
            yield _plan_pair(left, right, question)


def _plan_pair(left: SampledRobot, right: SampledRobot, question: RobotQuestion) -> Comparison:
    quantity, case = question.__name__, left.case
    is_run = question is run
    family, metric = "states", left.over("largest difference, over its natural size,")
    if is_run:
        family, metric = "same-step", f"largest difference, over the motion, of {RUNS} short runs"
    key = ComparisonKey(family, case.name, quantity, left.model, right.model)

    def judge(about: Subject, left_values: np.ndarray, right_values: np.ndarray) -> Finding:
        size = getattr(case.sizes, quantity, None)
        if size is None:  # of runs: of the one that has not diverged
            ends = np.where(np.isfinite(left_values), left_values, right_values)
            size = motion_sizes(case, np.abs(ends - case.states.q[:RUNS]))
        size = size if left_values.ndim == size.ndim else size[:, None]
        measured = share_of(left_values - right_values, size)
        basis = f"{case.sizes.basis(quantity)}; size: {SIZE_WORDS[quantity]}"
        return check_share(about, measured, case.sizes.tolerance(quantity), basis)

    tasks = left.ask(question), right.ask(question)
    return make_comparison(Subject(key, "1", metric), tasks, judge)


def motion_sizes(case: RobotLevel, distances: np.ndarray) -> np.ndarray:
    """How far any joint, and any mesh, goes (runs, n), by the distance of each coordinate."""
    size = np.empty_like(distances)
    for part in (slice(case.free), slice(case.free, None)):
        size[:, part] = distances[:, part].max(axis=1, keepdims=True, initial=0.0)
    return size

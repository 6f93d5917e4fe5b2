"""Every quantity of every two engines, in each case of an arm and at each level of a robot."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from crosscheck.checks import states
from crosscheck.checks.answers import (
    EQUATIONS,
    acceleration,
    bias,
    energy,
    forward_dynamics,
    generalized_force,
    gravity,
    inverse_dynamics,
    mass_matrix,
    momentum,
    tip,
)
from crosscheck.checks.robot_states import SIZE_WORDS
from crosscheck.checks.sampled import (
    DIFFERENCE,
    ModelQuestion,
    RobotLevel,
    SampledArm,
    SampledRobot,
    Subjects,
    pair_models,
)
from crosscheck.checks.scales import check_share, share_of
from crosscheck.findings import ComparisonKey, Finding, Subject
from crosscheck.models.robot.integration import integrate
from crosscheck.models.robot.interface import RobotModel
from crosscheck.planning.comparison import Comparison, Results, make_comparison

RUNS, STEPS = 3, 5  # number of runs, from the first states; steps of a run
SWITCHED = generalized_force, acceleration  # what other switches change of an arm


def run(model: RobotModel, case: RobotLevel) -> np.ndarray:
    """Coordinates (runs, n) after a short free motion in equal steps."""
    q, v, _, torques = case.states.first(RUNS)
    ends, _ = integrate(model, q, v, lambda time: 0 * torques, case.run_s, STEPS)
    return ends


QUESTIONS: tuple[ModelQuestion, ...] = (
    *(mass_matrix, bias, gravity, inverse_dynamics, forward_dynamics),
    *(energy, momentum, tip, run),
)


def plan(subjects: Subjects) -> Iterator[Comparison]:
    """Compare the two models' answers to each question."""
    yield from plan_pairs([each for each in subjects.arms if each.group != "form"])
    for left, right in pair_models(subjects.robots):
        for question in QUESTIONS if left.setting.has_runs else QUESTIONS[:-1]:
            yield _plan_robot_pair(left, right, question)


def plan_pairs(
    models: Sequence[SampledArm], questions: Sequence[ModelQuestion] = EQUATIONS
) -> Iterator[Comparison]:
    """A comparison for each question and pair of an arm's models in a case.

    M and bias know no switch, so they are not compared under others again.
    """
    for left, right in pair_models(models):
        for question in questions:
            if question in SWITCHED or left.group not in ("switches", "conservative"):
                yield plan_arm_pair("states", question, left, right, states.compare_values)


def plan_arm_pair(
    family: str, question: ModelQuestion, left: SampledArm, right: SampledArm, judge: states.Judge
) -> Comparison:
    """Compare two models' answers to a question, relative to their size by either model's M."""
    key = ComparisonKey(family, left.where, question.__name__, left.model, right.model)
    pair = left, right

    def judge_results(about: Subject, results: Results) -> Finding:
        left_values, right_values = (results.need(each.ask(question)) for each in pair)
        masses = (results.get_if_finished(each.ask(mass_matrix)) for each in pair)
        sizes = (m for m in masses if m is not None and states.is_usable(m[0]))
        return judge(about, left_values, right_values, next(sizes, None), left.setting)

    needs = tuple(each.ask(asked) for asked in (mass_matrix, question) for each in pair)
    return Comparison(Subject(key, "1", left.over(DIFFERENCE)), needs, judge_results)


def _plan_robot_pair(
    left: SampledRobot, right: SampledRobot, question: ModelQuestion
) -> Comparison:
    quantity, case = question.__name__, left.setting
    is_run = question is run
    family, metric = "states", left.over("largest difference, over its natural size,")
    if is_run:
        family, metric = "same-step", f"largest difference, over the motion, of {RUNS} short runs"
    key = ComparisonKey(family, left.where, quantity, left.model, right.model)

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

"""Every quantity of every two engines, in each case of an arm and at each level of a robot."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial

import numpy as np

from crosscheck.checks.sampled import (
    DIFFERENCE,
    ModelQuestion,
    RobotLevel,
    SampledModel,
    Subjects,
    pair_models,
)
from crosscheck.checks.scales import check_share, share_of
from crosscheck.checks.states import compare_answers
from crosscheck.findings import ComparisonKey, Finding, Subject
from crosscheck.models.robot.integration import integrate
from crosscheck.models.robot.interface import RobotModel
from crosscheck.planning.comparison import Comparison, make_comparison

RUNS, STEPS = 3, 5  # number of runs, from the first states; steps of a run


def run(model: RobotModel, case: RobotLevel) -> np.ndarray:
    """Start and end (2, runs, n) of short free motions in equal steps."""
    q, v, _, torques = case.states.first(RUNS)
    ends, _ = integrate(model, q, v, lambda time: 0 * torques, case.run_s, STEPS)
    return np.array([q, ends])


def plan(subjects: Subjects) -> Iterator[Comparison]:
    """Compare the two models' answers to each question."""
    yield from plan_pairs([each for each in subjects.arms if each.group != "form"])
    metric = f"largest difference, over the motion, of {RUNS} short runs"
    for left, right in pair_models(subjects.robots):
        yield from plan_pairs([left, right])
        if left.setting.has_runs:
            yield plan_pair("same-step", run, left, right, compare_motions, metric)


def plan_pairs(
    models: Sequence[SampledModel], questions: Sequence[ModelQuestion] = ()
) -> Iterator[Comparison]:
    """A comparison for each question, theirs unless given, and pair of models of a case."""
    for left, right in pair_models(models):
        for question in questions or left.questions:
            yield plan_pair("states", question, left, right)


def plan_pair(
    family: str,
    question: ModelQuestion,
    left: SampledModel,
    right: SampledModel,
    judge: Callable[..., Finding] = compare_answers,
    metric: str = "",
) -> Comparison:
    """Compare two models' answers to a question; judge also takes the setting."""
    key = ComparisonKey(family, left.where, question.__name__, left.model, right.model)
    about = Subject(key, "1", metric or left.over(DIFFERENCE))
    tasks = left.ask(question), right.ask(question)
    return make_comparison(about, tasks, partial(judge, setting=left.setting))


def compare_motions(
    about: Subject, left: np.ndarray, right: np.ndarray, setting: RobotLevel
) -> Finding:
    """Check two models' runs (times, runs, n) over the longest way of any joint, or any mesh.

    Of a run that has diverged the other one gives the size.
    """
    ends = np.where(np.isfinite(left), left, right)
    moved = np.abs(ends - ends[0]).max(axis=0)
    size = np.empty_like(moved)
    for part in (slice(setting.free), slice(setting.free, None)):
        size[:, part] = moved[:, part].max(axis=1, keepdims=True, initial=0.0)
    return check_share(about, share_of(left - right, size), *setting.sizes.limit("run"))

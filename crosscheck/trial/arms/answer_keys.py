"""Right answers of an arm's equations at a few states, on it and on an arm of its structure."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from crosscheck.trial.arms.questions import QUESTIONS, VerificationProblem, transform_model
from crosscheck.trial.changes.arms.diagnosis import build_probe_problems
from crosscheck.trial.input.equations import Equations
from crosscheck.trial.input.loading import build_equations
from crosscheck.trial.input.supplied import bind_equations
from crosscheck.trial.judge.checks import COMPARED
from crosscheck.trial.judge.entries import compute_sizes
from crosscheck.trial.result import Trial
from crosscheck.trial.source.answer_key import Answer, AnswerKey, LevelAnswers

FEW_STATES = 3


def make_arm_answer_keys(trial: Trial) -> Iterator[AnswerKey]:
    """The answer keys of a trial's arm, and of one other that keeps the ignored numbers."""
    diagnosis = trial.diagnosis
    probes = build_probe_problems(trial.problem, diagnosis.ignored_numbers)
    for each in (trial.problem, *probes[:1]):
        yield _make_answer_key(replace(each, count=FEW_STATES), diagnosis.level)


def _make_answer_key(problem: VerificationProblem, level: str) -> AnswerKey:
    """The answers of the nearest level, and of others of which wrong equations may be."""
    arm, scenario, frame, states = *problem.case[:2], problem.frame, problem.states

    def build(source: Any) -> Equations:
        return build_equations(source, arm, scenario, problem.name)

    def bind(source: Any) -> Answer:
        bound = bind_equations(build(source), arm, frame)
        return lambda part, state: QUESTIONS[part](bound, states[state], states[state].u)

    levels = dict.fromkeys((level, *problem.levels))
    right = {each: _ask_reference(problem, each) for each in levels}
    return AnswerKey(bind, right, frame.names, build)


def _ask_reference(problem: VerificationProblem, level: str) -> LevelAnswers:
    """Answers of the reference of a level for the parts that the user supplies."""
    states, frame = problem.states, problem.frame
    name = problem.reference(level)
    model = transform_model(name, problem.case, frame, problem.has_gravity)
    asked = [part for part in COMPARED if part != "gravity" or problem.has_gravity]
    right = {
        part: np.array([QUESTIONS[part](model, state, state.u) for state in states])
        for part in asked
    }
    mass, force, acceleration = (right[part] for part in ("mass_matrix", "force", "acceleration"))
    sizes = compute_sizes(frame, states, mass, force, acceleration, right.get("gravity"))
    has = problem.has if problem.equations.acceleration else problem.has - {"acceleration"}
    parts = [part for part in asked if part in has]
    allowed = {part: sizes.tolerance(part) * sizes.entry_sizes(part) for part in parts}
    return LevelAnswers({part: right[part] for part in parts}, allowed)

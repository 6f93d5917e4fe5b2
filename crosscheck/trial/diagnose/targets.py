"""What an arm's equations must answer at a few states, on their arm and on one of its structure."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from crosscheck.runner.tasks import build_model
from crosscheck.trial.diagnose.dependence import IgnoredNumber
from crosscheck.trial.diagnose.diagnosis import build_probe_problems
from crosscheck.trial.input.loading import build_equations
from crosscheck.trial.input.supplied import bind_equations
from crosscheck.trial.judge.entries import compute_sizes
from crosscheck.trial.judge.questions import QUESTIONS, TransformedModel, VerificationProblem
from crosscheck.trial.judge.suite import COMPARED
from crosscheck.trial.source.target import Answer, Target

FEW_STATES = 3


def make_arm_targets(
    problem: VerificationProblem, level: str, ignored_numbers: tuple[IgnoredNumber, ...]
) -> Iterator[Target]:
    """The targets at a level: of the arm, and of one other that keeps numbers of the user's own."""
    for each in (problem, *build_probe_problems(problem, ignored_numbers)[:1]):
        yield _make_target(replace(each, count=FEW_STATES), level)


def _make_target(problem: VerificationProblem, level: str) -> Target:
    arm, scenario, frame, states = *problem.case[:2], problem.frame, problem.states
    model = TransformedModel(build_model(problem.reference(level), problem.case), frame)
    right = {
        part: np.array([QUESTIONS[part](model, state, state.u) for state in states])
        for part in COMPARED
    }
    sizes = compute_sizes(
        frame, states, right["mass_matrix"], right["force"], right["acceleration"]
    )
    is_given = {**dict.fromkeys(problem.has, True), "acceleration": problem.equations.acceleration}

    def bind(source: Any) -> Answer:
        equations = build_equations(source, arm, scenario, problem.name)
        bound = bind_equations(equations, arm, frame)
        return lambda part, state: QUESTIONS[part](bound, states[state], states[state].u)

    parts = [part for part in COMPARED if is_given.get(part)]
    allowed = {part: sizes.tolerance(part) * sizes.entry_sizes(part) for part in parts}
    return Target(bind, {part: right[part] for part in parts}, allowed, frame.names)

"""Right answers of an arm's equations at a few states, on it and on an arm of its structure."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from typing import Any

import numpy as np
from pydantic import ValidationError

from crosscheck.analytic.robot.model import multiply
from crosscheck.checks.answers import BadAnswer
from crosscheck.models.errors import InputError
from crosscheck.models.files import list_leaf_values
from crosscheck.trial.arms.questions import QUESTIONS, VerificationProblem
from crosscheck.trial.changes.arms.arm_numbers import (
    get_number,
    list_number_names,
    replace_numbers,
)
from crosscheck.trial.changes.arms.causes import build_probe_problems
from crosscheck.trial.input.loading import build_equations
from crosscheck.trial.input.supplied import bind_equations
from crosscheck.trial.judge.checks import COMPARED
from crosscheck.trial.result import Trial
from crosscheck.trial.source.answer_key import (
    Answer,
    AnswerKey,
    LevelAnswers,
    NumberExchange,
)

FEW_STATES = 3
INVERSE = "inverse_dynamics"  # asked with the rates as accelerations


def make_arm_answer_keys(trial: Trial) -> Iterator[AnswerKey]:
    """The answer keys of a trial's arm, and of one other that keeps the ignored numbers."""
    diagnosis = trial.diagnosis
    probes = build_probe_problems(trial.problem, diagnosis.ignored_numbers)
    levels = [*dict.fromkeys((diagnosis.level, *(at.level for at in trial.distances)))]
    for each in (trial.problem, *probes[:1]):
        yield _make_answer_key(replace(each, count=FEW_STATES), levels)
    if not trial.problem.equations.any_arm:
        arm = trial.problem.case.arm
        numbers = {name: get_number(arm, name) for name in list_number_names(arm)}
        with suppress(ValidationError, InputError):  # of numbers that are no arm's
            exchange = NumberExchange()
            exchanged = {name: exchange(number) for name, number in numbers.items()}
            other = trial.problem.adapt_to_arm(replace_numbers(arm, exchanged))
            key = _make_answer_key(replace(other, count=FEW_STATES), levels)
            yield exchange.exchange_code(key, numbers.values())


def _make_answer_key(problem: VerificationProblem, levels: Sequence[str]) -> AnswerKey:
    """The answers of the nearest level, the first, and of others of which the equations may be."""
    arm, scenario, frame, states = *problem.case[:2], problem.frame, problem.states

    def bind(source: Any) -> Answer:
        bound = bind_equations(build_equations(source, arm, scenario, problem.name), arm, frame)
        if not bound.has <= problem.has:
            raise BadAnswer("an error has become a part that is not judged")

        def answer(part: str, state: int) -> np.ndarray:
            answers = QUESTIONS[part](bound, states[state], states[state].u)
            return answers[0] if part == INVERSE else answers

        return answer

    right = {each: _ask_reference(problem, each) for each in levels}
    values = list_leaf_values(arm.model_dump(mode="json"))
    numbers = frozenset(each for each in values if isinstance(each, float))
    return AnswerKey(bind, right, frame.names, numbers)


def _ask_reference(problem: VerificationProblem, level: str) -> LevelAnswers:
    """Answers of the reference of a level for the parts that the user supplies."""
    has = problem.has if problem.equations.acceleration else problem.has - {"acceleration"}
    sizes, right = problem.compute_sizes(level), dict[str, np.ndarray]()
    for part in (each for each in COMPARED if each in has):
        if (values := problem.find_right(level, part)) is not None:
            right[part] = values
    allowed = {part: sizes.tolerance(part) * sizes.entry_sizes(part) for part in right}
    motion = {"mass_matrix", "bias"}
    is_asked = problem.equations.inverse_dynamics is not None and motion <= {*right}
    if is_asked and problem.bound.given & motion:
        rates = np.array([state.u for state in problem.states])
        right[INVERSE] = multiply(right["mass_matrix"], rates) + right["bias"]
        largest = sizes.bias + sizes.mass @ np.abs(rates).max(axis=0)
        allowed[INVERSE] = sizes.tolerance("bias") * largest
    return LevelAnswers(right, allowed)

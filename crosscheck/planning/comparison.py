"""Comparisons planned before anything runs: each becomes exactly one Finding, whatever happens."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

import numpy as np

from crosscheck.findings import (
    EntryDifferences,
    Finding,
    Subject,
    make_failed_check,
    make_unfinished_check,
)
from crosscheck.runner.outcomes import Failure, Outcome, Task, failure_from_error


class ModelTask(Task, Protocol):
    """Work on one model: a run, an evaluation, a question of a trial."""

    @property
    def model(self) -> str: ...


class MissingResult(Exception):
    """A result that a comparison needs does not exist; the text says which model failed, and why.

    unfinished: whether the model was stopped before it answered.
    """

    def __init__(self, why: str, unfinished: bool = False) -> None:
        super().__init__(why)
        self.unfinished = unfinished


class Results:
    """The outcomes of all tasks, by their keys."""

    def __init__(self, outcomes: Mapping[Any, Outcome]) -> None:
        self.outcomes = outcomes

    def need(self, task: ModelTask) -> Any:
        """A task's array or trajectory. Raises MissingResult."""
        outcome = self.outcomes.get(task.key, Failure("Lost", "no result came back"))
        if isinstance(outcome, Failure):
            raise MissingResult(f"{task.model}: {outcome}", outcome.unfinished)
        return outcome

    def get(self, task: ModelTask) -> Any | None:
        """A task's array or trajectory, or None for whatever reason there is none."""
        try:
            return self.need(task)
        except MissingResult:
            return None


@dataclass(frozen=True)
class Comparison:
    """A planned comparison: what it is about, the tasks it needs, how to judge their results."""

    about: Subject
    needs: tuple[ModelTask, ...]
    judge: Callable[[Subject, Results], Finding]

    def finding(self, results: Results) -> Finding:
        """The Finding; a failed check where a result is missing or cannot be compared.

        It is an unfinished check where a model was stopped before it answered.
        """
        try:
            return self.judge(self.about, results)
        except MissingResult as error:
            missing = make_unfinished_check if error.unfinished else make_failed_check
            return missing(self.about, str(error))
        except Exception as error:  # a result that no comparison foresaw stays this check's affair
            return make_failed_check(self.about, str(failure_from_error(error)))


class Plan(NamedTuple):
    """A whole cross-check before it runs.

    remarks: what a user should know beforehand; compute_entries: models beside the engines, entry
    by entry, from what was answered.
    """

    comparisons: list[Comparison]
    remarks: tuple[str, ...]
    compute_entries: Callable[[Results], Iterator[EntryDifferences]]


def make_comparison(
    about: Subject, tasks: Sequence[ModelTask], judge: Callable[..., Finding]
) -> Comparison:
    """A comparison whose judge takes ``about`` and the tasks' results, in their order."""

    def judge_results(about: Subject, results: Results) -> Finding:
        return judge(about, *map(results.need, tasks))

    return Comparison(about, tuple(tasks), judge_results)


def compare_entries(
    question: Any, model: Any, engines: Sequence[Any], results: Results
) -> Iterator[EntryDifferences]:
    """How far a sampled model's answer is from that of others at the same states.

    Nothing if the model or all others have failed: their own comparisons fail.
    """
    values = results.get(model.ask(question))
    answered = {each.model: results.get(each.ask(question)) for each in engines}
    answers = {name: answer for name, answer in answered.items() if answer is not None}
    if values is None or not answers:
        return
    setting, quantity = model.setting, question.__name__
    size = setting.sizes.natural_size(quantity, values)
    differences = {name: np.abs(values - answer) / size for name, answer in answers.items()}
    tolerance = setting.sizes.limit(quantity).value
    yield summarise_entries(quantity, model.model, setting.names, differences, tolerance)


def summarise_entries(
    quantity: str,
    model: str,
    names: Sequence[str],
    differences: Mapping[str, np.ndarray],
    tolerance: float,
) -> EntryDifferences:
    """The largest difference of each entry from any engine.

    names: of the coordinates; differences: by engine (states, n) or (states, n, n), over the
    entries' sizes; what is no number counts as infinite.
    """
    largest = np.max([each.max(axis=0) for each in differences.values()], axis=0)
    rows = np.where(np.isnan(largest), np.inf, largest).reshape(len(names), -1).tolist()
    entries = tuple(map(tuple, rows))
    return EntryDifferences(quantity, model, tuple(differences), tuple(names), entries, tolerance)


def collect_tasks(comparisons: Sequence[Comparison]) -> list[ModelTask]:
    """Every task that any of the comparisons needs, once."""
    return list({task.key: task for each in comparisons for task in each.needs}.values())


def judge_comparisons(comparisons: Sequence[Comparison], results: Results) -> Iterator[Finding]:
    """Each comparison's Finding, in their order. Raises ValueError if two would have one id."""
    ids = [comparison.about.key.id for comparison in comparisons]
    twice = {id for id in ids if ids.count(id) > 1} if len(set(ids)) < len(ids) else set()
    if twice:
        raise ValueError(f"planned twice: {', '.join(sorted(twice))}")
    for comparison in comparisons:
        yield comparison.finding(results)

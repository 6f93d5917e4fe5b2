"""The cross-check from end to end: plan, perform, compare."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import xarray as xr

from crosscheck.findings import Agreement
from crosscheck.models.arm.arm import Arm
from crosscheck.models.loading import Case
from crosscheck.planning import energy_suite, run_suite, state_suite
from crosscheck.planning.comparison import Comparison, ModelTask, Results, findings_of, tasks_of
from crosscheck.planning.plan import Wanted, order_cases, readings, short_experiments
from crosscheck.planning.preparation import Prepared, prepared
from crosscheck.provenance import provenance
from crosscheck.registry import packages
from crosscheck.runner.outcomes import Failure
from crosscheck.runner.tasks import RunKey, Simulation
from crosscheck.runner.underway import Expectation, Told, Underway, unsaid
from crosscheck.runner.workers import Workers

Shown = Callable[[Any, Any], None]  # (a task's key, its outcome)


@dataclass(frozen=True)
class CrossCheck:
    """A cross-check: its Agreement, and its cases and runs (or why there is none) by key."""

    wanted: Wanted
    agreement: Agreement
    cases: dict[RunKey, Case]
    runs: dict[RunKey, xr.Dataset | Failure]

    @property
    def arm(self) -> Arm:
        """The arm that was cross-checked."""
        return self.wanted.arm


def cross_check(
    wanted: Wanted,
    *,
    jobs: int,
    told: Told = unsaid,
    warned: Callable[[str], None] = lambda line: None,
    shown: Shown = lambda key, outcome: None,
) -> CrossCheck:
    """Run every check on an arm; ``warned`` is told of unstable loops before they run.

    shown: is handed each task's outcome while others still run. Raises InputError for an arm or
    scenarios that cannot be run, and Unfinished where they could not be prepared.
    """
    with Workers(jobs) as workers:
        told(Underway("preparing the experiments"))
        chosen = prepared(wanted, workers)
        for line in chosen.remarks:
            warned(line)
        comparisons = planned(wanted, chosen)
        results = performed(workers, tasks_of(comparisons), told, shown)
    told(Underway("comparing"))
    findings = list(findings_of(comparisons, results))
    own = wanted.scenarios, wanted.chosen, chosen.remarks
    record = provenance(wanted.arm, wanted.seed, wanted.quick, *own, packages())
    entries = state_suite.entry_differences(wanted.arm, wanted.quick, wanted.seed, results)
    agreement = Agreement(findings, record, entries=tuple(entries))
    return CrossCheck(wanted, agreement, cases_of(comparisons), runs_of(results))


def planned(wanted: Wanted, chosen: Prepared) -> list[Comparison]:
    """All comparisons of a cross-check of the arm, before any task of theirs has run.

    Raises InputError.
    """
    arm, quick, seed = wanted.arm, wanted.quick, wanted.seed
    found: list[Comparison] = []
    for reading, told in readings(wanted):
        found += state_suite.state_comparisons(reading, quick, seed, told)
    found += state_suite.probe_comparisons(arm, quick, seed)
    for experiment in chosen.experiments:
        found += run_suite.experiment_comparisons(experiment)
    first = chosen.experiments[0]
    for experiment in short_experiments(arm, first, chosen.limit_s):
        found += run_suite.short_comparisons(experiment)
    found += energy_suite.energy_comparisons(arm, first, chosen.limit_s)
    for case in order_cases(arm, first, chosen.limit_s):
        found += run_suite.order_comparisons(case)
    return [*found, *(each.comparison for each in chosen.lost)]


def performed(
    workers: Workers,
    tasks: Sequence[ModelTask],
    told: Told,
    shown: Shown = lambda key, outcome: None,
) -> Results:
    """The Results of all tasks; told: of the progress; shown: each task's key and outcome."""
    expected, outcomes = Expectation(tasks, workers.jobs), dict[Any, Any]()

    def begun(key: Any) -> None:
        told(Underway(in_words(key), len(outcomes), len(tasks), expected.left_s))

    for key, outcome in workers.each(tasks, begun):
        outcomes[key] = outcome
        expected.finish(key)
        shown(key, outcome)
    return Results(outcomes)


def in_words(key: Any) -> str:
    """What the task of a key does, in words."""
    if isinstance(key, RunKey):
        return f"simulating {key.experiment}, {key.model}"
    return f"evaluating {key.quantity}, {key.model}"


def cases_of(comparisons: Sequence[Comparison]) -> dict[RunKey, Case]:
    """The case of each run that the comparisons need, by the run's key."""
    tasks = (task for task in tasks_of(comparisons) if isinstance(task, Simulation))
    return {task.key: task.case for task in tasks}


def runs_of(results: Results) -> dict[RunKey, xr.Dataset | Failure]:
    """The runs among all outcomes, by key: a trajectory, or why there is none."""
    return {
        key: outcome
        for key, outcome in results.outcomes.items()
        if isinstance(key, RunKey) and isinstance(outcome, xr.Dataset | Failure)
    }

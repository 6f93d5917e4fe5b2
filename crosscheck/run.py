"""The cross-check from end to end: plan, perform, compare."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from crosscheck.findings import Agreement
from crosscheck.mechanisms import supply
from crosscheck.models.loading import Case
from crosscheck.models.mechanism import Mechanism
from crosscheck.planning.comparison import (
    Comparison,
    ModelTask,
    Plan,
    Results,
    collect_tasks,
    judge_comparisons,
)
from crosscheck.planning.plan import CrossCheckRequest
from crosscheck.provenance import record_provenance
from crosscheck.registry import packages
from crosscheck.runner.outcomes import Failure
from crosscheck.runner.progress_update import ProgressCallback, TimeEstimate, ignore_progress
from crosscheck.runner.tasks import RunKey, Simulation
from crosscheck.runner.workers import Workers

if TYPE_CHECKING:
    import xarray as xr


@dataclass(frozen=True)
class CrossCheck:
    """A cross-check: its Agreement, and its cases and runs (or why there is none) by key."""

    request: CrossCheckRequest
    agreement: Agreement
    cases: dict[RunKey, Case]
    runs: dict[RunKey, xr.Dataset | Failure]

    @property
    def mechanism(self) -> Mechanism:
        """The arm or robot that was cross-checked."""
        return self.request.mechanism


def run_cross_check(
    request: CrossCheckRequest,
    *,
    jobs: int,
    progress: ProgressCallback = ignore_progress,
    on_warning: Callable[[str], None] = lambda line: None,
) -> CrossCheck:
    """Run every check on an arm or robot; ``on_warning`` receives warnings before they run.

    Raises InputError for an arm, robot or scenarios that cannot be run, and Unfinished where they
    could not be prepared.
    """
    with Workers(jobs) as workers:
        progress("preparing the experiments")
        plan: Plan = supply("plan", request.mechanism.section)(request, workers)
        for line in plan.remarks:
            on_warning(line)
        results = run_tasks(workers, collect_tasks(plan.comparisons), progress)
    progress("comparing")
    findings = list(judge_comparisons(plan.comparisons, results))
    settings = request.scenarios, request.chosen, plan.remarks
    made_of = request.mechanism, request.seed, request.quick
    record = record_provenance(*made_of, *settings, packages())
    agreement = Agreement(findings, record, entries=tuple(plan.compute_entries(results)))
    return CrossCheck(request, agreement, cases_by_run(plan.comparisons), runs_by_key(results))


def run_tasks(workers: Workers, tasks: Sequence[ModelTask], progress: ProgressCallback) -> Results:
    """The Results of all tasks."""
    estimate, outcomes = TimeEstimate(tasks), dict[Any, Any]()

    def report_begin(key: Any) -> None:
        progress(describe_task(key), len(outcomes), len(tasks), estimate.left_s)

    for key, outcome in workers.stream_longest_first(tasks, report_begin):
        outcomes[key] = outcome
        estimate.finish(key)
    return Results(outcomes)


def describe_task(key: Any) -> str:
    """Description of the task of a key."""
    if isinstance(key, RunKey):
        return f"simulating {key.experiment}, {key.model}"
    return f"evaluating {key.quantity}, {key.model}"


def cases_by_run(comparisons: Sequence[Comparison]) -> dict[RunKey, Case]:
    """The case of each run that the comparisons need, by the run's key."""
    tasks = (task for task in collect_tasks(comparisons) if isinstance(task, Simulation))
    return {task.key: task.case for task in tasks}


def runs_by_key(results: Results) -> dict[RunKey, xr.Dataset | Failure]:
    """The runs among all outcomes, by key: a trajectory, or why there is none."""
    runs = ((key, run) for key, run in results.outcomes.items() if isinstance(key, RunKey))
    return {key: run for key, run in runs if not isinstance(run, np.ndarray)}

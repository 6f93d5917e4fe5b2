"""The cross-check from end to end: plan, perform, compare."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import xarray as xr

from crosscheck.comparison import Comparison, ModelTask, Results, findings_of, tasks_of
from crosscheck.findings import Agreement
from crosscheck.plan import (
    FULL_S,
    MECHANISM,
    experiments,
    order_cases,
    readings,
    short_experiments,
)
from crosscheck.provenance import provenance
from crosscheck.run_suite import (
    FIXED_STEP,
    experiment_comparisons,
    order_comparisons,
    short_comparisons,
)
from crosscheck.state_suite import probe_comparisons, state_comparisons
from crosscheck.tasks import Evaluation, Failure, RunKey
from crosscheck.workers import Workers
from models.arm import Arm
from models.loading import Case, load_arm, load_scenario

Told = Callable[[str, int], None]  # (what is being done, steps still to come)


@dataclass(frozen=True)
class CrossCheck:
    """An Agreement and the runs that it was drawn from: a trajectory, or why there is none."""

    arm: Arm
    agreement: Agreement
    runs: dict[RunKey, xr.Dataset | Failure]


def cross_check(
    arm: Arm | str, *, quick: bool, jobs: int, seed: int, told: Told = lambda what, left: None
) -> CrossCheck:
    """Run every check on an arm. Raises InputError for an arm that cannot be loaded or run."""
    arm = load_arm(arm) if isinstance(arm, str) else arm
    with Workers(jobs) as workers:
        told("starting", 0)
        limits = workers.perform(stable_steps(arm), lambda key: None)
        comparisons = planned(arm, quick, seed, smallest(limits))
        results = performed(workers, tasks_of(comparisons), told)
    findings = list(findings_of(comparisons, results))
    return CrossCheck(arm, Agreement(findings, provenance(arm, seed, quick)), runs_of(results))


def planned(arm: Arm, quick: bool, seed: int, limit_s: float) -> list[Comparison]:
    """All that a cross-check of the arm compares, before anything has run.

    limit_s: largest stable step [s] of the arm's fixed-step models. Raises InputError.
    """
    found = [c for reading in readings(arm) for c in state_comparisons(reading, quick, seed)]
    found += probe_comparisons(arm, quick, seed)
    for experiment in experiments(arm, quick, limit_s):
        found += experiment_comparisons(experiment)
    for experiment in short_experiments(arm, limit_s):
        found += short_comparisons(experiment)
    for case in order_cases(arm, limit_s):
        found += order_comparisons(case)
    return found


def performed(workers: Workers, tasks: Sequence[ModelTask], told: Told) -> Results:
    """Every task's outcome."""
    left = len(tasks)

    def done(key: Any) -> None:
        nonlocal left
        left -= 1
        told(str(key) if isinstance(key, RunKey) else f"{key.model} {key.quantity}", left)

    told("starting", left)
    return Results(workers.perform(tasks, done))


def stable_steps(arm: Arm) -> list[Evaluation]:
    """What must be known of the arm before its runs can be planned."""
    cases = [Case(arm, load_scenario(name), MECHANISM) for name in FULL_S]
    return [
        Evaluation(model, case, "largest_stable_step") for model in FIXED_STEP for case in cases
    ]


def smallest(limits: dict[Any, Any]) -> float:
    """Of the steps [s] that are known; where none is, its checks will say so."""
    known = [float(limit) for limit in limits.values() if not isinstance(limit, Failure)]
    return min(known, default=float("inf"))


def runs_of(results: Results) -> dict[RunKey, xr.Dataset | Failure]:
    """The outcomes that are runs."""
    return {
        key: outcome
        for key, outcome in results.outcomes.items()
        if isinstance(key, RunKey) and isinstance(outcome, xr.Dataset | Failure)
    }

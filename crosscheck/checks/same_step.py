"""Runs of two models through the same integrator and step, and what a rounding makes of a run.

RK4 commutes with a linear change of coordinates: two models with the same equations, step and start
differ by rounding alone, whatever coordinates they use inside.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import partial
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from crosscheck.checks.levels import measure_deviation
from crosscheck.checks.sampled import ExperimentPlan, Subjects, find_experiments, find_usual
from crosscheck.checks.scales import EPS, ReasonedLimit
from crosscheck.checks.trajectories import (
    MESH,
    describe_acceptance,
    find_acceptance_limit,
    has_meshes,
    largest_difference,
    make_subject,
    recorded_quantities,
    relative_value,
    size,
    step_count,
)
from crosscheck.findings import Finding, Subject, make_check
from crosscheck.planning.comparison import Comparison, ModelTask, make_comparison

if TYPE_CHECKING:
    import xarray as xr

SAME_STEP = (
    *("theta", "x_sp", "x_pr", "F_sp", "F_pr"),
    *("theta_dot", "theta_ddot", "torque", "kinetic_energy"),
)
# Every step rounds, and so many roundings add up at random; the factor is for roundings that do
# more than one in the start.
ROUNDINGS_AT_ONCE = 10
SENSITIVE = ("theta", "x_sp")
ONE_ROUNDING = "one-rounding"  # the family of comparisons that measure sensitivity
MIDWAY_S = 2.0  # instant of longer experiments [s] that the page shows by itself


def plan(subjects: Subjects) -> Iterator[Comparison]:
    """Comparisons of the reference model with each of its integrator, and with itself nudged."""
    for experiment in find_experiments(subjects, "motion"):
        yield from plan_fixed_steps(experiment)
    for experiment in (*find_usual(subjects), *find_experiments(subjects, "short")):
        first = experiment.models.same[0]
        pair = experiment.run(first), experiment.run(first, "nudged")
        for quantity in recorded_quantities(experiment, SENSITIVE):
            about = make_subject(ONE_ROUNDING, experiment, quantity, first, first)
            yield make_comparison(about, pair, measure_sensitivity)
    for experiment in find_usual(subjects):
        if experiment.case.switches.planets == "lumped" and has_meshes(experiment):
            yield from _plan_planets(experiment)


def plan_fixed_steps(experiment: ExperimentPlan) -> Iterator[Comparison]:
    """Comparisons of the reference model with each model of its integrator, step by step."""
    first, *others = experiment.models.same
    families: dict[str, float | None] = {"same-step": None}
    if experiment.case.scenario.duration_s > MIDWAY_S:
        families[f"at-{MIDWAY_S:g}-s"] = MIDWAY_S
    for other in others:
        runs = [experiment.run(first), experiment.run(other), *_repetition_runs(experiment, other)]
        for family, time_s in families.items():
            judge = partial(_check_same_step, experiment, time_s=time_s)
            for quantity in recorded_quantities(experiment, SAME_STEP):
                about = make_subject(family, experiment, quantity, first, other)
                yield make_comparison(about, runs, judge)


def _repetition_runs(experiment: ExperimentPlan, model: str) -> tuple[ModelTask, ModelTask]:
    """The reference model's run and one nudged by a rounding, planets as free as the model's."""
    models, lumped = experiment.models, experiment.case.switches.planets == "lumped"
    is_freed = lumped and model in models.free_planets and has_meshes(experiment)
    variants = ("free", "free-nudged") if is_freed else ("", "nudged")
    run, nudged = (experiment.run(models.same[0], variant) for variant in variants)
    return run, nudged


def _plan_planets(experiment: ExperimentPlan) -> Iterator[Comparison]:
    """Comparisons of alike planets, counted as one or each for itself: the same until they part."""
    first, second, *_ = experiment.models.same
    lumped, pair = experiment.run(first), _repetition_runs(experiment, second)
    for quantity in MESH:
        about = make_subject("lumped-free", experiment, quantity, first, first)
        runs = (lumped, pair[0], *pair)
        yield make_comparison(about, runs, partial(_check_same_step, experiment))
    about = make_subject(f"{ONE_ROUNDING}-per-planet", experiment, "x_pr", first, first)
    yield make_comparison(about, pair, measure_sensitivity)


def _check_same_step(
    experiment: ExperimentPlan,
    about: Subject,
    left: xr.Dataset,
    right: xr.Dataset,
    run: xr.Dataset,
    nudged: xr.Dataset,
    time_s: float | None = None,
) -> Finding:
    """The check of two runs at the same step, over the whole run or at one instant."""
    pair, widest = Pair(run, nudged), find_acceptance_limit(experiment, about, run)
    if time_s is None:
        return check_same_step(about, left, right, pair, widest)
    return check_at_time(about, left, right, pair, widest, time_s)


class Pair(NamedTuple):
    """A run, and one from a start that is one rounding away."""

    run: xr.Dataset
    nudged: xr.Dataset


def check_same_step(
    about: Subject, left: xr.Dataset, right: xr.Dataset, pair: Pair, widest: ReasonedLimit
) -> Finding:
    """Check runs of two models through the same integrator and step, over the whole run."""
    quantity = about.key.quantity
    limit = repetition_limit(pair, quantity)
    measured = largest_difference(left, right, quantity)
    return make_check(
        about,
        measured=measured,
        tolerance=limit.value,
        resolved=limit.value <= widest.value,
        basis=f"{limit.basis}; {describe_acceptance(widest)}",
        relative=relative_value(measured, left, quantity),
    )


def repetition_limit(pair: Pair, quantity: str) -> ReasonedLimit:
    """The limit of how far the same steps may lead apart by rounding alone."""
    grown, rounding = largest_difference(*pair, quantity), EPS * size(pair.run, quantity)
    steps = step_count(pair.run)
    basis = (
        f"{ROUNDINGS_AT_ONCE} sqrt(N) (g + eps s), N = {steps:.0f} steps, g = {grown:.1e} (what one"
        f" rounding in the start grows to), eps s = {rounding:.1e} (rounding of the quantity)"
    )
    return ReasonedLimit(ROUNDINGS_AT_ONCE * math.sqrt(steps) * (grown + rounding), basis)


def check_at_time(
    about: Subject,
    left: xr.Dataset,
    right: xr.Dataset,
    pair: Pair,
    widest: ReasonedLimit,
    time_s: float,
) -> Finding:
    """Check like ``check_same_step``, at one instant: the record there and the one before."""

    def select_records(run: xr.Dataset) -> xr.Dataset:
        index = int(np.argmin(np.abs(run["time"].values - time_s)))
        return run.isel(time=slice(max(index - 1, 0), index + 1))

    return check_same_step(about, select_records(left), select_records(right), pair, widest)


def measure_sensitivity(about: Subject, run: xr.Dataset, nudged: xr.Dataset) -> Finding:
    """Measure how far a run moves when its start is changed by a rounding."""
    return measure_deviation(
        about, nudged, run, "every angle and displacement started a rounding away"
    )

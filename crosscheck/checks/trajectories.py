"""Whole runs: is the difference of two trajectories inside what their integrators can explain?"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from crosscheck.checks.records import BY_PLANET
from crosscheck.checks.sampled import ExperimentPlan, Subjects, find_experiments, find_usual
from crosscheck.checks.scales import EPS, ReasonedLimit, acceptance_limit, geared_joints
from crosscheck.findings import ComparisonKey, Finding, Subject, make_check, make_measurement
from crosscheck.models.trajectory import VARIABLES, unit_of
from crosscheck.planning.comparison import Comparison, ModelTask, make_comparison

if TYPE_CHECKING:
    import xarray as xr

UNITS = {**{name: unit_of(name) for name in VARIABLES}, "tip": "m"}
MESH = ("theta", "x_sp", "x_pr")
LARGEST, APART = "largest absolute difference", "largest distance"
# RK4 commutes with a linear change of coordinates: two models with the same equations, step and
# start differ by rounding alone, whatever coordinates they use inside. Every step rounds, and so
# many roundings add up at random; the factor is for roundings that do more than one in the start.
SAME_STEP = (
    *("theta", "x_sp", "x_pr", "F_sp", "F_pr"),
    *("theta_dot", "theta_ddot", "torque", "kinetic_energy"),
)
ROUNDINGS_AT_ONCE = 10
SENSITIVE = ("theta", "x_sp")
ONE_ROUNDING = "one-rounding"  # the family of comparisons that measure sensitivity
MIDWAY_S = 2.0  # instant of longer experiments [s] that the page shows by itself
# Safety factor of the grid convergence index for two grids (Roache). The order is taken as 1: the
# dead zone and the clearance's impacts leave no higher one to rely on.
SAFETY = 3.0
# Steps of coarser runs, as shares of the fine run's. Each meets contacts elsewhere in a step.
COARSE_STEP_RATIOS: dict[str, float] = {"coarse": 0.5, "coarse-2": 0.465, "coarse-3": 0.435}


def plan(subjects: Subjects) -> Iterator[Comparison]:
    """Comparisons of runs at the same step, and of runs each beside its own at coarser steps."""
    yield from _plan_same_step(subjects)
    yield from _plan_refined_runs(subjects)


def _plan_same_step(subjects: Subjects) -> Iterator[Comparison]:
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
        if experiment.case.switches.planets == "lumped" and geared_joints(experiment.case.arm):
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
    is_freed = lumped and model in models.free_planets and geared_joints(experiment.case.arm)
    variants = ("free", "free-nudged") if is_freed else ("", "nudged")
    run, nudged = (experiment.run(models.same[0], variant) for variant in variants)
    return run, nudged


def _plan_planets(experiment: ExperimentPlan) -> Iterator[Comparison]:
    """Comparisons of equal planets, as one or each by itself: equal until the planets separate."""
    first, second, *_ = experiment.models.same
    lumped, pair = experiment.run(first), _repetition_runs(experiment, second)
    for quantity in MESH:
        about = make_subject("lumped-free", experiment, quantity, first, first)
        runs = (lumped, pair[0], *pair)
        yield make_comparison(about, runs, partial(_check_same_step, experiment))
    about = make_subject(f"{ONE_ROUNDING}-per-planet", experiment, "x_pr", first, first)
    yield make_comparison(about, pair, measure_sensitivity)


def _check_same_step(
    experiment: ExperimentPlan, about: Subject, *runs: xr.Dataset, time_s: float | None = None
) -> Finding:
    """The check of two runs at the same step, over the whole run or at one instant.

    Behind them come a run and one from a start a rounding away.
    """
    left, right, *repeated = runs
    widest = find_acceptance_limit(experiment, about, repeated[0])
    return check_same_step(about, left, right, Pair(*repeated), widest, time_s)


def _plan_refined_runs(subjects: Subjects) -> Iterator[Comparison]:
    """Comparisons with the reference model's adaptive run, and of its precise run.

    Models with constraints are compared with the second engine at the same short step.
    """
    for experiment in find_usual(subjects):
        models = experiment.models
        reference = refine_adaptive(experiment, "reference")
        for other in (models.same[1], *models.other):
            yield from plan_refined(experiment, reference, refine(experiment, other))
        if models.is_precise:
            precise = refine_adaptive(experiment, "precise")
            first = refine(experiment, models.same[0])
            yield from plan_refined(experiment, precise, first, "precise")
        for engines, *others in models.levels.values():
            for other in others:
                sides = refine(experiment, engines), refine(experiment, other)
                yield from plan_refined(experiment, *sides, quantities=("theta",))
    for experiment in find_experiments(subjects, "short"):
        for tier in experiment.models.constrained:
            sides = refine(experiment, experiment.models.same[1]), refine(experiment, tier)
            yield from plan_refined(experiment, *sides)


@dataclass(frozen=True)
class RefinedRun:
    """A run, and pairs of runs, fine and coarse, that show its numerical uncertainty."""

    run: ModelTask
    pairs: tuple[tuple[ModelTask, ModelTask], ...]

    @property
    def tasks(self) -> list[ModelTask]:
        """The run, then fine and coarse of each pair in turn."""
        return [self.run, *(task for pair in self.pairs for task in pair)]


def refine(experiment: ExperimentPlan, model: str) -> RefinedRun:
    """A model's run with a coarser one of its own, or with the reference model's.

    The reference model's three are for all models of its integrator, whose runs at one step are
    compared besides: the error of a step depends on where in it the teeth meet, so that two runs
    may have equal errors by chance.
    """
    run, same = experiment.run(model), experiment.models.same
    if model not in same:
        return RefinedRun(run, ((run, experiment.run(model, "coarse")),))
    fine = experiment.run(same[0])
    coarser = (experiment.run(same[0], variant) for variant in COARSE_STEP_RATIOS)
    return RefinedRun(run, tuple((fine, each) for each in coarser))


def refine_adaptive(experiment: ExperimentPlan, variant: str) -> RefinedRun:
    """The reference model's run that chooses its own steps, and one of a looser tolerance."""
    first = experiment.models.same[0]
    run = experiment.run(first, variant)
    return RefinedRun(run, ((run, experiment.run(first, f"{variant}-coarse")),))


def plan_refined(
    experiment: ExperimentPlan,
    left: RefinedRun,
    right: RefinedRun,
    family: str = "refined",
    quantities: Sequence[str] = MESH,
) -> Iterator[Comparison]:
    """Comparisons of quantities of two models' runs, each with what shows its uncertainty."""
    tasks, middle = [*left.tasks, *right.tasks], len(left.tasks)

    def judge(about: Subject, *runs: xr.Dataset) -> Finding:
        widest = find_acceptance_limit(experiment, about, runs[0])
        return check_refined_runs(about, runs[:middle], runs[middle:], widest)

    for quantity in recorded_quantities(experiment, quantities):
        about = make_subject(family, experiment, quantity, left.run.model, right.run.model)
        yield make_comparison(about, tasks, judge)


def recorded_quantities(experiment: ExperimentPlan, quantities: Sequence[str] = MESH) -> list[str]:
    """Those of some quantities that runs of the experiment's arm have."""
    has_gears = bool(geared_joints(experiment.case.arm))
    return [name for name in quantities if has_gears or name not in BY_PLANET]


def find_acceptance_limit(
    experiment: ExperimentPlan, about: Subject, run: xr.Dataset
) -> ReasonedLimit:
    """The acceptance limit of an uncertainty of the subject's quantity, as large as in a run."""
    quantity, (arm, scenario, _) = about.key.quantity, experiment.case
    return acceptance_limit(quantity, arm, scenario, size(run, quantity))


def make_subject(
    family: str,
    experiment: ExperimentPlan,
    quantity: str,
    left: str,
    right: str,
    joint: int | None = None,
) -> Subject:
    """The subject of a comparison of two models' runs."""
    key = ComparisonKey(family, experiment.name, quantity, left, right, joint)
    return Subject(key, UNITS[quantity], APART if quantity == "tip" else LARGEST)


class RunMismatch(ValueError):
    """An error for two runs that are not of the same times, joints and planets."""


def largest_difference(run: xr.Dataset, other_run: xr.Dataset, quantity: str) -> float:
    """max over time, joints and planets of |one - other|, in the quantity's unit.

    Raises RunMismatch unless both runs have the quantity at the very same times, joints and
    planets.
    """
    return float(np.fmax.reduce(np.abs(compute_difference(run, other_run, quantity)), axis=None))


def compute_difference(run: xr.Dataset, other_run: xr.Dataset, quantity: str) -> np.ndarray:
    """A run's values of a quantity less another's. Raises RunMismatch."""
    for side in (run, other_run):
        if quantity not in side:
            raise RunMismatch(f"the run of {side.attrs.get('model')} has no {quantity}")
    left, right = run.variables[quantity], other_run.variables[quantity]
    if left.dims != right.dims:
        raise RunMismatch(f"{quantity} is over {left.dims} in one run, {right.dims} in the other")
    for name in map(str, left.dims):
        if not np.array_equal(_labels(run, name), _labels(other_run, name)):
            raise RunMismatch(f"the runs have {quantity} at other values of {name}")
    if (np.isnan(left.values) != np.isnan(right.values)).any():
        raise RunMismatch(f"{quantity} has values in one run where the other has none")
    return left.values - right.values


def size(run: xr.Dataset, quantity: str) -> float:
    """Largest magnitude of a quantity in a run, in its unit."""
    return float(np.fmax.reduce(np.abs(run.variables[quantity].values), axis=None))


def _labels(run: xr.Dataset, name: str) -> np.ndarray:
    """Labels of a dimension; times to 0.1 ns, so that k h and 2 k (h/2) are the same label."""
    labels = run.variables[name].values if name in run.variables else np.arange(run.sizes[name])
    return labels.round(10) if name == "time" else labels


def uncertainty(fine: xr.Dataset, coarse: xr.Dataset, quantity: str) -> float:
    """Numerical uncertainty of `fine`: its distance from the run at twice the step, times 3."""
    return SAFETY * largest_difference(fine, coarse, quantity)


def describe_acceptance(widest: ReasonedLimit) -> str:
    """The limit that an uncertainty must stay below for a verdict, in words."""
    return f"acceptance limit of the uncertainty {widest.value:.2g}, {widest.basis}"


def step_count(run: xr.Dataset) -> float:
    """Number of steps that a run has taken, at least 1."""
    return max(float(run.variables["time"].values[-1]) / float(run.attrs["step_s"]), 1.0)


def relative_value(measured: float, run: xr.Dataset, quantity: str) -> float | None:
    """A difference relative to the quantity's size in a run; None where that size is unknown."""
    largest = size(run, quantity)
    return measured / largest if largest > 0 and np.isfinite(measured) else None


class Pair(NamedTuple):
    """A run, and one from a start that is one rounding away."""

    run: xr.Dataset
    nudged: xr.Dataset


def check_same_step(
    about: Subject,
    left: xr.Dataset,
    right: xr.Dataset,
    pair: Pair,
    widest: ReasonedLimit,
    time_s: float | None = None,
) -> Finding:
    """Check runs of two models through the same integrator and step, over the whole run.

    time_s: the instant to look at alone: the record there and the one before.
    """
    if time_s is not None:
        last = int(np.argmin(np.abs(left["time"].values - time_s)))
        left, right = (run.isel(time=slice(max(last - 1, 0), last + 1)) for run in (left, right))
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


def measure_sensitivity(about: Subject, run: xr.Dataset, nudged: xr.Dataset) -> Finding:
    """Measure how far a run moves when its start is changed by a rounding."""
    basis = "every angle and displacement started a rounding away"
    return measure_deviation(about, nudged, run, basis)


def check_refined_runs(
    about: Subject,
    left: Sequence[xr.Dataset],
    right: Sequence[xr.Dataset],
    widest: ReasonedLimit,
) -> Finding:
    """Check each side's own best run against the other's.

    A side is its run, then pairs, fine and coarse: see RefinedRun. The pair furthest apart gives
    the side's uncertainty.
    """
    quantity = about.key.quantity
    pairs = (zip(side[1::2], side[2::2], strict=True) for side in (left, right))
    u1, u2 = (max(uncertainty(*pair, quantity) for pair in side) for side in pairs)
    rounding = max(run_rounding(side[0], quantity) for side in (left, right))
    combined = float(np.hypot(u1, u2))
    measured = largest_difference(left[0], right[0], quantity)
    return make_check(
        about,
        measured=measured,
        tolerance=combined + rounding,
        resolved=combined <= widest.value,
        basis=(
            f"sqrt(u1^2 + u2^2) + eps s sqrt(N), u1 = {u1:.2g} and u2 = {u2:.2g} by step"
            f" refinement, eps s sqrt(N) = {rounding:.1g}; {describe_acceptance(widest)}"
        ),
        relative=relative_value(measured, left[0], quantity),
    )


def run_rounding(run: xr.Dataset, quantity: str) -> float:
    """Rounding alone of a quantity over a run: half an ulp a step, added up at random.

    Every step rounds the state that it adds to; over N steps that is sqrt(N) roundings of its
    size. No refinement can measure less.
    """
    return float(EPS * size(run, quantity) * math.sqrt(step_count(run)))


def measure_deviation(
    about: Subject, left: xr.Dataset, right: xr.Dataset, basis: str = ""
) -> Finding:
    """Measure how far runs are apart that nobody expects to agree; of one joint, where named.

    The relative difference is over the size of the quantity in the right run.
    """
    quantity, joint = about.key.quantity, about.key.joint
    if joint is not None:
        left, right = (run.sel(joint=[joint]) for run in (left, right))
    measured = largest_difference(right, left, quantity)
    relative = relative_value(measured, right, quantity)
    return make_measurement(about, measured=measured, basis=basis, relative=relative)

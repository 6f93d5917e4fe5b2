"""Runs beside each model's own runs at coarser steps: is their difference what steps explain?"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from crosscheck.checks.sampled import ExperimentPlan, Subjects, find_experiments, find_usual
from crosscheck.checks.scales import EPS, ReasonedLimit
from crosscheck.checks.trajectories import (
    MESH,
    describe_acceptance,
    find_acceptance_limit,
    largest_difference,
    make_subject,
    recorded_quantities,
    relative_value,
    size,
    step_count,
    uncertainty,
)
from crosscheck.findings import Finding, Subject, make_check
from crosscheck.planning.comparison import Comparison, ModelTask, make_comparison

if TYPE_CHECKING:
    import xarray as xr

# Steps of coarser runs, as shares of the fine run's. Each meets contacts elsewhere in a step.
COARSE_STEP_RATIOS: dict[str, float] = {"coarse": 0.5, "coarse-2": 0.465, "coarse-3": 0.435}


def plan(subjects: Subjects) -> Iterator[Comparison]:
    """Comparisons with the reference model's adaptive run, and of its precise run.

    Models with constraints are compared with the second engine at the same short step.
    """
    for experiment in find_usual(subjects):
        models = experiment.models
        first = models.same[0]
        references = [experiment.run(first, f"reference{each}") for each in ("", "-coarse")]
        for other in (models.same[1], *models.other):
            yield from plan_refined(experiment, references, refine(experiment, other))
        if models.is_precise:
            precise = [experiment.run(first, f"precise{each}") for each in ("", "-coarse")]
            yield from plan_refined(experiment, precise, refine(experiment, first), "precise")
        for engines, *others in models.levels.values():
            for other in others:
                sides = refine(experiment, engines), refine(experiment, other)
                yield from plan_refined(experiment, *sides, quantities=("theta",))
    for experiment in find_experiments(subjects, "short"):
        for tier in experiment.models.constrained:
            sides = refine(experiment, experiment.models.same[1]), refine(experiment, tier)
            yield from plan_refined(experiment, *sides)


def refine(experiment: ExperimentPlan, model: str) -> list[ModelTask]:
    """A model's run and a coarser one to estimate its error; then the reference model's pairs.

    These pairs come with models of the same integrator, whose error depends on where in a step the
    teeth meet: two runs may err alike by chance.
    """
    runs, same = [experiment.run(model), experiment.run(model, "coarse")], experiment.models.same
    for variant in COARSE_STEP_RATIOS if model in same else ():
        runs += [experiment.run(same[0]), experiment.run(same[0], variant)]
    return runs


def plan_refined(
    experiment: ExperimentPlan,
    left: Sequence[ModelTask],
    right: Sequence[ModelTask],
    family: str = "refined",
    quantities: Sequence[str] = MESH,
) -> Iterator[Comparison]:
    """Comparisons of quantities of two models' runs, each with its own coarser ones."""

    def judge(about: Subject, *runs: xr.Dataset) -> Finding:
        widest = find_acceptance_limit(experiment, about, runs[0])
        return check_refined_runs(about, runs[: len(left)], runs[len(left) :], widest)

    for quantity in recorded_quantities(experiment, quantities):
        about = make_subject(family, experiment, quantity, left[0].model, right[0].model)
        yield make_comparison(about, (*left, *right), judge)


def check_refined_runs(
    about: Subject,
    left: Sequence[xr.Dataset],
    right: Sequence[xr.Dataset],
    widest: ReasonedLimit,
) -> Finding:
    """Check each side's own best run against the other's.

    A side is a sequence of pairs, fine and coarse, its own first; the pair furthest apart gives its
    uncertainty. An integrator's error where contacts change depends on where in a step they do, so
    that one pair may be close together by chance.
    """
    quantity = about.key.quantity
    uncertainties = [
        max(uncertainty(*pair, quantity) for pair in zip(side[::2], side[1::2], strict=True))
        for side in (left, right)
    ]
    rounding = max(run_rounding(side[0], quantity) for side in (left, right))
    combined = float(np.hypot(uncertainties[0], uncertainties[1]))
    measured = largest_difference(left[0], right[0], quantity)
    return make_check(
        about,
        measured=measured,
        tolerance=combined + rounding,
        resolved=combined <= widest.value,
        basis=(
            f"sqrt(u1^2 + u2^2) + eps s sqrt(N), u1 = {uncertainties[0]:.2g} and u2 ="
            f" {uncertainties[1]:.2g} by step"
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

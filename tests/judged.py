"""The checks of a cross-check on models and runs that a test holds in its hands."""

from collections.abc import Iterator, Sequence

import xarray as xr

from crosscheck.checks import corners, energy, engines, trajectories
from crosscheck.checks import invariants as laws
from crosscheck.checks.answers import EQUATIONS
from crosscheck.checks.first_principles.composite import Content
from crosscheck.checks.sampled import SampledArm, Subjects
from crosscheck.checks.scales import ReasonedLimit, acceptance_limit
from crosscheck.checks.trajectories import SAME_STEP, UNITS, Pair
from crosscheck.findings import ComparisonKey, Finding, Subject
from crosscheck.models.arm.arm import Arm
from crosscheck.models.interface import Model
from crosscheck.models.loading import Case
from crosscheck.planning import arms
from crosscheck.planning.checks import plan_checks
from crosscheck.planning.comparison import Comparison, Results, collect_tasks, judge_comparisons
from crosscheck.runner.outcomes import Failure, failure_from_error


def sampled_model(case: str, model: Model, count: int, seed: int) -> SampledArm:
    """A model that a test has built, at random states."""
    return arms.sample_model(
        case, model.name, Case(model.arm, model.scenario, model.switches), count, seed
    )


def plan_states(
    arm: Arm, count: int, seed: int, content: Content | None = None, groups: Sequence[str] = ()
) -> list[Comparison]:
    """All comparisons of an arm that need no run, or those of some groups of models."""
    models = arms.sample_arm(arm, count, seed, content)
    return plan_checks(Subjects([each for each in models if not groups or each.group in groups]))[0]


def judged(comparisons: Sequence[Comparison], models: Sequence[Model]) -> list[Finding]:
    """The Findings, every model evaluated as it stands here."""
    own = {model.name: model for model in models}
    outcomes = {}
    for task in collect_tasks(comparisons):
        model = own[task.model]
        try:
            outcome = task.question(model, task.setting)
        except Exception as error:
            outcome: object = failure_from_error(error)
        outcomes[task.key] = outcome
    assert all(not isinstance(o, Failure) or o.message for o in outcomes.values())
    return list(judge_comparisons(comparisons, Results(outcomes)))


def compare_states(
    case: str, models: Sequence[Model], quantities: Sequence[str], count: int, seed: int
) -> list[Finding]:
    """A Finding per pair of models and quantity."""
    sampled_models = [sampled_model(case, model, count, seed) for model in models]
    questions = [each for each in EQUATIONS if each.method in quantities]
    return judged(list(engines.plan_pairs(sampled_models, questions)), models)


def compare_corners(case: str, models: Sequence[Model], count: int, seed: int) -> list[Finding]:
    """A Finding per pair of models, of forces at the corners of the mesh laws."""
    sampled_models = [sampled_model(case, model, count, seed) for model in models]
    return judged(list(corners.plan(Subjects(arms=sampled_models))), models)


def invariants(case: str, models: Sequence[Model], count: int, seed: int) -> list[Finding]:
    """Both balances of every geared model."""
    sampled_models = [sampled_model(case, model, count, seed) for model in models]
    return judged([c for sampled in sampled_models for c in laws.plan_balances(sampled)], models)


def about(
    family: str, case: str, quantity: str, left: xr.Dataset, right: xr.Dataset | None = None
) -> Subject:
    """What a comparison of runs is of."""
    other = "" if right is None else right.attrs["model"]
    return Subject(
        ComparisonKey(family, case, quantity, left.attrs["model"], other),
        UNITS.get(quantity, "1"),
        "largest",
    )


def same_step(
    name: str,
    of: Case,
    left: xr.Dataset,
    right: xr.Dataset,
    pair: Pair,
    quantities: Sequence[str] = SAME_STEP,
) -> Iterator[Finding]:
    """Of these quantities those that the left run has, over it all; the pair is any model's."""
    for quantity in _recorded(left, quantities):
        subject = about("same-step", name, quantity, left, right)
        yield trajectories.check_same_step(
            subject, left, right, pair, _widest(of, quantity, pair.run)
        )


def _recorded(run: xr.Dataset, quantities: Sequence[str]) -> list[str]:
    """A run of an arm without gears has no mesh variables."""
    return [quantity for quantity in quantities if quantity in run]


def _widest(of: Case, quantity: str, run: xr.Dataset) -> ReasonedLimit:
    return acceptance_limit(quantity, of.arm, of.scenario, trajectories.size(run, quantity))


def refined(
    name: str,
    of: Case,
    left: tuple[xr.Dataset, xr.Dataset],
    right: tuple[xr.Dataset, xr.Dataset],
    quantities: Sequence[str] = ("theta", "x_sp", "x_pr"),
) -> Iterator[Finding]:
    """Each side's (fine, coarse) runs against the other's."""
    for quantity in quantities:
        subject = about("refined", name, quantity, left[0], right[0])
        sides = ((fine, fine, coarse) for fine, coarse in (left, right))
        yield trajectories.check_refined_runs(subject, *sides, _widest(of, quantity, left[0]))


def energy_over_run(case: str, run: xr.Dataset) -> list[Finding]:
    """Energy against work."""
    return [energy.check_energy_over_run(about("invariants", case, "energy", run), run)]

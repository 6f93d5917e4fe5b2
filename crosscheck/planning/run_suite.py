"""Every comparison of the runs of an experiment."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

from crosscheck import registry
from crosscheck.checks import invariants, trajectories
from crosscheck.checks.records import BY_PLANET
from crosscheck.checks.scales import ReasonedLimit, acceptance_limit, geared_joints
from crosscheck.checks.trajectories import SAME_STEP, UNITS, Pair
from crosscheck.findings import ComparisonKey, Finding, Subject, make_check, make_measurement
from crosscheck.models.arm.layout import lumped_layout
from crosscheck.models.arm.planets import usual_switches
from crosscheck.models.loading import Case
from crosscheck.planning.comparison import Comparison, Results, make_comparison
from crosscheck.planning.plan import COARSE_STEP_RATIOS, Experiment, OrderCase
from crosscheck.runner.tasks import Evaluation, Simulation

LARGEST, APART = "largest absolute difference", "largest distance"
MESH = ("theta", "x_sp", "x_pr")
SENSITIVE = ("theta", "x_sp")
FORM_QUANTITIES = ("theta", "x_sp", "F_sp", "F_pr")
ONE_ROUNDING = "one-rounding"  # the family of comparisons that measure sensitivity
MIDWAY_S = 2.0  # instant of longer experiments [s] that the page shows by itself


def plan_experiment_comparisons(experiment: Experiment) -> list[Comparison]:
    """Every comparison of this experiment's runs, and each run's own completeness."""
    comparisons = [*_plan_fixed_steps(experiment), *_plan_usual_switches(experiment)]
    if experiment.growth is not None:
        comparisons = [relax_comparison(experiment, comparison) for comparison in comparisons]
        growth = experiment.growth
        key = ComparisonKey("stability", experiment.name, "growth-rate", registry.reference_model())
        metric = "fastest-growing vibration with every tooth in contact"
        judged = partial(make_measurement, measured=growth.rate_per_s, note=str(growth))
        comparisons.append(make_comparison(Subject(key, "1/s", metric, "stability"), (), judged))
    return _add_record_checks(comparisons)


def plan_short_comparisons(experiment: Experiment) -> list[Comparison]:
    """Comparisons of models with constraints with ``registry.second_engine()`` at the same step."""
    comparisons = [*_plan_sensitivity(experiment)]
    for tier in _models_covering(registry.find_constrained_models(), experiment.case):
        sides = [_refinement(experiment, name) for name in (registry.second_engine(), tier)]
        comparisons += [
            _plan_refinement(experiment, sides, quantity)
            for quantity in _recorded_quantities(experiment, MESH)
        ]
    return _add_record_checks(comparisons)


def plan_order_comparisons(case: OrderCase) -> list[Comparison]:
    """Comparisons of the order of each fixed-step integrator, smooth and through impacts."""
    able = _models_covering(registry.find_same_integrator_models(), case.case)
    return _add_record_checks([_plan_order(case, model) for model in able])


def _plan_order(case: OrderCase, model: str) -> Comparison:
    runs, formal = case.runs(model), registry.MODELS[model].order
    assert formal is not None  # of fixed-step models
    quantity = "x_sp"
    metric = f"observed order in {quantity} from steps h, h/2, h/4"
    if case.smooth:
        metric = f"distance of the observed order in {quantity} from the formal one"

    def judge_runs(about: Subject, *given: Any) -> Finding:
        if case.smooth:
            return trajectories.check_formal_order(about, given, formal, quantity)
        return trajectories.measure_impact_order(about, given, quantity)

    key = ComparisonKey("order", case.name, "order-of-convergence", model)
    return make_comparison(
        Subject(key, "1", metric, f"order of convergence {formal}"), runs, judge_runs
    )


def _has_meshes(experiment: Experiment) -> bool:
    """Whether runs of the experiment's geared models have mesh variables."""
    return bool(lumped_layout(experiment.case.arm).mesh_joints)


def _recorded_quantities(experiment: Experiment, quantities: Sequence[str]) -> Iterator[str]:
    """Those of some quantities that runs of the experiment's arm have."""
    has_meshes = _has_meshes(experiment)
    return (name for name in quantities if has_meshes or name not in BY_PLANET)


def _plan_sensitivity(experiment: Experiment) -> Iterator[Comparison]:
    """Measurements of how far the reference model's run moves if it starts a rounding away."""
    first = registry.reference_model()
    pair = experiment.run(first), experiment.run(first, "nudged")
    for quantity in _recorded_quantities(experiment, SENSITIVE):
        about = _subject(ONE_ROUNDING, experiment, quantity, (first, first))
        yield make_comparison(about, pair, trajectories.measure_sensitivity)


def _plan_fixed_steps(experiment: Experiment) -> Iterator[Comparison]:
    """Comparisons of the reference model with each model of its integrator, step by step."""
    first, *others = _models_covering(registry.find_same_integrator_models(), experiment.case)
    duration = experiment.case.scenario.duration_s
    for other in others:
        runs = [experiment.run(first), experiment.run(other), *_repetition_runs(experiment, other)]
        families: dict[str, float | None] = {"same-step": None}
        if duration > MIDWAY_S:
            families[f"at-{MIDWAY_S:g}-s"] = MIDWAY_S
        for family, time_s in families.items():
            for quantity in _recorded_quantities(experiment, SAME_STEP):
                about = _subject(family, experiment, quantity, (first, other))
                yield make_comparison(
                    about, runs, partial(_check_same_step, experiment, time_s=time_s)
                )


def _repetition_runs(experiment: Experiment, model: str) -> tuple[Simulation, Simulation]:
    """The reference model's run and one nudged by a rounding, planets as free as the model's."""
    first, lumped = registry.reference_model(), experiment.case.switches.planets == "lumped"
    if lumped and registry.MODELS[model].free_planets and _has_meshes(experiment):
        return experiment.run(first, "free"), experiment.run(first, "free-nudged")
    return experiment.run(first), experiment.run(first, "nudged")


def _plan_planets(experiment: Experiment) -> Iterator[Comparison]:
    """Comparisons of alike planets, counted as one or each for itself: the same until they part."""
    first = registry.reference_model()
    if experiment.case.switches.planets == "free" or not _has_meshes(experiment):
        return
    lumped, pair = experiment.run(first), _repetition_runs(experiment, registry.second_engine())
    for quantity in MESH:
        about = _subject("lumped-free", experiment, quantity, (first, first))
        runs = (lumped, pair[0], *pair)
        yield make_comparison(about, runs, partial(_check_same_step, experiment))
    about = _subject(f"{ONE_ROUNDING}-per-planet", experiment, "x_pr", (first, first))
    yield make_comparison(about, pair, trajectories.measure_sensitivity)


def _check_same_step(
    experiment: Experiment,
    about: Subject,
    left: Any,
    right: Any,
    run: Any,
    nudged: Any,
    time_s: float | None = None,
) -> Finding:
    """The check of two runs at the same step, over the whole run or at one instant."""
    pair, widest = Pair(run, nudged), _acceptance_limit(experiment, about, run)
    if time_s is None:
        return trajectories.check_same_step(about, left, right, pair, widest)
    return trajectories.check_at_time(about, left, right, pair, widest, time_s)


def _acceptance_limit(experiment: Experiment, about: Subject, run: Any) -> ReasonedLimit:
    arm, scenario, _ = experiment.case
    quantity = about.key.quantity
    return acceptance_limit(quantity, arm, scenario, trajectories.size(run, quantity))


def _plan_usual_switches(experiment: Experiment) -> Iterator[Comparison]:
    """Comparisons that are made under the usual switches alone."""
    arm, _, laws = experiment.case
    if laws not in (usual_switches(arm), usual_switches(arm, planets="free")):
        return
    yield from _plan_reference(experiment)
    yield from _plan_sensitivity(experiment)
    yield from _plan_planets(experiment)
    yield from _plan_forms(experiment)
    for level in registry.find_distinct_levels(arm):
        yield from _plan_rigid_level(experiment, level)


def _plan_reference(experiment: Experiment) -> Iterator[Comparison]:
    """Comparisons with the reference model's adaptive run, and of its precise run and energy."""
    first = registry.reference_model()
    reference = experiment.run(first, "reference")
    for other in (
        registry.second_engine(),
        *_models_covering(registry.find_other_integrator_models(), experiment.case),
    ):
        sides = [
            (reference, experiment.run(first, "reference-coarse")),
            _refinement(experiment, other),
        ]
        for quantity in _recorded_quantities(experiment, MESH):
            yield _plan_refinement(experiment, sides, quantity)
    for quantity in (
        _recorded_quantities(experiment, MESH)
        if "precise" in registry.MODELS[first].promises
        else ()
    ):
        precise = experiment.run(first, "precise"), experiment.run(first, "precise-coarse")
        sides = [precise, _refinement(experiment, first)]
        yield _plan_refinement(experiment, sides, quantity, family="precise")
    key = ComparisonKey("invariants", experiment.name, "energy", first)
    metric = "largest difference of energy gained and work done over the run"
    about = Subject(key, "J", metric, "first principles")
    yield make_comparison(about, (reference,), invariants.check_energy_over_run)


def _refinement(experiment: Experiment, model: str) -> tuple[Simulation, ...]:
    """A model's run and a coarser one to estimate its error; then the reference model's pairs.

    These pairs come with models of the same integrator, whose error depends on where in a step the
    teeth meet: two runs may err alike by chance.
    """
    runs: tuple[Simulation, ...] = experiment.run(model), experiment.run(model, "coarse")
    if model not in registry.find_same_integrator_models():
        return runs
    first = registry.reference_model()
    for variant in COARSE_STEP_RATIOS:
        runs = *runs, experiment.run(first), experiment.run(first, variant)
    return runs


def _plan_forms(experiment: Experiment) -> Iterator[Comparison]:
    """Measurements of how far the paper's own forms are from an engine."""
    other = registry.second_engine()
    for form in registry.select_with_method(
        "simulate", _models_covering(registry.model_names("form"), experiment.case)
    ):
        runs = (experiment.run(form), experiment.run(other))
        for quantity in FORM_QUANTITIES:
            about = _subject("form", experiment, quantity, (form, other))
            yield make_comparison(about, runs, trajectories.measure_deviation)


def _models_covering(models: Sequence[str], case: Case) -> tuple[str, ...]:
    """Names of those of some models that are about a case."""
    return registry.select_covering(models, case.arm, case.switches)


def _plan_rigid_level(experiment: Experiment, level: str) -> Iterator[Comparison]:
    """Comparisons of a rigid level's engines, and with the geared arm: joints, and tip."""
    able = _models_covering(sort_engines(level), experiment.case)
    engines, *others = (_refinement(experiment, name) for name in able)
    for other in others:
        yield _plan_refinement(experiment, (engines, other), "theta")
    exact = registry.group_equal_levels(experiment.case.arm)[-1]
    if level in exact and not geared_joints(experiment.case.arm):
        return  # the level is the arm itself
    first, engine = registry.reference_model(), engines[0]
    pair, names = (engine, experiment.run(first)), (engine.model, first)
    tip = partial(trajectories.measure_tip_deviation, arm=experiment.case.arm)
    yield make_comparison(_subject("deviation", experiment, "tip", names), pair, tip)
    for joint in range(1, len(experiment.case.arm.joints) + 1):
        for quantity in ("theta", "theta_dot"):
            about = _subject("deviation", experiment, quantity, names, joint)
            yield make_comparison(about, pair, trajectories.measure_deviation)


def sort_engines(level: str) -> list[str]:
    """Names of a level's rigid models that simulate, those that choose their own steps first."""
    able = registry.select_with_method("simulate", registry.find_level_models(level))
    return sorted(able, key=lambda name: registry.MODELS[name].order is not None)


def _plan_refinement(
    experiment: Experiment,
    sides: Sequence[tuple[Simulation, ...]],
    quantity: str,
    family: str = "refined",
) -> Comparison:
    names = sides[0][0].model, sides[1][0].model
    about = _subject(family, experiment, quantity, names)

    def judge_runs(about: Subject, *runs: Any) -> Finding:
        left, right = runs[: len(sides[0])], runs[len(sides[0]) :]
        return trajectories.check_refined_runs(
            about, left, right, _acceptance_limit(experiment, about, left[0])
        )

    return make_comparison(about, (*sides[0], *sides[1]), judge_runs)


def _subject(
    family: str,
    experiment: Experiment,
    quantity: str,
    models: tuple[str, str],
    joint: int | None = None,
) -> Subject:
    key = ComparisonKey(family, experiment.name, quantity, *models, joint)
    return Subject(key, UNITS[quantity], APART if quantity == "tip" else LARGEST)


def relax_comparison(experiment: Experiment, comparison: Comparison) -> Comparison:
    """The comparison, said to mean nothing where an unstable loop alone may have changed it."""

    def judge_results(about: Subject, results: Results) -> Finding:
        finding = comparison.judge(about, results)
        if finding.verdict in ("failed", "unfinished"):
            return replace(finding, note=f"{finding.note}; {experiment.growth}")
        if finding.verdict not in ("differ", "unresolved") or finding.measured is None:
            return finding
        basis = f"not judged, for {experiment.growth}; else {finding.basis}"
        return make_measurement(
            about, measured=finding.measured, basis=basis, relative=finding.relative
        )

    return replace(comparison, judge=judge_results)


def _add_record_checks(comparisons: Sequence[Comparison]) -> list[Comparison]:
    """The comparisons, and that each run they need is whole and made with stable steps."""
    needs = dict.fromkeys(task for each in comparisons for task in each.needs)
    runs = [task for task in needs if isinstance(task, Simulation)]
    by_step = sorted(runs, key=lambda run: run.case.scenario.step_s)
    largest = {run.model: run for run in by_step}
    return [*map(_plan_record_check, runs), *map(_plan_stable_step, largest.values()), *comparisons]


def _plan_record_check(run: Simulation) -> Comparison:
    key = ComparisonKey("record", run.key.experiment, run.key.variant or "run", run.model)
    about = Subject(key, "1", "times, joints, planets, variables missing", "complete output")

    def judge_run(
        about: Subject, whole: Any
    ) -> Finding:  # no other is handed on; see checks.records
        return make_check(about, measured=0.0, tolerance=0.0, basis="a run is whole or it is none")

    return make_comparison(about, (run,), judge_run)


def _plan_stable_step(run: Simulation) -> Comparison:
    """The check that a run's step is stable; run: that of its model with the largest step."""
    task = Evaluation(run.model, run.case, "largest_stable_step")
    key = ComparisonKey("stable-step", run.key.experiment, "step", run.model)
    about = Subject(key, "1", "largest step over its limit", "stability limit")
    judged = partial(trajectories.check_stable_step, step_s=run.case.scenario.step_s)
    return make_comparison(about, (task,), judged)

"""Every comparison of the runs of an experiment."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

from crosscheck import registry
from crosscheck.checks import invariants, trajectories
from crosscheck.checks.records import BY_PLANET
from crosscheck.checks.scales import ReasonedLimit, meaningful
from crosscheck.checks.trajectories import SAME_STEP, UNITS, Pair
from crosscheck.findings import About, Finding, Key, checked, measured_only
from crosscheck.models.arm.layout import lumped_layout
from crosscheck.models.arm.planets import usual_switches
from crosscheck.models.loading import Case
from crosscheck.planning.comparison import Comparison, Results, answered
from crosscheck.planning.plan import FEWER, Experiment, OrderCase
from crosscheck.runner.tasks import Evaluation, Simulation

LARGEST = "largest absolute difference"
MESH = ("theta", "x_sp", "x_pr")
SENSITIVE = ("theta", "x_sp")
FORM_QUANTITIES = ("theta", "x_sp", "F_sp", "F_pr")
ONE_ROUNDING = "one-rounding"  # the family of comparisons that measure sensitivity
MIDWAY_S = 2.0  # of longer experiments one instant stands on the page for itself


def experiment_comparisons(experiment: Experiment) -> list[Comparison]:
    """Every comparison of this experiment's runs, and each run's own completeness."""
    found = [*_fixed_steps(experiment), *_under_usual_switches(experiment)]
    if experiment.growth is not None:
        found = [_forgiving(experiment, comparison) for comparison in found]
        growth = experiment.growth
        key = Key("stability", experiment.name, "growth-rate", registry.reference_model())
        metric = "fastest-growing vibration with every tooth in contact"
        judged = partial(measured_only, measured=growth.rate_per_s, note=str(growth))
        found.append(answered(About(key, "1/s", metric, "stability"), (), judged))
    return _with_records(found)


def short_comparisons(experiment: Experiment) -> list[Comparison]:
    """Comparisons of models with constraints with ``registry.second_engine()`` at the same step."""
    found = [*_sensitive(experiment)]
    for tier in _about_it(registry.constrained(), experiment.case):
        sides = [_refinement(experiment, name) for name in (registry.second_engine(), tier)]
        found += [_refined(experiment, sides, quantity) for quantity in _of(experiment, MESH)]
    return _with_records(found)


def order_comparisons(case: OrderCase) -> list[Comparison]:
    """Comparisons of the order of each fixed-step integrator, smooth and through impacts."""
    able = _about_it(registry.same_integrator(), case.case)
    return _with_records([_order(case, model) for model in able])


def _order(case: OrderCase, model: str) -> Comparison:
    runs, formal = case.runs(model), registry.MODELS[model].order
    assert formal is not None  # of fixed-step models
    quantity = "x_sp"
    metric = f"observed order in {quantity} from steps h, h/2, h/4"
    if case.smooth:
        metric = f"distance of the observed order in {quantity} from the formal one"

    def judged(about: About, *given: Any) -> Finding:
        if case.smooth:
            return trajectories.formal_order(about, given, formal, quantity)
        return trajectories.order_through_impacts(about, given, quantity)

    key = Key("order", case.name, "order-of-convergence", model)
    return answered(About(key, "1", metric, f"order of convergence {formal}"), runs, judged)


def _has_meshes(experiment: Experiment) -> bool:
    """Whether runs of the experiment's geared models have mesh variables."""
    return bool(lumped_layout(experiment.case.arm).meshing)


def _of(experiment: Experiment, quantities: Sequence[str]) -> Iterator[str]:
    """Those of some quantities that runs of the experiment's arm have."""
    has_meshes = _has_meshes(experiment)
    return (name for name in quantities if has_meshes or name not in BY_PLANET)


def _sensitive(experiment: Experiment) -> Iterator[Comparison]:
    """Measurements of how far the reference model's run moves if it starts a rounding away."""
    first = registry.reference_model()
    pair = experiment.run(first), experiment.run(first, "nudged")
    for quantity in _of(experiment, SENSITIVE):
        about = _about(ONE_ROUNDING, experiment, quantity, (first, first))
        yield answered(about, pair, trajectories.sensitivity)


def _fixed_steps(experiment: Experiment) -> Iterator[Comparison]:
    """Comparisons of the reference model with each model of its integrator, step by step."""
    first, *others = _about_it(registry.same_integrator(), experiment.case)
    duration = experiment.case.scenario.duration_s
    for other in others:
        runs = [experiment.run(first), experiment.run(other), *_repeated(experiment, other)]
        families: dict[str, float | None] = {"same-step": None}
        if duration > MIDWAY_S:
            families[f"at-{MIDWAY_S:g}-s"] = MIDWAY_S
        for family, time_s in families.items():
            for quantity in _of(experiment, SAME_STEP):
                about = _about(family, experiment, quantity, (first, other))
                yield answered(about, runs, partial(_same_step, experiment, time_s=time_s))


def _repeated(experiment: Experiment, model: str) -> tuple[Simulation, Simulation]:
    """The reference model's run and one nudged by a rounding, planets as free as the model's."""
    first, lumped = registry.reference_model(), experiment.case.switches.planets == "lumped"
    if lumped and registry.MODELS[model].free_planets and _has_meshes(experiment):
        return experiment.run(first, "free"), experiment.run(first, "free-nudged")
    return experiment.run(first), experiment.run(first, "nudged")


def _planets(experiment: Experiment) -> Iterator[Comparison]:
    """Comparisons of alike planets, counted as one or each for itself: the same until they part."""
    first = registry.reference_model()
    if experiment.case.switches.planets == "free" or not _has_meshes(experiment):
        return
    lumped, pair = experiment.run(first), _repeated(experiment, registry.second_engine())
    for quantity in MESH:
        about = _about("lumped-free", experiment, quantity, (first, first))
        runs = (lumped, pair[0], *pair)
        yield answered(about, runs, partial(_same_step, experiment))
    about = _about(f"{ONE_ROUNDING}-per-planet", experiment, "x_pr", (first, first))
    yield answered(about, pair, trajectories.sensitivity)


def _same_step(
    experiment: Experiment,
    about: About,
    left: Any,
    right: Any,
    run: Any,
    nudged: Any,
    time_s: float | None = None,
) -> Finding:
    """The check of two runs at the same step, over the whole run or at one instant."""
    pair, widest = Pair(run, nudged), _widest(experiment, about, run)
    if time_s is None:
        return trajectories.same_step(about, left, right, pair, widest)
    return trajectories.at_time(about, left, right, pair, widest, time_s)


def _widest(experiment: Experiment, about: About, run: Any) -> ReasonedLimit:
    arm, scenario, _ = experiment.case
    quantity = about.key.quantity
    return meaningful(quantity, arm, scenario, trajectories.size(run, quantity))


def _under_usual_switches(experiment: Experiment) -> Iterator[Comparison]:
    """Comparisons that are made under the usual switches alone."""
    arm, _, laws = experiment.case
    if laws not in (usual_switches(arm), usual_switches(arm, planets="free")):
        return
    yield from _against_reference(experiment)
    yield from _sensitive(experiment)
    yield from _planets(experiment)
    yield from _forms(experiment)
    for level in registry.RIGID_LEVELS:
        yield from _rigid(experiment, level)


def _against_reference(experiment: Experiment) -> Iterator[Comparison]:
    """Comparisons with the reference model's adaptive run, and of its precise run and energy."""
    first = registry.reference_model()
    reference = experiment.run(first, "reference")
    for other in (registry.second_engine(), *_about_it(registry.refined_alone(), experiment.case)):
        sides = [
            (reference, experiment.run(first, "reference-coarse")),
            _refinement(experiment, other),
        ]
        for quantity in _of(experiment, MESH):
            yield _refined(experiment, sides, quantity)
    for quantity in _of(experiment, MESH) if "precise" in registry.MODELS[first].promises else ():
        precise = experiment.run(first, "precise"), experiment.run(first, "precise-coarse")
        sides = [precise, _refinement(experiment, first)]
        yield _refined(experiment, sides, quantity, family="precise")
    key = Key("invariants", experiment.name, "energy", first)
    metric = "largest difference of energy gained and work done over the run"
    about = About(key, "J", metric, "first principles")
    yield answered(about, (reference,), invariants.energy_over_run)


def _refinement(experiment: Experiment, model: str) -> tuple[Simulation, ...]:
    """A model's run and a coarser one to tell how good it is; then the reference model's pairs.

    These pairs come with models of the same integrator, whose error hangs on where in a step the
    teeth meet: two runs may err alike by chance.
    """
    own: tuple[Simulation, ...] = experiment.run(model), experiment.run(model, "coarse")
    if model not in registry.same_integrator():
        return own
    first = registry.reference_model()
    for variant in FEWER:
        own = *own, experiment.run(first), experiment.run(first, variant)
    return own


def _forms(experiment: Experiment) -> Iterator[Comparison]:
    """Measurements of how far the paper's own forms are from an engine."""
    other = registry.second_engine()
    for form in registry.promising("simulate", _about_it(registry.names("form"), experiment.case)):
        runs = (experiment.run(form), experiment.run(other))
        for quantity in FORM_QUANTITIES:
            about = _about("form", experiment, quantity, (form, other))
            yield answered(about, runs, trajectories.deviation)


def _about_it(models: Sequence[str], case: Case) -> tuple[str, ...]:
    """Names of those of some models that are about a case."""
    return registry.about(models, case.arm, case.switches)


def _rigid(experiment: Experiment, level: str) -> Iterator[Comparison]:
    """Comparisons of a rigid level's engines, and with the geared arm: joints, and tip."""
    able = _about_it(engines_first(level), experiment.case)
    engines, *others = (_refinement(experiment, name) for name in able)
    for other in others:
        yield _refined(experiment, (engines, other), "theta")
    first, engine = registry.reference_model(), engines[0]
    pair, names = (engine, experiment.run(first)), (engine.model, first)
    tip = partial(trajectories.tip_deviation, arm=experiment.case.arm)
    yield answered(_about("deviation", experiment, "tip", names), pair, tip)
    for joint in range(1, len(experiment.case.arm.joints) + 1):
        for quantity in ("theta", "theta_dot"):
            about = _about("deviation", experiment, quantity, names, joint)
            yield answered(about, pair, trajectories.deviation)


def engines_first(level: str) -> list[str]:
    """Names of a level's rigid models that simulate, those that choose their own steps first."""
    able = registry.promising("simulate", registry.of_level(level))
    return sorted(able, key=lambda name: registry.MODELS[name].order is not None)


def _refined(
    experiment: Experiment,
    sides: Sequence[tuple[Simulation, ...]],
    quantity: str,
    family: str = "refined",
) -> Comparison:
    names = sides[0][0].model, sides[1][0].model
    about = _about(family, experiment, quantity, names)

    def judged(about: About, *runs: Any) -> Finding:
        left, right = runs[: len(sides[0])], runs[len(sides[0]) :]
        return trajectories.refined(about, left, right, _widest(experiment, about, left[0]))

    return answered(about, (*sides[0], *sides[1]), judged)


def _about(
    family: str,
    experiment: Experiment,
    quantity: str,
    models: tuple[str, str],
    joint: int | None = None,
) -> About:
    return About(Key(family, experiment.name, quantity, *models, joint), UNITS[quantity], LARGEST)


def _forgiving(experiment: Experiment, comparison: Comparison) -> Comparison:
    """The comparison, said to mean nothing where an unstable loop alone may have moved it."""

    def judged(about: About, results: Results) -> Finding:
        finding = comparison.judge(about, results)
        if finding.verdict in ("failed", "unfinished"):
            return replace(finding, note=f"{finding.note}; {experiment.growth}")
        if finding.verdict not in ("differ", "unresolved") or finding.measured is None:
            return finding
        basis = f"not judged, for {experiment.growth}; else {finding.basis}"
        return measured_only(
            about, measured=finding.measured, basis=basis, relative=finding.relative
        )

    return replace(comparison, judge=judged)


def _with_records(comparisons: Sequence[Comparison]) -> list[Comparison]:
    """The comparisons, and that each run they need is whole and made with stable steps."""
    needs = dict.fromkeys(task for each in comparisons for task in each.needs)
    runs = [task for task in needs if isinstance(task, Simulation)]
    by_step = sorted(runs, key=lambda run: run.case.scenario.step_s)
    largest = {run.model: run for run in by_step}
    return [*map(_record, runs), *map(_stable_step, largest.values()), *comparisons]


def _record(run: Simulation) -> Comparison:
    key = Key("record", run.key.experiment, run.key.variant or "run", run.model)
    about = About(key, "1", "times, joints, planets, variables missing", "complete output")

    def judged(about: About, whole: Any) -> Finding:  # no other is handed on; see checks.records
        return checked(about, measured=0.0, tolerance=0.0, basis="a run is whole or it is none")

    return answered(about, (run,), judged)


def _stable_step(run: Simulation) -> Comparison:
    """The check that a run's step is stable; run: that of its model with the largest step."""
    task = Evaluation(run.model, run.case, "largest_stable_step")
    key = Key("stable-step", run.key.experiment, "step", run.model)
    about = About(key, "1", "largest step over its limit", "stability limit")
    judged = partial(trajectories.stable_step, step_s=run.case.scenario.step_s)
    return answered(about, (task,), judged)

"""Every comparison of the runs of an experiment."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import Any

from crosscheck.checks import convergence, invariants, trajectories
from crosscheck.checks.trajectories import SAME_STEP, UNITS
from crosscheck.comparison import Comparison, Results
from crosscheck.findings import About, Finding, Key, checked
from crosscheck.plan import MECHANISM, Experiment, OrderCase
from crosscheck.registry import MODELS, PAPER_FORMS, RIGID_LEVELS
from crosscheck.state_suite import covered_by_paper
from crosscheck.tasks import Evaluation, Simulation

LARGEST = "largest absolute difference"
ANALYTIC, TREE, BODIES = "analytic:physical", "exudyn:tree", "exudyn:bodies"
FIXED_STEP = (ANALYTIC, TREE)
MESH = ("theta", "x_sp", "x_pr")
FORM_QUANTITIES = ("theta", "x_sp", "F_sp", "F_pr")
MIDWAY_S = 2.0  # the paper's events are over; the comparison at one instant stands on the page


def experiment_comparisons(experiment: Experiment) -> list[Comparison]:
    """Every comparison of this experiment's runs, and each run's own completeness."""
    return _with_records([*_fixed_steps(experiment), *_under_mechanism(experiment)])


def short_comparisons(experiment: Experiment) -> list[Comparison]:
    """Exudyn's tier with constraints against its tree."""
    sides = [(experiment.run(tier), experiment.run(tier, "coarse")) for tier in (TREE, BODIES)]
    return _with_records([_refined(experiment, sides, quantity) for quantity in MESH])


def order_comparisons(case: OrderCase) -> list[Comparison]:
    """Observed order of each fixed-step integrator, smooth and through impacts."""
    return _with_records([_order(case, model) for model in FIXED_STEP])


def _order(case: OrderCase, model: str) -> Comparison:
    runs, formal = case.runs(model), MODELS[model].order
    assert formal is not None  # of fixed-step models
    key = Key("order", case.name, "order-of-convergence", model)
    against = f"formal order {formal}"
    if case.smooth:
        metric = "distance of the observed order in x_sp from the formal one"
        return _of_runs(
            About(key, "1", metric, against),
            runs,
            lambda about, *given: convergence.formal_order(about, given, formal),
        )
    return _of_runs(
        About(key, "1", "observed order in x_sp from steps h, h/2, h/4", against),
        runs,
        lambda about, *given: convergence.order_through_impacts(about, given),
    )


def _fixed_steps(experiment: Experiment) -> Iterator[Comparison]:
    """The analytic model and Exudyn's tree, step by step the same integrator."""
    runs = [experiment.run(model) for model in FIXED_STEP]
    duration = experiment.case.scenario.duration_s
    for quantity in SAME_STEP:
        yield _of_runs(_about("same-step", experiment, quantity), runs, trajectories.same_step)
    for quantity in SAME_STEP if duration > MIDWAY_S else ():
        at = partial(trajectories.at_time, time_s=MIDWAY_S)
        yield _of_runs(_about(f"at-{MIDWAY_S:g}-s", experiment, quantity), runs, at)


def _under_mechanism(experiment: Experiment) -> Iterator[Comparison]:
    """What is asked under the default switches alone."""
    if experiment.case.switches != MECHANISM:
        return
    yield from _against_reference(experiment)
    ours, moved = experiment.run(ANALYTIC), experiment.run(ANALYTIC, "nudged")
    for quantity in ("theta", "x_sp"):
        about = _about("one-ulp", experiment, quantity, (ANALYTIC, ANALYTIC))
        yield _of_runs(about, (ours, moved), trajectories.sensitivity)
    if covered_by_paper(experiment.case.arm):
        yield from _forms(experiment)
    for level in RIGID_LEVELS:
        yield from _rigid(experiment, level)


def _against_reference(experiment: Experiment) -> Iterator[Comparison]:
    """The analytic model's adaptive reference against the tree's refined steps; its energy."""
    reference = experiment.run(ANALYTIC, "reference")
    sides = [
        (reference, experiment.run(ANALYTIC, "reference-coarse")),
        (experiment.run(TREE), experiment.run(TREE, "coarse")),
    ]
    for quantity in MESH:
        yield _refined(experiment, sides, quantity)
    key = Key("invariants", experiment.name, "energy", ANALYTIC)
    metric = "largest difference of energy gained and work done over the run"
    about = About(key, "J", metric, "first principles")
    yield _of_runs(about, (reference,), invariants.energy_over_run)


def _forms(experiment: Experiment) -> Iterator[Comparison]:
    """How far the paper's own forms are from an engine."""
    for form in PAPER_FORMS:
        runs = (experiment.run(form), experiment.run(TREE))
        for quantity in FORM_QUANTITIES:
            about = _about("form", experiment, quantity, (form, TREE))
            yield _of_runs(about, runs, trajectories.deviation)


def _rigid(experiment: Experiment, level: str) -> Iterator[Comparison]:
    """A rigid level in two engines, and how far it is from the geared arm: joints, and tip."""
    engines = (f"pinocchio:{level}", f"analytic:{level}")
    sides = [(experiment.run(name), experiment.run(name, "coarse")) for name in engines]
    yield _refined(experiment, sides, "theta")
    pair, names = (sides[0][0], experiment.run(ANALYTIC)), (engines[0], ANALYTIC)
    tip = partial(trajectories.tip_deviation, arm=experiment.case.arm)
    yield _of_runs(_about("deviation", experiment, "tip", names), pair, tip)
    for joint in range(1, len(experiment.case.arm.joints) + 1):
        for quantity in ("theta", "theta_dot"):
            about = _about("deviation", experiment, quantity, names, joint)
            yield _of_runs(about, pair, trajectories.deviation)


def _refined(
    experiment: Experiment, sides: Sequence[tuple[Simulation, Simulation]], quantity: str
) -> Comparison:
    names = sides[0][0].model, sides[1][0].model
    about = _about("refined", experiment, quantity, names)

    def judged(about: About, fine: Any, coarse: Any, other: Any, other_coarse: Any) -> Finding:
        return trajectories.refined(about, (fine, coarse), (other, other_coarse))

    return _of_runs(about, (*sides[0], *sides[1]), judged)


def _about(
    family: str,
    experiment: Experiment,
    quantity: str,
    models: tuple[str, str] = FIXED_STEP,
    joint: int | None = None,
) -> About:
    return About(Key(family, experiment.name, quantity, *models, joint), UNITS[quantity], LARGEST)


def _of_runs(about: About, runs: Sequence[Simulation], judge: Callable[..., Finding]) -> Comparison:
    """A comparison that is handed the runs, in their order."""

    def judged(about: About, results: Results) -> Finding:
        return judge(about, *(results.need(run) for run in runs))

    return Comparison(about, tuple(runs), judged)


def _with_records(comparisons: Sequence[Comparison]) -> list[Comparison]:
    """And that each run that they need is whole, and made with stable steps."""
    needs = dict.fromkeys(task for each in comparisons for task in each.needs)
    runs = [task for task in needs if isinstance(task, Simulation)]
    by_step = sorted(runs, key=lambda run: run.case.scenario.step_s)
    largest = {run.model: run for run in by_step}
    return [*map(_record, runs), *map(_stable_step, largest.values()), *comparisons]


def _record(run: Simulation) -> Comparison:
    key = Key("record", run.key.experiment, run.key.variant or "run", run.model)
    about = About(key, "1", "times, joints, planets, variables missing", "what its experiment asks")

    def judged(about: About, results: Results) -> Finding:
        results.need(run)  # only a whole run is handed on; see checks.records
        return checked(about, measured=0.0, tolerance=0.0, basis="a run is whole or it is none")

    return Comparison(about, (run,), judged)


def _stable_step(run: Simulation) -> Comparison:
    """Of all runs of a model in an experiment, that with the largest step."""
    task = Evaluation(run.model, run.case, "largest_stable_step")
    key = Key("stable-step", run.key.experiment, "step", run.model)

    def judged(about: About, results: Results) -> Finding:
        limit = float(results.need(task))
        return convergence.stable_step(about, run.case.scenario.step_s, limit)

    about = About(key, "1", "largest step over its limit", "the model's own limit")
    return Comparison(about, (task,), judged)

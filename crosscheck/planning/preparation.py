"""Finds the sizes, stability and steps of an arm that its runs are planned with."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any

from crosscheck.analytic.paper.coverage import PAPER_COVERAGE
from crosscheck.checks.modes import largest_stable_step
from crosscheck.checks.scales import acceptance_limit, geared_joints
from crosscheck.checks.trajectories import size, uncertainty
from crosscheck.findings import ComparisonKey, Subject, make_failed_check
from crosscheck.models.arm.arm import Arm
from crosscheck.models.arm.planets import usual_switches
from crosscheck.models.errors import Diverged, Unfinished
from crosscheck.models.experiment.scenario import switches
from crosscheck.planning import plan
from crosscheck.planning.comparison import Comparison, make_comparison
from crosscheck.planning.plan import CrossCheckRequest, Experiment
from crosscheck.planning.sizing import Sizes, compute_sizes, find_growing_mode
from crosscheck.registry import (
    build,
    find_covering_models,
    find_same_integrator_models,
    model_names,
    reference_model,
    select_covering,
)
from crosscheck.runner.outcomes import DIED, Failure, FunctionTask
from crosscheck.runner.tasks import Evaluation, Simulation, ask_model
from crosscheck.runner.workers import Workers

if TYPE_CHECKING:
    import xarray as xr

# An experiment's step is halved so often at most, until its uncertainty is so much smaller than
# what means something.
MOST_HALVINGS = 4
# By how much, judged by each of the runs that a comparison will judge by: where in a step contacts
# are met hangs on the step, so that one of them may be close to the fine run by chance.
MARGINS = {"coarse": 2.0, "coarse-2": 1.1, "coarse-3": 1.1}


def fail_preparation(key: ComparisonKey, why: Failure) -> Comparison:
    """The failed check for what could not be found out: the plan stands on what it knew without."""
    about = Subject(key, "1", "whether it could be found out", "the plan")
    return make_comparison(about, (), partial(make_failed_check, note=f"{key.left}: {why}"))


@dataclass(frozen=True)
class Preparation:
    """Experiments ready to run, largest stable step [s] of their models, remarks to the user.

    lost: what is not known because a model failed; each is a failed check.
    """

    experiments: Sequence[Experiment]
    limit_s: float
    remarks: tuple[str, ...]
    lost: tuple[Comparison, ...] = ()


def refine_until_resolved(request: CrossCheckRequest, experiment: Experiment) -> Experiment:
    """The experiment at a step that its comparisons can mean something at, found by trying.

    It is tried on the reference model, a hundred times as fast as the engines that are to follow.
    """
    experiment = plan.limit_duration(request, experiment)
    for _ in range(MOST_HALVINGS):
        if _is_fine(experiment):
            break
        finer = plan.set_step(experiment.case, experiment.case.scenario.step_s / 2)
        experiment = plan.limit_duration(request, replace(experiment, case=finer))
    return experiment


def _is_fine(experiment: Experiment) -> bool:
    """Whether the uncertainty at the experiment's step is well below the acceptance limit.

    Also true where no step would help: a run that diverges is what its checks are about.
    """
    try:
        fine = _run(experiment.run(reference_model()))
    except Diverged:
        return True
    arm, scenario, _ = experiment.case
    for variant, margin in MARGINS.items():
        try:
            coarse = _run(experiment.run(reference_model(), variant))
        except Diverged:
            return False
        for quantity in (name for name in ("theta", "x_sp", "x_pr") if name in fine):
            widest = acceptance_limit(quantity, arm, scenario, size(fine, quantity))
            if margin * uncertainty(fine, coarse, quantity) > widest.value:
                return False
    return True


def _run(task: Simulation) -> xr.Dataset:
    return build(task.model, *task.case).simulate()


def prepare_experiments(request: CrossCheckRequest, workers: Workers) -> Preparation:
    """Facts for the plan: experiments, their largest stable step, remarks and failures.

    Raises InputError, and Unfinished where a model was stopped or its process died: what is then
    unknown depends on the machine, and so would the plan.
    """
    failures: dict[ComparisonKey, Failure] = {}
    sizes, remarks = None, list[str]()
    if request.needs_sizes:
        query = FunctionTask(compute_sizes, (request.arm,), 1.0)
        (sizes,) = _run_queries({_key(request.arm.name, "sizes"): query}, workers, failures)
        remarks = _describe_sizes(sizes, list(failures.values()))
    outline = plan.draft_experiments(request, sizes)
    laws = usual_switches(request.arm)
    limits = {
        _key(each.name, largest_stable_step.__name__, model): ask_model(
            model, each.case._replace(switches=laws), largest_stable_step
        )
        for model in select_covering(find_same_integrator_models(), request.arm, laws)
        for each in outline
    }
    answers = _run_queries(limits, workers, failures)
    limit = min((float(each) for each in answers if each is not None), default=float("inf"))
    started = [plan.set_stable_step(each, limit) for each in outline]
    growths = {
        _key(each.name, "growth-rate"): FunctionTask(find_growing_mode, each.case[:2], 0.5)
        for each in outline
    }
    free = [] if request.has_fixed_steps else started
    steps = {
        _key(e.name, "step"): FunctionTask(refine_until_resolved, (request, e), 5.0) for e in free
    }
    answers = _run_queries(growths | steps, workers, failures)
    fine = answers[len(growths) :] or [None] * len(started)
    experiments = [
        replace(settling or plan.limit_duration(request, experiment), growth=growth)
        for experiment, growth, settling in zip(started, answers, fine, strict=False)
    ]
    remarks += [f"{each.name}: {each.growth}" for each in experiments if each.growth is not None]
    remarks += _describe_forms(request.arm)
    experiments.append(plan.make_probe_experiment())
    lost = itertools.starmap(fail_preparation, failures.items())
    return Preparation(experiments, limit, tuple(remarks), tuple(lost))


def _key(case: str, quantity: str, model: str = "") -> ComparisonKey:
    """Key of what a task finds out of an experiment or arm, by the reference model unless named."""
    return ComparisonKey("preparation", case, quantity, model or reference_model())


def _run_queries(
    queries: Mapping[ComparisonKey, FunctionTask | Evaluation],
    workers: Workers,
    failures: dict[ComparisonKey, Failure],
) -> list[Any]:
    """Answers in the order of the queries: None for each that failed, added to ``failures``.

    Raises Unfinished where a model did not come back.
    """
    outcomes = workers.perform(list(dict.fromkeys(queries.values())))
    answers = []
    for key, task in queries.items():
        outcome: Any = outcomes[task.key]
        if isinstance(outcome, Failure):
            if outcome.unfinished or outcome.kind == DIED:
                what = f"preparing {key.case}: {key.quantity} by {key.left}"
                raise Unfinished(f"{what}: {outcome}")
            failures[key], outcome = outcome, None
        answers.append(outcome)
    return answers


def _describe_sizes(sizes: Sizes | None, failures: Sequence[Failure]) -> list[str]:
    """Remarks on the experiments that were made for the arm, or why there are none."""
    if sizes is None:
        return [f"experiments could not be sized to the arm: {each}" for each in failures]
    mode = "no gears" if sizes.mode_Hz is None else f"lowest mesh mode {sizes.mode_Hz:.4g} Hz"
    return [
        f"experiments sized to the arm: {mode}, controller at {sizes.rate:.3g} rad/s",
        f"torque-step: {_format_values(sizes.step)} N m",
        f"pd-motion: to {_format_values(sizes.target)} rad, P"
        f" {_format_values(sizes.proportional)} N m/rad,"
        f" D {_format_values(sizes.derivative)} N m s/rad",
    ]


def _describe_forms(arm: Arm) -> list[str]:
    """A remark on the paper's own forms where they are not about an arm with gears."""
    covering = find_covering_models("form", arm, switches())
    without = [name for name in model_names("form") if name not in covering]
    if not (without and geared_joints(arm)):
        return []
    return [f"without {', '.join(without)}: each {PAPER_COVERAGE}"]


def _format_values(values: Sequence[float]) -> str:
    return ", ".join(f"{value:.4g}" for value in values)

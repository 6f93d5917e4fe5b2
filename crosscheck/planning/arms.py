"""The cross-check of an arm: every comparison of its models, of states and of experiments."""

from __future__ import annotations

from functools import partial
from importlib import import_module

from crosscheck.planning import energy_suite, plan, run_suite, state_suite
from crosscheck.planning.comparison import Comparison, Plan
from crosscheck.planning.preparation import Preparation, prepare_experiments
from crosscheck.runner.workers import Workers


def plan_arm(request: plan.CrossCheckRequest, workers: Workers) -> Plan:
    """The whole cross-check of an arm. Raises InputError, Unfinished."""
    import_module("xarray")  # of all runs, before workers fork: they share it
    preparation = prepare_experiments(request, workers)
    comparisons = plan_comparisons(request, preparation)
    settings = request.arm, request.quick, request.seed
    entries = partial(state_suite.compute_entry_differences, *settings)
    return Plan(comparisons, preparation.remarks, entries)


def plan_comparisons(request: plan.CrossCheckRequest, preparation: Preparation) -> list[Comparison]:
    """All comparisons of a cross-check of the arm, before any task of theirs has run.

    Raises InputError.
    """
    arm, quick, seed = request.arm, request.quick, request.seed
    comparisons: list[Comparison] = []
    for reading, arm_file_json in plan.arm_variants(request):
        comparisons += state_suite.plan_state_comparisons(reading, quick, seed, arm_file_json)
    comparisons += state_suite.plan_probe_comparisons(arm, quick, seed)
    for experiment in preparation.experiments:
        comparisons += run_suite.plan_experiment_comparisons(experiment)
    first = preparation.experiments[0]
    for experiment in plan.make_short_experiments(arm, first, preparation.limit_s):
        comparisons += run_suite.plan_short_comparisons(experiment)
    comparisons += energy_suite.plan_energy_comparisons(arm, first, preparation.limit_s)
    for case in plan.make_order_cases(arm, first, preparation.limit_s):
        comparisons += run_suite.plan_order_comparisons(case)
    return [*comparisons, *(each.comparison for each in preparation.lost)]


def describe_quick_limits(request: plan.CrossCheckRequest) -> str:
    """Sentences on what a quick cross-check of an arm leaves out."""
    runs = f"at most {plan.QUICK_STEPS} steps of each experiment are simulated"
    if request.has_fixed_steps:
        short = (
            f"{each:g} of {plan.FULL_S[name]:g} s of {name}" for name, each in plan.QUICK_S.items()
        )
        runs = f"{' and '.join(short)} are simulated"
    elif request.needs_sizes:
        runs = f"{runs}, a full cross-check takes up to {plan.FULL_STEPS}"
    return (
        f"With --quick {runs}, and models are compared at {state_suite.QUICK_COUNT} random states"
        f" where a full cross-check takes {state_suite.COUNT}. What happens later in the runs is"
        " not judged here."
    )

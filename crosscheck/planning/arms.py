"""The cross-check of an arm: its models at random states, and its experiments."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from importlib import import_module
from itertools import product

from crosscheck.checks.answers import bias, generalized_force, mass_matrix
from crosscheck.checks.first_principles.composite import Content
from crosscheck.checks.records import plan_records
from crosscheck.checks.sampled import Group, SampledArm, Subjects
from crosscheck.checks.scales import geared_joints
from crosscheck.checks.stability import relax_comparison
from crosscheck.findings import EntryDifferences
from crosscheck.models.arm.arm import Arm
from crosscheck.models.arm.meshes import replace_damping
from crosscheck.models.arm.planets import usual_switches
from crosscheck.models.experiment.scenario import Switches, switches
from crosscheck.models.files import read_raw_arm
from crosscheck.models.loading import Case, load_arm
from crosscheck.planning import plan
from crosscheck.planning.checks import plan_checks
from crosscheck.planning.comparison import Comparison, Plan, Results, collect_tasks, compare_entries
from crosscheck.planning.preparation import Preparation, prepare_experiments
from crosscheck.planning.sizing import make_unequal_gains_scenario
from crosscheck.registry import (
    MODELS,
    Role,
    engine_of,
    find_covering_models,
    find_distinct_levels,
    find_level_models,
    is_covering,
    select_covering,
)
from crosscheck.runner.tasks import FORMS, Evaluation, Simulation, SymbolicEvaluation, make_setting
from crosscheck.runner.workers import Workers

COUNT, QUICK_COUNT = 200, 20
SWITCH_COUNT = 20  # number of states of a switch setting


def plan_arm(request: plan.CrossCheckRequest, workers: Workers) -> Plan:
    """The whole cross-check of an arm. Raises InputError, Unfinished."""
    import_module("xarray")  # of all runs, before workers fork: they share it
    preparation = prepare_experiments(request, workers)
    models = list(sample_arm(request.arm, count_states(request), request.seed))
    entries = partial(compute_entry_differences, request.arm, models)
    return Plan(plan_comparisons(request, preparation), preparation.remarks, entries)


def plan_comparisons(request: plan.CrossCheckRequest, preparation: Preparation) -> list[Comparison]:
    """All comparisons of a cross-check of the arm, before any task of theirs has run.

    Raises InputError.
    """
    settings = request.arm, preparation.experiments[0], preparation.limit_s
    comparisons, _ = plan_checks(Subjects(arms=list(sample_request(request))))
    makers = plan.make_short_experiments, plan.make_energy_experiments, plan.make_order_experiments
    further = (each for make in makers for each in make(*settings))
    for experiment in (*preparation.experiments, *further):
        comparisons += plan_experiment_comparisons(experiment)
    return [*comparisons, *preparation.lost]


def plan_experiment_comparisons(experiment: plan.Experiment) -> list[Comparison]:
    """Every comparison of this experiment's runs, and each run's own completeness."""
    comparisons, _ = plan_checks(Subjects(experiments=[experiment]))
    if experiment.growth is not None:
        comparisons = [relax_comparison(experiment, comparison) for comparison in comparisons]
    if experiment.purpose == "energy":
        return comparisons
    runs = [task for task in collect_tasks(comparisons) if isinstance(task, Simulation)]
    return [*plan_records(runs), *comparisons]


def count_states(request: plan.CrossCheckRequest) -> int:
    """How many random states each model is asked at."""
    return QUICK_COUNT if request.quick else COUNT


def sample_request(request: plan.CrossCheckRequest) -> Iterator[SampledArm]:
    """The models of a request's arm, and of the probe arm, of unequal numbers, also by switches."""
    count, seed = count_states(request), request.seed
    for arm, content in plan.arm_variants(request):
        yield from sample_arm(arm, count, seed, content)
    probe = load_arm("probe")
    if request.arm != probe:
        if request.arm.name == probe.name:  # a user's own of that name
            probe = probe.model_copy(update={"name": "built-in-probe"})
        yield from sample_arm(probe, count, seed, read_raw_arm("probe"))
    if not request.quick:
        yield from sample_switches(probe, seed)


def sample_arm(
    arm: Arm, count: int, seed: int, content: Content | None = None
) -> Iterator[SampledArm]:
    """The models of an arm: geared, the paper's forms, of rigid levels, and of single planets.

    Springs that are a potential have undamped meshes, so that all but drive, friction and weight
    is a function of state. content: what the arm's file holds; its own fields where there is none.
    """
    usual, few = usual_switches(arm), min(count, SWITCH_COUNT)
    content = content or arm.model_dump()
    sample = partial(_sample_group, seed=seed, content=content)
    yield from sample("geared", arm, usual, count)
    yield from sample("form", arm, switches(), count, where="geared")
    for level in find_distinct_levels(arm):
        names = select_covering(find_level_models(level), arm, usual)
        yield from sample("rigid", arm, usual, count, where=level, names=names)
    if geared_joints(arm):
        free = usual_switches(arm, planets="free")
        if usual.planets == "lumped":
            yield from sample("free", arm, free, few)
        springs = free.model_copy(update={"mesh_work": "conservative"})
        yield from sample("conservative", replace_damping(arm, 0.0), springs, few)


def sample_switches(arm: Arm, seed: int) -> Iterator[SampledArm]:
    """The geared models of an arm under all switch settings."""
    for chosen in switch_combinations():
        # The paper's own way with planets and springs goes without saying.
        laws: list[str] = [chosen.phase, chosen.ring_rate, chosen.dead_zone, chosen.damping]
        laws += ["free"] if chosen.planets == "free" else []
        laws += ["conservative"] if chosen.mesh_work == "conservative" else []
        yield from _sample_group("switches", arm, chosen, SWITCH_COUNT, seed, where="-".join(laws))


def _sample_group(
    group: Group,
    arm: Arm,
    chosen: Switches,
    count: int,
    seed: int,
    content: Content | None = None,
    *,
    where: str = "",
    names: Sequence[str] | None = None,
) -> Iterator[SampledArm]:
    """The models of a group, or those of some names; where: what ids have behind the arm's name."""
    case = Case(arm, make_unequal_gains_scenario(arm), chosen)
    role: Role = "form" if group == "form" else "geared"
    for name in find_covering_models(role, arm, chosen) if names is None else names:
        place = f"{arm.name}/{where or group}"
        yield sample_model(place, name, case, count, seed, group, content)


def sample_model(
    where: str,
    name: str,
    case: Case,
    count: int,
    seed: int,
    group: Group = "geared",
    content: Content | None = None,
) -> SampledArm:
    """A model of an arm at random states."""
    entry, setting = MODELS[name], make_setting(name, case, count, seed)
    known = entry.promises, entry.order, entry.free_planets, partial(is_covering, name)
    forms = (mass_matrix, bias) if name in FORMS else ()
    symbols = [SymbolicEvaluation(name, setting, each) for each in forms]
    evaluate = partial(Evaluation, name)
    return SampledArm(where, name, setting, evaluate, *known, group, content or {}, symbols)


def compute_entry_differences(
    arm: Arm, sampled_models: Iterable[SampledArm], results: Results
) -> Iterator[EntryDifferences]:
    """The paper's forms and the reference model beside the engines, from what was answered.

    A model or an engine without usable answers is left out: its own comparisons fail.
    """
    models = [each for each in sampled_models if each.where == f"{arm.name}/geared"]
    geared = [each for each in models if each.group == "geared"]
    for sampled in (*models[len(geared) :], geared[0]):
        others = (each for each in geared if engine_of(each.model) != engine_of(sampled.model))
        engines = [replace(each, setting=sampled.setting) for each in others]
        for question in (mass_matrix, bias, generalized_force):
            yield from compare_entries(question, sampled, engines, results)


def switch_combinations() -> list[Switches]:
    """The sixteen combinations of the paper's four switches, and those that others change."""
    fields = ("phase", "ring_rate", "dead_zone", "damping")
    values = (("angle", "omega_t"), ("eq13", "corrected"), ("exact", "tanh"), ("always", "contact"))
    papers = [dict(zip(fields, chosen, strict=True)) for chosen in product(*values)]
    single = [{**each, "planets": "free"} for each in papers if each["ring_rate"] == "corrected"]
    smooth = {"phase": "angle", "dead_zone": "exact"}
    conserving = [each for each in (*papers, *single) if each.items() >= smooth.items()]
    springs = [{**each, "mesh_work": "conservative"} for each in conserving]
    return [switches(**chosen) for chosen in (*papers, *single, *springs)]


def describe_quick_limits(request: plan.CrossCheckRequest) -> str:
    """Sentences on what a quick cross-check of an arm leaves out."""
    runs = f"at most {plan.QUICK_STEPS:,} steps of each experiment are simulated"
    if request.has_fixed_steps:
        full = plan.FULL_S
        short = (f"{part:g} of {full[name]:g} s of {name}" for name, part in plan.QUICK_S.items())
        runs = f"{' and '.join(short)} are simulated"
    elif request.needs_sizes:
        runs = f"{runs}; a full cross-check takes up to {plan.FULL_STEPS:,}"
    return (
        f"With --quick {runs}. Models are compared at {QUICK_COUNT} random states, where a full"
        f" cross-check takes {COUNT}. What happens later in the runs is not judged."
    )

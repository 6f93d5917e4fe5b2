"""Every comparison that needs no run: states, modes, invariants."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import combinations, product
from typing import Any, NamedTuple

import numpy as np

from crosscheck.checks import arm_data, energy, invariants, scales, states
from crosscheck.checks.answers import ABILITIES, CHRISTOFFEL, CORNER_FORCE, sample_states
from crosscheck.checks.first_principles.composite import Content
from crosscheck.findings import (
    SYMBOLS,
    ComparisonKey,
    EntryDifferences,
    Finding,
    Subject,
    make_check,
    make_failed_check,
)
from crosscheck.models.arm.arm import Arm
from crosscheck.models.arm.meshes import replace_damping
from crosscheck.models.arm.planets import usual_switches
from crosscheck.models.experiment.scenario import Switches, switches
from crosscheck.models.files import read_raw_arm
from crosscheck.models.interface import STATE_ABILITIES
from crosscheck.models.loading import Case, load_arm
from crosscheck.planning.comparison import (
    Comparison,
    Results,
    get_answers,
    make_comparison,
    summarise_entries,
)
from crosscheck.planning.mode_suite import geared_models, plan_linear_comparisons
from crosscheck.planning.sizing import make_unequal_gains_scenario
from crosscheck.registry import (
    MODELS,
    find_covering_models,
    find_distinct_levels,
    find_level_models,
    reference_model,
    select_covering,
    select_other_engines,
)
from crosscheck.runner.outcomes import SelfKeyedTask, return_failures
from crosscheck.runner.tasks import Evaluation

COUNT, QUICK_COUNT = 200, 20
# Per switch setting; M and bias know no switch, so they are compared under one setting alone.
SWITCH_COUNT, SWITCHED = 20, ("generalized_force", "acceleration")
FORMS = "analytic:energies", "analytic:printed"  # forms whose symbols are available
DIFFERENCE, FIRST_PRINCIPLES = "largest relative difference", "first principles"


def plan_state_comparisons(
    arm: Arm, quick: bool, seed: int, content: Content | None = None
) -> list[Comparison]:
    """All comparisons of one arm that need no run.

    content: what the arm's file holds; its own fields where there is none.
    """
    count, content = QUICK_COUNT if quick else COUNT, content or arm.model_dump()
    comparisons = [
        *plan_geared_comparisons(arm, count, seed, content),
        *plan_rigid_comparisons(arm, count, seed, content),
    ]
    if not scales.geared_joints(arm):
        return comparisons
    if usual_switches(arm).planets == "lumped":
        comparisons += plan_free_comparisons(arm, min(count, SWITCH_COUNT), seed, content)
    return [*comparisons, *plan_conservative_comparisons(arm, min(count, SWITCH_COUNT), seed)]


def plan_probe_comparisons(arm: Arm, quick: bool, seed: int) -> list[Comparison]:
    """Comparisons of the probe arm, of unequal numbers, that need no run; and of the switches."""
    probe = load_arm("probe")
    if arm == probe:
        return [] if quick else list(plan_switch_comparisons(probe, seed))
    if arm.name == probe.name:  # a user's own of that name
        probe = probe.model_copy(update={"name": "built-in-probe"})
    comparisons = plan_state_comparisons(probe, quick, seed, read_raw_arm("probe"))
    return comparisons if quick else [*comparisons, *plan_switch_comparisons(probe, seed)]


def plan_rigid_comparisons(
    arm: Arm, count: int, seed: int, content: Content
) -> Iterator[Comparison]:
    """Comparisons of the rigid levels' states, analytic against Pinocchio; and their invariants."""
    for level in find_distinct_levels(arm):
        where, case = f"{arm.name}/{level}", _case(arm, usual_switches(arm))
        able = select_covering(find_level_models(level), arm, case.switches)
        sampled_models = [SampledModel(where, name, case, count, seed) for name in able]
        for sampled in sampled_models:
            yield from _plan_self_checks(sampled)
            yield from _plan_data_checks(sampled, content)
        yield from plan_pairs(sampled_models, STATE_ABILITIES)


def plan_switch_comparisons(arm: Arm, seed: int) -> Iterator[Comparison]:
    """Comparisons of the geared models' forces and accelerations under all switch settings."""
    for chosen in switch_combinations():
        # The paper's own way with planets and springs goes without saying.
        laws: list[str] = [chosen.phase, chosen.ring_rate, chosen.dead_zone, chosen.damping]
        laws += ["free"] if chosen.planets == "free" else []
        laws += ["conservative"] if chosen.mesh_work == "conservative" else []
        where, case = f"{arm.name}/{'-'.join(laws)}", _case(arm, chosen)
        sampled_models = [
            SampledModel(where, name, case, SWITCH_COUNT, seed) for name in geared_models(case)
        ]
        yield from plan_pairs(sampled_models, SWITCHED)
        yield from plan_corners(sampled_models)


def plan_geared_comparisons(
    arm: Arm, count: int, seed: int, content: Content
) -> Iterator[Comparison]:
    """Comparisons of the geared models' states, balances and modes, and with the paper's forms."""
    where, chosen = f"{arm.name}/geared", usual_switches(arm)
    case = _case(arm, chosen)
    sampled_models = [SampledModel(where, name, case, count, seed) for name in geared_models(case)]
    yield from _plan_model_states(sampled_models, content)
    for sampled in sampled_models:
        if "constraint_residual" in MODELS[sampled.model].promises:
            metric = (
                f"largest gap, rate, acceleration or error of one, {sampled.number} random states"
            )
            about = sampled.invariant_subject("constraints", metric, "closure of its joints")
            yield make_comparison(
                about, (sampled.of("constraint_residual"),), invariants.check_constraints
            )
    yield from plan_linear_comparisons(arm.name, arm, chosen)
    yield from _plan_forms(
        [sampled for sampled in sampled_models if sampled.model != reference_model()]
    )
    for form in find_covering_models("form", arm, switches()):
        yield from _plan_form(
            SampledModel(where, form, _case(arm, switches()), count, seed), content
        )


def plan_free_comparisons(
    arm: Arm, count: int, seed: int, content: Content
) -> Iterator[Comparison]:
    """Comparisons with a coordinate for every planet, of an arm whose planets may be lumped."""
    where, chosen = f"{arm.name}/free", usual_switches(arm, planets="free")
    case = _case(arm, chosen)
    sampled_models = [SampledModel(where, name, case, count, seed) for name in geared_models(case)]
    yield from _plan_model_states(sampled_models, content)
    yield from plan_linear_comparisons(where, arm, chosen)


def plan_conservative_comparisons(arm: Arm, count: int, seed: int) -> Iterator[Comparison]:
    """Comparisons of free planets whose springs are a potential: forces, energy that closes.

    The meshes are undamped, so that all but drive, friction and weight is a function of state.
    """
    if not scales.geared_joints(arm):
        return
    chosen = usual_switches(arm, planets="free", mesh_work="conservative")
    where, case = f"{arm.name}/conservative", _case(replace_damping(arm, 0.0), chosen)
    sampled_models = [SampledModel(where, name, case, count, seed) for name in geared_models(case)]
    yield from plan_pairs(sampled_models, SWITCHED)
    yield from plan_corners(sampled_models)
    for sampled in sampled_models:
        yield plan_balance(sampled, "energy-rate", "W", energy.check_energy_rate)


def _plan_model_states(
    sampled_models: Sequence[SampledModel], content: Content
) -> Iterator[Comparison]:
    yield from plan_pairs(sampled_models, STATE_ABILITIES)
    yield from plan_corners(sampled_models)
    for sampled in sampled_models:
        yield from _plan_self_checks(sampled)
        yield from _plan_data_checks(sampled, content)
        yield from plan_balances(sampled)


class SampledModel(NamedTuple):
    """A model at random states: the evaluations that comparisons of it ask for."""

    where: str
    model: str
    case: Case
    number: int
    seed: int

    def of(self, quantity: str) -> Evaluation:
        """The evaluation of a quantity."""
        return Evaluation(self.model, self.case, quantity, self.number, self.seed)

    @property
    def setting(self) -> states.Setting:
        """The arm, the model's coordinates and its random states."""
        arm = self.case.arm
        layout = MODELS[self.model].layout(arm, self.case.switches)
        drawn = sample_states(layout, arm, self.number, self.seed)
        return states.Setting(arm, layout, drawn)

    def over(self, size: str) -> str:
        """The words of a metric: a size over these random states."""
        return f"{size} over {self.number} random states"

    def invariant_subject(
        self, quantity: str, metric: str, against: str, unit: str = "1"
    ) -> Subject:
        """The About of a check of this model alone."""
        return Subject(
            ComparisonKey("invariants", self.where, quantity, self.model), unit, metric, against
        )

    def arm_data_subject(self, quantity: str) -> Subject:
        """The About of a check of this model against the arm's data."""
        key = ComparisonKey("as-told", self.where, quantity, self.model)
        return Subject(key, "1", self.over(DIFFERENCE), "the arm's data")


@dataclass(frozen=True)
class SymbolicEvaluation(SelfKeyedTask):
    """A task: work out a form of the paper in symbols, at the states that its model answers."""

    sampled: SampledModel
    quantity: str
    cost = 1.0  # rough seconds

    @property
    def model(self) -> str:
        """Name of what answers: the model's symbols."""
        return f"{self.sampled.model} in symbols"

    @return_failures
    def perform(self) -> np.ndarray:
        """M (count, n, n) or the bias (count, n), or why there is none."""
        import sympy as sp  # half a second, for this alone

        from crosscheck.analytic.derivation.symbols import parameter_values
        from crosscheck.analytic.paper.energies import build_energies_form
        from crosscheck.analytic.paper.printed import build_printed_form

        forms = dict(zip(FORMS, (build_energies_form, build_printed_form), strict=True))
        form, (arm, _, drawn) = forms[self.sampled.model](), self.sampled.setting
        numbers = {s: sp.Float(float(x), 17) for s, x in parameter_values(arm).items()}
        entries = getattr(form, self.quantity).xreplace(numbers)
        evaluate = sp.lambdify((form.q, form.v), entries, "numpy")
        values = [np.array(evaluate(q, v), dtype=float) for _, q, v in zip(*drawn, strict=True)]
        return np.array([v[:, 0] if v.shape[1] == 1 else v for v in values])


def plan_pairs(
    sampled_models: Sequence[SampledModel], quantities: Sequence[str]
) -> Iterator[Comparison]:
    """A comparison for each quantity and pair of models, whose coordinates must be the same."""
    for quantity in quantities:
        for left, right in combinations(sampled_models, 2):
            yield _plan_pair("states", quantity, left, right, states.compare_values)


def plan_corners(sampled_models: Sequence[SampledModel]) -> Iterator[Comparison]:
    """A comparison for each pair of geared models, on each side of every branch of a mesh law."""
    for left, right in combinations(sampled_models, 2):
        if left.setting.layout.mesh_joints:
            yield _plan_corner_pair(left, right)


def _plan_corner_pair(left: SampledModel, right: SampledModel) -> Comparison:
    def judge(about: Subject, results: Results) -> Finding:
        corners = tuple(results.need(each.of(CORNER_FORCE)) for each in (left, right))
        force, masses = (
            results.need(left.of(name)) for name in ("generalized_force", "mass_matrix")
        )
        return states.compare_corner_forces(about, corners, force, masses, left.setting)

    key = ComparisonKey("states", left.where, CORNER_FORCE, left.model, right.model)
    metric = f"{DIFFERENCE} on each side of every branch of the mesh laws"
    needs = [each.of(CORNER_FORCE) for each in (left, right)]
    needs += [left.of(name) for name in ("generalized_force", "mass_matrix")]
    return Comparison(Subject(key, "1", metric), tuple(needs), judge)


def compute_entry_differences(
    arm: Arm, quick: bool, seed: int, results: Results
) -> Iterator[EntryDifferences]:
    """The paper's forms and the reference model beside the engines, from what was answered.

    A model or an engine without usable answers is left out: its own comparisons fail.
    """
    count, where = QUICK_COUNT if quick else COUNT, f"{arm.name}/geared"
    papers, usual = _case(arm, switches()), _case(arm, usual_switches(arm))
    forms = [(name, papers) for name in find_covering_models("form", arm, papers.switches)]
    for model, case in (*forms, (reference_model(), usual)):
        sampled = SampledModel(where, model, case, count, seed)
        engines = [
            sampled._replace(model=name)
            for name in select_other_engines(model, geared_models(case))
        ]
        for quantity in SYMBOLS:
            yield from _compare_entries(quantity, sampled, engines, results)


def _compare_entries(
    quantity: str, sampled: SampledModel, engines: Sequence[SampledModel], results: Results
) -> Iterator[EntryDifferences]:
    """The differences of one quantity, if the model and an engine have answered."""
    values, mass = results.get(sampled.of(quantity)), results.get(sampled.of("mass_matrix"))
    answers = get_answers(results, [engine.of(quantity) for engine in engines])
    if values is None or mass is None or not answers or not states.is_usable(mass[0]):
        return
    setting = sampled.setting
    compared = {
        name: states.relative_differences(quantity, values, answer, mass, setting)
        for name, answer in answers.items()
    }
    tolerance = next(iter(compared.values())).limit.value
    differences = {name: each.values for name, each in compared.items()}
    names = setting.layout.names
    yield summarise_entries(quantity, sampled.model, names, differences, tolerance)


def _plan_forms(sampled_models: Sequence[SampledModel]) -> Iterator[Comparison]:
    """Measurements of how far each of the paper's own forms is from each engine."""
    for other in sampled_models:
        for form in find_covering_models("form", other.case.arm, other.case.switches):
            right = other._replace(case=_case(other.case.arm, switches()))
            for quantity in STATE_ABILITIES:
                left = right._replace(model=form)
                yield _plan_pair("form-states", quantity, left, right, states.measure_values)


def _plan_form(sampled: SampledModel, content: Content) -> Iterator[Comparison]:
    """Comparisons of a form of the paper with itself, with the arm's file and with its symbols.

    The form's inertia is none of real bodies; that it is what the paper has, its symbols say.
    """
    yield from _plan_self_checks(sampled)
    yield from plan_balances(sampled)
    yield from _plan_data_checks(sampled, content, inertia=False)

    def compare_symbols(about: Subject, values: Any, stated: Any, mass: Any) -> Finding:
        return states.compare_values(about, stated, values, mass, sampled.setting)

    for quantity in ("mass_matrix", "bias") if sampled.model in FORMS else ():
        symbols = SymbolicEvaluation(sampled, quantity)
        key = ComparisonKey("form-symbols", sampled.where, quantity, sampled.model)
        about = Subject(key, "1", sampled.over(DIFFERENCE), "its equations in symbols")
        yield make_comparison(
            about, (sampled.of(quantity), symbols, sampled.of("mass_matrix")), compare_symbols
        )


def _plan_pair(
    family: str, quantity: str, left: SampledModel, right: SampledModel, judge: states.Judge
) -> Comparison:
    key = ComparisonKey(family, left.where, quantity, left.model, right.model)
    needs = [sampled.of(name) for name in ("mass_matrix", quantity) for sampled in (left, right)]

    def judge_results(about: Subject, results: Results) -> Finding:
        left_values, right_values = (
            results.need(sampled.of(quantity)) for sampled in (left, right)
        )
        masses = (results.get_if_finished(sampled.of("mass_matrix")) for sampled in (left, right))
        sizes = (m for m in masses if m is not None and states.is_usable(m[0]))
        return judge(about, left_values, right_values, next(sizes, None), left.setting)

    return Comparison(Subject(key, "1", left.over(DIFFERENCE)), tuple(needs), judge_results)


def _plan_self_checks(sampled: SampledModel) -> Iterator[Comparison]:
    """Comparisons of one model with itself: inertia, bias and abilities.

    A model must say of itself all that the registry says of it, for users ask the model.
    """
    mass, bias, symbols = (sampled.of(name) for name in ("mass_matrix", "bias", CHRISTOFFEL))
    metric = f"{sampled.over('largest relative asymmetry')}; positive definite"
    about = sampled.invariant_subject("inertia", metric, FIRST_PRINCIPLES)
    yield make_comparison(about, (mass,), invariants.check_inertia)
    against = "Christoffel symbols of its own mass matrix"
    about = sampled.invariant_subject("bias-from-inertia", sampled.over(DIFFERENCE), against)
    follows = partial(invariants.check_bias, setting=sampled.setting)
    yield make_comparison(about, (bias, symbols, mass), follows)
    about = sampled.invariant_subject("abilities", "abilities missing", "declared capabilities")
    task = Evaluation(sampled.model, sampled.case, ABILITIES)
    yield make_comparison(
        about, (task,), partial(_check_abilities, promised=MODELS[sampled.model].promises)
    )


def _check_abilities(about: Subject, claimed: Any, promised: frozenset[str]) -> Finding:
    lacking = sorted(promised - set(claimed.tolist()))
    if lacking:
        return make_failed_check(about, f"the model does not claim to have {', '.join(lacking)}")
    return make_check(about, measured=0.0, tolerance=0.0, basis="every promised ability is there")


def _plan_data_checks(
    sampled: SampledModel, content: Content, *, inertia: bool = True
) -> Iterator[Comparison]:
    """Comparisons of a model's forces, and inertia too, with the data of arm and experiment."""
    level, setting = MODELS[sampled.model].level, sampled.setting
    given: dict[str, Any] = {"setting": setting, "content": content, "level": level}
    mass, force = sampled.of("mass_matrix"), sampled.of("generalized_force")
    if inertia:
        yield make_comparison(
            sampled.arm_data_subject("mass_matrix"),
            (mass,),
            partial(arm_data.check_inertia_against_data, **given),
        )
    judged = partial(arm_data.check_force_against_data, case=sampled.case, **given)
    yield make_comparison(sampled.arm_data_subject("generalized_force"), (force, mass), judged)


def plan_balances(sampled: SampledModel) -> Iterator[Comparison]:
    """Comparisons of power and angular momentum, from all that the model says of a state."""
    yield plan_balance(sampled, "power", "W", invariants.check_power_balance)
    yield plan_balance(sampled, "angular-momentum-rate", "N m", invariants.check_angular_momentum)


def plan_balance(
    sampled: SampledModel, name: str, unit: str, law: invariants.Balance
) -> Comparison:
    """The comparison of one balance of a model."""

    def judge_balance(about: Subject, *answers: Any) -> Finding:
        return law(about, invariants.StateValues(*answers), sampled.setting, sampled.case)

    about = sampled.invariant_subject(
        name, sampled.over("largest residual"), FIRST_PRINCIPLES, unit
    )
    return make_comparison(
        about, [sampled.of(quantity) for quantity in STATE_ABILITIES], judge_balance
    )


def switch_combinations() -> list[Switches]:
    """The sixteen combinations of the paper's four switches, and those that others change."""
    fields = ("phase", "ring_rate", "dead_zone", "damping")
    values = (("angle", "omega_t"), ("eq13", "corrected"), ("exact", "tanh"), ("always", "contact"))
    papers: list[dict[str, str]] = [
        dict(zip(fields, chosen, strict=True)) for chosen in product(*values)
    ]
    single = [{**each, "planets": "free"} for each in papers if each["ring_rate"] == "corrected"]
    springs = [
        {**each, "mesh_work": "conservative"}
        for each in (*papers, *single)
        if (each["phase"], each["dead_zone"]) == ("angle", "exact")
    ]
    return [switches(**chosen) for chosen in (*papers, *single, *springs)]


def _case(arm: Arm, chosen: Switches) -> Case:
    return Case(arm, make_unequal_gains_scenario(arm), chosen)

"""Every comparison that needs no run: states, modes, invariants."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import combinations, product
from typing import Any, NamedTuple

import numpy as np

from crosscheck.checks import energy, invariants, scales, states, told
from crosscheck.checks.answers import ABILITIES, CHRISTOFFEL, random_states
from crosscheck.checks.first_principles.composite import Content
from crosscheck.findings import SYMBOLS, About, EntryDifferences, Finding, Key, checked, failed
from crosscheck.models.arm.arm import Arm
from crosscheck.models.arm.meshes import damped
from crosscheck.models.arm.planets import usual_switches
from crosscheck.models.experiment.scenario import Switches, switches
from crosscheck.models.files import raw_arm
from crosscheck.models.interface import STATE_ABILITIES
from crosscheck.models.loading import Case, load_arm
from crosscheck.planning.comparison import Comparison, Results, answered
from crosscheck.planning.mode_suite import geared_models, linearised
from crosscheck.planning.sizing import unequal_gains
from crosscheck.registry import (
    MODELS,
    RIGID_LEVELS,
    about,
    covering,
    engines_beside,
    of_level,
    reference_model,
)
from crosscheck.runner.outcomes import OwnKey, or_failure
from crosscheck.runner.tasks import Evaluation

COUNT, QUICK_COUNT = 200, 20
# Per switch setting; M and bias know no switch, so they are compared under one setting alone.
SWITCH_COUNT, SWITCHED = 20, ("generalized_force", "acceleration")
FORMS = "analytic:energies", "analytic:printed"  # whose symbols are at hand
DIFFERENCE, FIRST_PRINCIPLES = "largest relative difference", "first principles"


def state_comparisons(
    arm: Arm, quick: bool, seed: int, content: Content | None = None
) -> list[Comparison]:
    """All comparisons of one arm that need no run.

    content: what the arm's file holds; its own fields where there is none.
    """
    count, content = QUICK_COUNT if quick else COUNT, content or arm.model_dump()
    found = [*geared(arm, count, seed, content), *rigid(arm, count, seed, content)]
    if not scales.geared(arm):
        return found
    if usual_switches(arm).planets == "lumped":
        found += free(arm, min(count, SWITCH_COUNT), seed, content)
    return [*found, *conservative(arm, min(count, SWITCH_COUNT), seed)]


def probe_comparisons(arm: Arm, quick: bool, seed: int) -> list[Comparison]:
    """Comparisons of the probe arm, of unequal numbers, that need no run; and of the switches."""
    probe = load_arm("probe")
    if arm == probe:
        return [] if quick else list(switched(probe, seed))
    if arm.name == probe.name:  # a user's own of that name
        probe = probe.model_copy(update={"name": "built-in-probe"})
    own = state_comparisons(probe, quick, seed, raw_arm("probe"))
    return own if quick else [*own, *switched(probe, seed)]


def rigid(arm: Arm, count: int, seed: int, content: Content) -> Iterator[Comparison]:
    """Comparisons of the rigid levels' states, analytic against Pinocchio; and their invariants."""
    for level in RIGID_LEVELS:
        where, case = f"{arm.name}/{level}", _case(arm, usual_switches(arm))
        able = about(of_level(level), arm, case.switches)
        sampled_models = [SampledModel(where, name, case, count, seed) for name in able]
        for sampled in sampled_models:
            yield from _own(sampled)
            yield from _as_told(sampled, content)
        yield from pairs(sampled_models, STATE_ABILITIES)


def switched(arm: Arm, seed: int) -> Iterator[Comparison]:
    """Comparisons of the geared models' forces and accelerations under all switch settings."""
    for chosen in all_switches():
        # The paper's own way with planets and springs goes without saying.
        laws: list[str] = [chosen.phase, chosen.ring_rate, chosen.dead_zone, chosen.damping]
        laws += ["free"] if chosen.planets == "free" else []
        laws += ["conservative"] if chosen.mesh_work == "conservative" else []
        where, case = f"{arm.name}/{'-'.join(laws)}", _case(arm, chosen)
        sampled_models = [
            SampledModel(where, name, case, SWITCH_COUNT, seed) for name in geared_models(case)
        ]
        yield from pairs(sampled_models, SWITCHED)


def geared(arm: Arm, count: int, seed: int, content: Content) -> Iterator[Comparison]:
    """Comparisons of the geared models' states, balances and modes, and with the paper's forms."""
    where, chosen = f"{arm.name}/geared", usual_switches(arm)
    case = _case(arm, chosen)
    sampled_models = [SampledModel(where, name, case, count, seed) for name in geared_models(case)]
    yield from _of_states(sampled_models, content)
    for sampled in sampled_models:
        if "constraint_residual" in MODELS[sampled.model].promises:
            metric = (
                f"largest gap, rate, acceleration or error of one, {sampled.number} random states"
            )
            about = sampled.own("constraints", metric, "closure of its joints")
            yield answered(about, (sampled.of("constraint_residual"),), invariants.constraints)
    yield from linearised(arm.name, arm, chosen)
    yield from _forms([sampled for sampled in sampled_models if sampled.model != reference_model()])
    for form in covering("form", arm, switches()):
        yield from _of_form(SampledModel(where, form, _case(arm, switches()), count, seed), content)


def free(arm: Arm, count: int, seed: int, content: Content) -> Iterator[Comparison]:
    """Comparisons with a coordinate for every planet, of an arm whose planets may be lumped."""
    where, chosen = f"{arm.name}/free", usual_switches(arm, planets="free")
    case = _case(arm, chosen)
    sampled_models = [SampledModel(where, name, case, count, seed) for name in geared_models(case)]
    yield from _of_states(sampled_models, content)
    yield from linearised(where, arm, chosen)


def conservative(arm: Arm, count: int, seed: int) -> Iterator[Comparison]:
    """Comparisons of free planets whose springs are a potential: forces, energy that closes.

    The meshes are undamped, so that all but drive, friction and weight is a function of state.
    """
    if not scales.geared(arm):
        return
    chosen = usual_switches(arm, planets="free", mesh_work="conservative")
    where, case = f"{arm.name}/conservative", _case(damped(arm, 0.0), chosen)
    sampled_models = [SampledModel(where, name, case, count, seed) for name in geared_models(case)]
    yield from pairs(sampled_models, SWITCHED)
    for sampled in sampled_models:
        yield balance(sampled, "energy-rate", "W", energy.rate_closes)


def _of_states(sampled_models: Sequence[SampledModel], content: Content) -> Iterator[Comparison]:
    yield from pairs(sampled_models, STATE_ABILITIES)
    for sampled in sampled_models:
        yield from _own(sampled)
        yield from _as_told(sampled, content)
        yield from balances(sampled)


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
        drawn = random_states(layout, arm, self.number, self.seed)
        return states.Setting(arm, layout, drawn)

    def over(self, size: str) -> str:
        """The words of a metric: a size over these random states."""
        return f"{size} over {self.number} random states"

    def own(self, quantity: str, metric: str, against: str, unit: str = "1") -> About:
        """The About of a check of this model alone."""
        return About(Key("invariants", self.where, quantity, self.model), unit, metric, against)

    def told(self, quantity: str) -> About:
        """The About of a check of this model against the arm's data."""
        key = Key("as-told", self.where, quantity, self.model)
        return About(key, "1", self.over(DIFFERENCE), "the arm's data")


@dataclass(frozen=True)
class Stated(OwnKey):
    """A task: work out a form of the paper in symbols, at the states that its model answers."""

    sampled: SampledModel
    quantity: str
    cost = 1.0  # rough seconds

    @property
    def model(self) -> str:
        """Name of what answers: the model's symbols."""
        return f"{self.sampled.model} in symbols"

    @or_failure
    def perform(self) -> np.ndarray:
        """M (count, n, n) or the bias (count, n), or why there is none."""
        import sympy as sp  # half a second, for this alone

        from crosscheck.analytic.derivation.symbols import parameter_values
        from crosscheck.analytic.paper.energies import energies_form
        from crosscheck.analytic.paper.printed import printed_form

        forms = dict(zip(FORMS, (energies_form, printed_form), strict=True))
        form, (arm, _, drawn) = forms[self.sampled.model](), self.sampled.setting
        numbers = {s: sp.Float(float(x), 17) for s, x in parameter_values(arm).items()}
        entries = getattr(form, self.quantity).xreplace(numbers)
        evaluate = sp.lambdify((form.q, form.v), entries, "numpy")
        values = [np.array(evaluate(q, v), dtype=float) for _, q, v in zip(*drawn, strict=True)]
        return np.array([v[:, 0] if v.shape[1] == 1 else v for v in values])


def pairs(
    sampled_models: Sequence[SampledModel], quantities: Sequence[str]
) -> Iterator[Comparison]:
    """A comparison for each quantity and pair of models, whose coordinates must be the same."""
    for quantity in quantities:
        for left, right in combinations(sampled_models, 2):
            yield _pair("states", quantity, left, right, states.compare_values)


def entry_differences(
    arm: Arm, quick: bool, seed: int, results: Results
) -> Iterator[EntryDifferences]:
    """The paper's forms and the reference model beside the engines, from what was answered.

    A model or an engine without usable answers is left out: its own comparisons fail.
    """
    count, where = QUICK_COUNT if quick else COUNT, f"{arm.name}/geared"
    papers, usual = _case(arm, switches()), _case(arm, usual_switches(arm))
    forms = [(name, papers) for name in covering("form", arm, papers.switches)]
    for model, case in (*forms, (reference_model(), usual)):
        own = SampledModel(where, model, case, count, seed)
        engines = [own._replace(model=name) for name in engines_beside(model, geared_models(case))]
        for quantity in SYMBOLS:
            yield from _by_entry(quantity, own, engines, results)


def _by_entry(
    quantity: str, own: SampledModel, engines: Sequence[SampledModel], results: Results
) -> Iterator[EntryDifferences]:
    """The differences of one quantity, if the model and an engine have answered."""
    values, mass = results.found(own.of(quantity)), results.found(own.of("mass_matrix"))
    answers = {
        engine.model: answer
        for engine in engines
        if (answer := results.found(engine.of(quantity))) is not None
    }
    if values is None or mass is None or not answers or not states.usable(mass[0]):
        return
    setting = own.setting
    compared = [
        states.relative_differences(quantity, values, answer, mass, setting)
        for answer in answers.values()
    ]
    largest = np.max([each.values.max(axis=0) for each in compared], axis=0)
    largest = np.where(np.isnan(largest), np.inf, largest)
    rows = largest.reshape(len(setting.layout), -1).tolist()
    yield EntryDifferences(
        quantity,
        own.model,
        tuple(answers),
        tuple(setting.layout.names),
        tuple(map(tuple, rows)),
        compared[0].limit.value,
    )


def _forms(sampled_models: Sequence[SampledModel]) -> Iterator[Comparison]:
    """Measurements of how far each of the paper's own forms is from each engine."""
    for other in sampled_models:
        for form in covering("form", other.case.arm, other.case.switches):
            right = other._replace(case=_case(other.case.arm, switches()))
            for quantity in STATE_ABILITIES:
                left = right._replace(model=form)
                yield _pair("form-states", quantity, left, right, states.measure_values)


def _of_form(sampled: SampledModel, content: Content) -> Iterator[Comparison]:
    """Comparisons of a form of the paper with itself, with the arm's file and with its symbols.

    The form's inertia is none of real bodies; that it is what the paper has, its symbols say.
    """
    yield from _own(sampled)
    yield from balances(sampled)
    yield from _as_told(sampled, content, inertia=False)

    def as_stated(about: About, own: Any, stated: Any, mass: Any) -> Finding:
        return states.compare_values(about, stated, own, mass, sampled.setting)

    for quantity in ("mass_matrix", "bias") if sampled.model in FORMS else ():
        symbols = Stated(sampled, quantity)
        key = Key("form-symbols", sampled.where, quantity, sampled.model)
        about = About(key, "1", sampled.over(DIFFERENCE), "its equations in symbols")
        yield answered(about, (sampled.of(quantity), symbols, sampled.of("mass_matrix")), as_stated)


def _pair(
    family: str, quantity: str, left: SampledModel, right: SampledModel, judge: states.Judge
) -> Comparison:
    key = Key(family, left.where, quantity, left.model, right.model)
    needs = [sampled.of(name) for name in ("mass_matrix", quantity) for sampled in (left, right)]

    def judged(about: About, results: Results) -> Finding:
        one, other = (results.need(sampled.of(quantity)) for sampled in (left, right))
        masses = (results.settled(sampled.of("mass_matrix")) for sampled in (left, right))
        sizes = (m for m in masses if m is not None and states.usable(m[0]))
        return judge(about, one, other, next(sizes, None), left.setting)

    return Comparison(About(key, "1", left.over(DIFFERENCE)), tuple(needs), judged)


def _own(sampled: SampledModel) -> Iterator[Comparison]:
    """Comparisons of one model with itself: inertia, bias and abilities.

    A model must say of itself all that the registry says of it, for users ask the model.
    """
    mass, bias, symbols = (sampled.of(name) for name in ("mass_matrix", "bias", CHRISTOFFEL))
    metric = f"{sampled.over('largest relative asymmetry')}; positive definite"
    about = sampled.own("inertia", metric, FIRST_PRINCIPLES)
    yield answered(about, (mass,), invariants.is_inertia)
    against = "Christoffel symbols of its own mass matrix"
    about = sampled.own("bias-from-inertia", sampled.over(DIFFERENCE), against)
    follows = partial(invariants.bias_follows, setting=sampled.setting)
    yield answered(about, (bias, symbols, mass), follows)
    about = sampled.own("abilities", "abilities missing", "declared capabilities")
    task = Evaluation(sampled.model, sampled.case, ABILITIES)
    yield answered(about, (task,), partial(_claims_all, promised=MODELS[sampled.model].promises))


def _claims_all(about: About, claimed: Any, promised: frozenset[str]) -> Finding:
    lacking = sorted(promised - set(claimed.tolist()))
    if lacking:
        return failed(about, f"the model does not claim to have {', '.join(lacking)}")
    return checked(about, measured=0.0, tolerance=0.0, basis="every promised ability is there")


def _as_told(
    sampled: SampledModel, content: Content, *, inertia: bool = True
) -> Iterator[Comparison]:
    """Comparisons of a model's forces, and inertia too, with the data of arm and experiment."""
    level, setting = MODELS[sampled.model].level, sampled.setting
    given: dict[str, Any] = {"setting": setting, "content": content, "level": level}
    mass, force = sampled.of("mass_matrix"), sampled.of("generalized_force")
    if inertia:
        yield answered(sampled.told("mass_matrix"), (mass,), partial(told.inertia_as_told, **given))
    judged = partial(told.force_as_told, case=sampled.case, **given)
    yield answered(sampled.told("generalized_force"), (force, mass), judged)


def balances(sampled: SampledModel) -> Iterator[Comparison]:
    """Comparisons of power and angular momentum, from all that the model says of a state."""
    yield balance(sampled, "power", "W", invariants.power)
    yield balance(sampled, "angular-momentum-rate", "N m", invariants.angular_momentum)


def balance(sampled: SampledModel, name: str, unit: str, law: invariants.Balance) -> Comparison:
    """The comparison of one balance of a model."""

    def judged(about: About, *answers: Any) -> Finding:
        return law(about, invariants.Answered(*answers), sampled.setting, sampled.case)

    about = sampled.own(name, sampled.over("largest residual"), FIRST_PRINCIPLES, unit)
    return answered(about, [sampled.of(quantity) for quantity in STATE_ABILITIES], judged)


def all_switches() -> list[Switches]:
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
    return Case(arm, unequal_gains(arm), chosen)

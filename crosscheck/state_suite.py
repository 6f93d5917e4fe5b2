"""Every comparison that needs no run: states, modes, invariants."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial
from itertools import combinations, product

import numpy as np

from crosscheck.checks import energy, invariants, modes, poles, scales, states
from crosscheck.checks.answers import (
    ABILITIES,
    CHRISTOFFEL,
    FORCE_SLOPES,
    START_MASS,
    random_states,
)
from crosscheck.comparison import Comparison, Results, Unavailable
from crosscheck.findings import About, Finding, Key, checked, failed
from crosscheck.registry import (
    MODELS,
    RIGID_LEVELS,
    about,
    covering,
    lead,
    of_level,
    promising,
)
from crosscheck.tasks import Evaluation
from models.arm import Arm
from models.interface import STATE_ABILITIES
from models.loading import Case, load_arm, load_scenario
from models.meshes import damped
from models.planets import usual_switches
from models.scenario import PdDrive, Scenario, Start
from models.switches import Switches, switches

COUNT, QUICK_COUNT = 200, 20
# Per switch setting; M and bias know no switch, so they are compared under one setting alone.
SWITCH_COUNT, SWITCHED = 20, ("generalized_force", "acceleration")
FORM_QUANTITIES = STATE_ABILITIES


def state_comparisons(arm: Arm, quick: bool, seed: int) -> list[Comparison]:
    """Everything about one arm that needs no run."""
    count = QUICK_COUNT if quick else COUNT
    found = [*geared(arm, count, seed), *rigid(arm, count, seed)]
    if not scales.geared(arm):
        return found
    if usual_switches(arm).planets == "lumped":
        found += free(arm, min(count, SWITCH_COUNT), seed)
    return [*found, *conservative(arm, min(count, SWITCH_COUNT), seed)]


def probe_comparisons(arm: Arm, quick: bool, seed: int) -> list[Comparison]:
    """The same on the arm of unequal numbers, which tells parameters apart; and the switches."""
    probe = load_arm("probe")
    if arm == probe:
        return [] if quick else list(switched(probe, seed))
    if arm.name == probe.name:  # a user's own of that name
        probe = probe.model_copy(update={"name": "built-in-probe"})
    own = state_comparisons(probe, quick, seed)
    return own if quick else [*own, *switched(probe, seed)]


def rigid(arm: Arm, count: int, seed: int) -> Iterator[Comparison]:
    """States of the rigid levels, analytic against Pinocchio; each level's own invariants."""
    for level in RIGID_LEVELS:
        where, case = f"{arm.name}/{level}", _case(arm, usual_switches(arm))
        able = about(of_level(level), arm, case.switches)
        spots = [Spot(where, name, case, count, seed) for name in able]
        for spot in spots:
            yield from _own(spot)
        yield from pairs(spots, STATE_ABILITIES)


def switched(arm: Arm, seed: int) -> Iterator[Comparison]:
    """Forces and accelerations of the geared models under every setting of the switches."""
    for chosen in all_switches():
        where, case = f"{arm.name}/{_label(chosen)}", Case(arm, unequal_gains(arm), chosen)
        spots = [Spot(where, name, case, SWITCH_COUNT, seed) for name in _geared(case)]
        yield from pairs(spots, SWITCHED)


def geared(arm: Arm, count: int, seed: int) -> Iterator[Comparison]:
    """States, balances and modes of the geared models, and what the paper's forms differ by."""
    where, chosen = f"{arm.name}/geared", usual_switches(arm)
    case = _case(arm, chosen)
    spots = [Spot(where, name, case, count, seed) for name in _geared(case)]
    yield from _of_states(spots)
    yield from _closed_joints(spots)
    yield from _linearised(arm.name, arm, chosen)
    yield from _forms([spot for spot in spots if spot.model != lead()])


def free(arm: Arm, count: int, seed: int) -> Iterator[Comparison]:
    """The same with a coordinate for every planet, of an arm whose planets may be lumped."""
    where, chosen = f"{arm.name}/free", usual_switches(arm, planets="free")
    case = _case(arm, chosen)
    spots = [Spot(where, name, case, count, seed) for name in _geared(case)]
    yield from _of_states(spots)
    yield from _linearised(where, arm, chosen)


def conservative(arm: Arm, count: int, seed: int) -> Iterator[Comparison]:
    """Free planets whose springs are a potential: forces, and energy that closes.

    The meshes are undamped, so that all but drive, friction and weight is a function of state.
    """
    if not scales.geared(arm):
        return
    chosen = usual_switches(arm, planets="free", mesh_work="conservative")
    where, case = f"{arm.name}/conservative", _case(damped(arm, 0.0), chosen)
    spots = [Spot(where, name, case, count, seed) for name in _geared(case)]
    yield from pairs(spots, SWITCHED)
    for spot in spots:
        yield balance(spot, "energy-rate", "W", energy.rate_closes)


def _of_states(spots: Sequence[Spot]) -> Iterator[Comparison]:
    yield from pairs(spots, STATE_ABILITIES)
    for spot in spots:
        yield from _own(spot)
        yield from balances(spot)


def _linearised(where: str, arm: Arm, chosen: Switches) -> Iterator[Comparison]:
    """Modes and poles with the teeth in contact."""
    yield from mode_comparisons(where, arm, chosen)
    yield from pole_comparisons(where, arm, chosen)
    yield from _locked_stages(where, arm, chosen)


class Spot:
    """A model at random states: the evaluations that comparisons of it ask for."""

    def __init__(self, where: str, model: str, case: Case, count: int, seed: int) -> None:
        self.where, self.model, self.case = where, model, case
        self.count, self.seed = count, seed

    def of(self, quantity: str) -> Evaluation:
        """The evaluation of a quantity."""
        return Evaluation(self.model, self.case, quantity, self.count, self.seed)

    @property
    def setting(self) -> states.Setting:
        """The states themselves."""
        arm = self.case.arm
        layout = MODELS[self.model].layout(arm, self.case.switches)
        drawn = random_states(layout, arm, self.count, self.seed)
        return states.Setting(arm, layout, drawn)


def pairs(spots: Sequence[Spot], quantities: Sequence[str]) -> Iterator[Comparison]:
    """A comparison per quantity and pair of models; their coordinates are the same."""
    for quantity in quantities:
        for left, right in combinations(spots, 2):
            yield _pair("states", quantity, left, right, states.compare_values)


def _forms(spots: Sequence[Spot]) -> Iterator[Comparison]:
    """How far each of the paper's own forms is from each engine."""
    for other in spots:
        for form in covering("form", other.case.arm, other.case.switches):
            case = Case(other.case.arm, load_scenario("pd"), switches())
            left = Spot(other.where, form, case, other.count, other.seed)
            right = Spot(other.where, other.model, case, other.count, other.seed)
            for quantity in FORM_QUANTITIES:
                yield _pair("form-states", quantity, left, right, states.measure_values)


def _pair(family: str, quantity: str, left: Spot, right: Spot, judge: states.Judge) -> Comparison:
    key = Key(family, left.where, quantity, left.model, right.model)
    metric = f"largest relative difference over {left.count} random states"
    needs = [spot.of(name) for name in ("mass_matrix", quantity) for spot in (left, right)]

    def judged(about: About, results: Results) -> Finding:
        one, other = (results.need(spot.of(quantity)) for spot in (left, right))
        masses = (results.found(spot.of("mass_matrix")) for spot in (left, right))
        sizes = (m[0] for m in masses if m is not None and states.usable(m[0]))
        return judge(about, one, other, next(sizes, None), left.setting)

    return Comparison(About(key, "1", metric), tuple(dict.fromkeys(needs)), judged)


def _own(spot: Spot) -> Iterator[Comparison]:
    """What one model owes to itself."""
    mass, bias, symbols = (spot.of(name) for name in ("mass_matrix", "bias", CHRISTOFFEL))
    over = f"{spot.count} random states"

    def key(quantity: str) -> Key:
        return Key("invariants", spot.where, quantity, spot.model)

    yield Comparison(
        About(
            key("inertia"),
            "1",
            f"largest relative asymmetry over {over}; positive definite",
            "first principles",
        ),
        (mass,),
        lambda about, results: invariants.is_inertia(about, results.need(mass)),
    )
    yield Comparison(
        About(
            key("bias-from-inertia"),
            "1",
            f"largest relative difference over {over}",
            "Christoffel symbols of its own mass matrix",
        ),
        (mass, bias, symbols),
        lambda about, results: invariants.bias_follows(
            about, results.need(bias), results.need(symbols), results.need(mass), spot.setting
        ),
    )
    yield _promises(spot)


def _promises(spot: Spot) -> Comparison:
    """A model must say of itself all that the registry says of it: users ask the model."""
    task, promised = Evaluation(spot.model, spot.case, ABILITIES), MODELS[spot.model].promises

    def judged(about: About, results: Results) -> Finding:
        lacking = sorted(promised - set(results.need(task).tolist()))
        if lacking:
            return failed(about, f"the model does not claim to have {', '.join(lacking)}")
        return checked(about, measured=0.0, tolerance=0.0, basis="every promised ability is there")

    key = Key("invariants", spot.where, "abilities", spot.model)
    return Comparison(About(key, "1", "abilities missing", "the registry"), (task,), judged)


def balances(spot: Spot) -> Iterator[Comparison]:
    """Power and angular momentum, from everything that the model says of a state."""
    yield balance(spot, "power", "W", invariants.power)
    yield balance(spot, "angular-momentum-rate", "N m", invariants.angular_momentum)


def balance(spot: Spot, name: str, unit: str, law: invariants.Balance) -> Comparison:
    """One balance of a model."""
    key = Key("invariants", spot.where, name, spot.model)
    metric = f"largest residual over {spot.count} random states"
    needs = tuple(spot.of(quantity) for quantity in STATE_ABILITIES)
    about = About(key, unit, metric, "first principles")
    return Comparison(about, needs, partial(_balanced, spot, law))


def _balanced(spot: Spot, law: invariants.Balance, about: About, results: Results) -> Finding:
    given = invariants.Answered(*(results.need(spot.of(name)) for name in STATE_ABILITIES))
    return law(about, given, spot.setting, spot.case)


def _closed_joints(spots: Sequence[Spot]) -> Iterator[Comparison]:
    for spot in spots:
        if "constraint_residual" in MODELS[spot.model].promises:
            task = spot.of("constraint_residual")
            key = Key("invariants", spot.where, "constraints", spot.model)
            metric = f"largest gap, rate or acceleration over its size, {spot.count} random states"
            yield Comparison(
                About(key, "1", metric, "closed joints"), (task,), partial(_closed, task)
            )


def _closed(task: Evaluation, about: About, results: Results) -> Finding:
    return invariants.constraints(about, results.need(task))


POLE_METRIC = "largest relative distance of a pole to the nearest of the other model's forces"
MODE_METRIC = "largest relative distance of a mode to the nearest of the other model"


def mode_comparisons(where: str, arm: Arm, chosen: Switches) -> Iterator[Comparison]:
    """Mesh modes of every pair of models that have them."""
    case = Case(arm, load_scenario("constant-torque"), chosen)
    able = promising("mesh_modes", _geared(case)) if scales.geared(arm) else ()
    for left, right in combinations(able, 2):
        tasks = tuple(Evaluation(name, case, "mesh_modes") for name in (left, right))
        key = Key("modes", where, "mesh-mode", left, right)
        yield Comparison(About(key, "1", MODE_METRIC), tasks, partial(_same_modes, tasks))


def pole_comparisons(where: str, arm: Arm, chosen: Switches) -> Iterator[Comparison]:
    """Poles of the loop with the teeth in contact, by which experiments are called unstable."""
    bent = Start(theta_rad=tuple(0.4 - 0.7 * number for number in range(len(arm.joints))))
    scenario = unequal_gains(arm).model_copy(update={"start": bent})
    case = Case(arm, scenario, chosen)
    linear = case._replace(arm=poles.linear_teeth(arm))
    for left in promising("contact_poles", _geared(linear)):
        for right in (name for name in _geared(linear) if name != left):
            own = Evaluation(left, case, "contact_poles")
            system = Evaluation(right, linear, START_MASS), Evaluation(right, linear, FORCE_SLOPES)
            key = Key("modes", where, "contact-poles", left, right)
            yield Comparison(
                About(key, "1", POLE_METRIC), (own, *system), partial(_same_poles, (own, *system))
            )


def _same_poles(tasks: Sequence[Evaluation], about: About, results: Results) -> Finding:
    return poles.poles_follow(about, *(results.need(task) for task in tasks))


def _same_modes(tasks: Sequence[Evaluation], about: About, results: Results) -> Finding:
    given = [_all_modes(task, results) for task in tasks]
    few, many = sorted(given, key=len)
    return modes.modes_among(about, few, many)


def _all_modes(task: Evaluation, results: Results) -> np.ndarray:
    """A model's modes. Raises Unavailable if it has lost some."""
    found, joints = results.need(task), task.case.arm.joints
    single = MODELS[task.model].free_planets or task.case.switches.planets == "free"
    planets = [joint.planet_count for joint in joints if joint.planet_count]
    expected = sum(1 + (count if single else 1) for count in planets)
    if len(found) != expected:
        raise Unavailable(f"{task.model}: {len(found)} mesh modes, there must be {expected}")
    return found


def _locked_stages(where: str, arm: Arm, chosen: Switches) -> Iterator[Comparison]:
    """The modes of each geared stage, carrier locked, against first principles."""
    for number, joint in scales.geared(arm):
        case = Case(locked_stage(arm, number), load_scenario("constant-torque"), chosen)
        for name in promising("mesh_modes", _geared(case)):
            task = Evaluation(name, case, "mesh_modes")
            key = Key("modes", where, "locked-stage", name, joint=number + 1)
            lumped = chosen.planets == "lumped"
            closed = modes.closed_form_modes(joint) if lumped else modes.free_modes(joint)
            yield Comparison(
                About(key, "1", MODE_METRIC, "closed form"),
                (task,),
                partial(_as_closed_form, task, closed),
            )


def locked_stage(arm: Arm, number: int) -> Arm:
    """One geared joint alone, its link too heavy to move, without weight and friction."""
    free = arm.joints[number].model_copy(update={"friction_N_m_s_per_rad": 0.0})
    link = arm.links[number]
    heavier = {
        name: modes.LOCK * value
        for name, value in link
        if name in ("density_kg_per_m3", "mass_kg", "inertia_kg_m2") and value is not None
    }
    locked = {"joints": (free,), "links": (link.model_copy(update=heavier),)}
    return arm.model_copy(update={**locked, "gravity_m_per_s2": (0.0, 0.0)})


def _as_closed_form(
    task: Evaluation, closed: np.ndarray, about: About, results: Results
) -> Finding:
    return modes.modes_among(about, closed, _all_modes(task, results))


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


def _label(chosen: Switches) -> str:
    """Of a setting; the paper's own way with planets and springs goes without saying."""
    single = ("free",) * (chosen.planets == "free")
    springs = ("conservative",) * (chosen.mesh_work == "conservative")
    papers = (chosen.phase, chosen.ring_rate, chosen.dead_zone, chosen.damping)
    return "-".join((*papers, *single, *springs))


def _geared(case: Case) -> tuple[str, ...]:
    """The geared models that are about a case."""
    return covering("geared", case.arm, case.switches)


def _case(arm: Arm, chosen: Switches) -> Case:
    return Case(arm, unequal_gains(arm), chosen)


def unequal_gains(arm: Arm) -> Scenario:
    """The PD scenario with other gains and targets at every joint."""
    numbers = range(len(arm.joints))
    drive = PdDrive(
        kind="pd",
        target_rad=tuple(0.5 + 0.1 * number for number in numbers),
        proportional_N_m_per_rad=tuple(1000.0 - 110 * number for number in numbers),
        derivative_N_m_s_per_rad=tuple(400.0 - 30 * number for number in numbers),
    )
    return load_scenario("pd").model_copy(update={"drive": drive})

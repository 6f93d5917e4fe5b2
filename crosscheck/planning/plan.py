"""Plan of a cross-check for any arm: experiments, and the runs of each."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import cast

import numpy as np

from crosscheck import registry
from crosscheck.checks.first_principles.composite import Content
from crosscheck.checks.sampled import ExperimentPlan, RunModels
from crosscheck.checks.scales import (
    EPS,
    base_radius,
    geared_joints,
    largest_torques,
    meshes,
    rounding,
)
from crosscheck.checks.trajectories import COARSE_STEP_RATIOS
from crosscheck.models.arm.arm import Arm
from crosscheck.models.arm.meshes import change_meshes, replace_damping
from crosscheck.models.arm.planets import usual_switches
from crosscheck.models.errors import InputError
from crosscheck.models.experiment.scenario import (
    Scenario,
    SinusoidDrive,
    Start,
    Switches,
    expand_to_joints,
    planet_offsets,
    switches,
)
from crosscheck.models.files import read_raw_arm
from crosscheck.models.loading import (
    Case,
    Selection,
    is_the_papers,
    load_arm,
    load_paper_arms,
    load_scenario,
)
from crosscheck.models.mechanism import Mechanism
from crosscheck.planning import sizing
from crosscheck.registry import MODELS
from crosscheck.runner.tasks import RunKey, Simulation

# Of the paper's experiments: long enough for its events; the quick plan keeps the start impact and
# the first drive.
FULL_S = {"constant-torque": 0.5, "pd": 3.0}
QUICK_S = {"constant-torque": 0.05, "pd": 0.1}
# What other experiments may take at most.
FULL_STEPS, QUICK_STEPS = 300_000, 10_000
# Steps within the limit of stability. The paper's own of 1e-5 s is a ninth of its arm's limit, and
# other arms are resolved as finely at least. The tier with constraints is of second order and needs
# a tenth of that step.
RESOLVED, SHORT_RESOLVED = 8, 80
RIGID_STEP_S, RIGID_STEPS = 1e-4, 2000  # largest step [s] and least number of steps of a rigid arm
REFERENCE_RTOL, COARSE_RTOL = 1e-10, 1e-8
RIGID_COARSE_RTOL = 1e-11
# Three steps of which the largest turns the fastest mesh mode by a sixth of a radian: there the
# order shows. Teeth that start so far apart, of the sun's radius, leave rounding far below.
ORDER_RESOLVED, ORDER_STEPS, ORDER_OFFSET = 16, 512, 1e-3
SHORT_STEPS, ENERGY_STEPS, SHORT_RECORDS = 5000, 2000, 50
PROBE_S = 0.05
# Longer runs than this nobody waits for: an arm that needs them is refused beforehand.
MOST_STEPS = 20_000_000
PAPER_PHASE = switches(phase="omega_t")
# Of the short experiments, torques of either sign, by whether the arm has teeth.
SHORT_NAMES = {True: ("short-contact", "short-crossing"), False: ("short-plus", "short-minus")}
# Of the experiments that stand beside a user's own.
RESERVED_NAMES = (
    *("probe", "order-smooth", "order-impact", *SHORT_NAMES[True], *SHORT_NAMES[False]),
    *("energy", "energy-fine", "energy-impacts", "energy-paper"),
)

# Of runs that choose their own steps.
RTOL = dict.fromkeys(("reference", "precise"), REFERENCE_RTOL)
RTOL |= dict.fromkeys(("reference-coarse", "precise-coarse"), COARSE_RTOL)


class Experiment(ExperimentPlan):
    """An experiment of a cross-check, with models from the registry."""

    growth: sizing.GrowingMode | None

    @property
    def models(self) -> RunModels:
        """The models that are about its arm under its switches."""
        (arm, _, laws), reference = self.case, MODELS[registry.reference_model()]

        def select(among: Sequence[str]) -> tuple[str, ...]:
            covering = registry.select_covering(among, arm, laws)
            return registry.select_with_method("simulate", covering)

        same = select(registry.find_same_integrator_models())
        others = tuple(each for each in select(registry.model_names("geared")) if each not in same)
        constrained = registry.select_with_method("constraint_residual", others)
        return RunModels(
            same,
            tuple(each for each in others if each not in constrained),
            constrained,
            select(registry.model_names("form")),
            {each: select(sort_engines(each)) for each in registry.find_distinct_levels(arm)},
            registry.group_equal_levels(arm)[-1],
            reference.order or 0,
            "precise" in reference.promises,
            frozenset(name for name, entry in MODELS.items() if entry.free_planets),
        )

    def run(self, model: str, variant: str = "", rtol: float | None = None) -> Simulation:
        """One of a model's runs: at its step, at about twice that, or from a start a rounding away.

        An adaptive model has a looser tolerance instead of a step twice as long; ``reference``
        is an adaptive run of a model that otherwise takes fixed steps, and ``precise`` one whose
        steps end where contacts change; ``free`` has a coordinate for every planet, whatever the
        experiment says; ``level-1`` has half the step, ``level-2`` a quarter. rtol: of an adaptive
        run that is to keep another tolerance.
        """
        key = RunKey(self.name, model, variant)
        if rtol or variant in RTOL:
            return Simulation(key, self.case, rtol or RTOL[variant])
        if variant.startswith("level-"):
            step = self.case.scenario.step_s / 2 ** int(variant.removeprefix("level-"))
            return Simulation(key, set_step(self.case, step))
        if MODELS[model].order is None:
            return Simulation(key, self.case, RIGID_COARSE_RTOL if variant == "coarse" else None)
        case = set_step(self.case, self._step(model))
        if variant in COARSE_STEP_RATIOS:
            scenario = case.scenario
            steps = max(1, round(COARSE_STEP_RATIOS[variant] * scenario.stride))
            case = set_step(case, scenario.step_s * scenario.stride / steps)
        if variant in ("free", "free-nudged"):
            laws = self.case.switches.model_copy(update={"planets": "free"})
            case = case._replace(switches=laws)
        is_nudged = variant in ("nudged", "free-nudged")
        return Simulation(key, perturb_start_by_one_ulp(case) if is_nudged else case)

    def _step(self, model: str) -> float:
        """Step of a model's run [s]; the rigid arm has no mesh to resolve."""
        scenario = self.case.scenario
        if not MODELS[model].is_rigid:
            return scenario.step_s
        interval = scenario.step_s * scenario.stride
        longest = min(RIGID_STEP_S, scenario.duration_s / RIGID_STEPS)
        return interval / (2 * max(1, np.ceil(interval / (2 * longest) - 1e-9)))


def sort_engines(level: str) -> list[str]:
    """Names of a level's rigid models that simulate, those that choose their own steps first."""
    able = registry.select_with_method("simulate", registry.find_level_models(level))
    return sorted(able, key=lambda name: MODELS[name].order is not None)


@dataclass(frozen=True)
class CrossCheckRequest:
    """A user's request for a cross-check.

    scenarios: their own experiments, in place of the plan's; chosen: laws of all of them, None for
    the plan's; model: name of equations that are tried in place of the cross-check of all models;
    arm_file_json: JSON of what the arm's file holds, settings applied, empty of a robot and of an
    arm that is of no file. Raises InputError for scenarios that cannot stand side
    by side.
    """

    mechanism: Mechanism
    quick: bool = False
    seed: int = 0
    scenarios: tuple[Scenario, ...] = ()
    chosen: Switches | None = None
    model: str = ""
    arm_file_json: str = ""

    def __post_init__(self) -> None:
        taken = [*RESERVED_NAMES]
        for scenario in self.scenarios:
            if scenario.name in taken:
                allowed = "must be a name that no other experiment of the cross-check has"
                raise InputError("scenario", "name", scenario.name, allowed)
            taken.append(scenario.name)

    @property
    def name(self) -> str:
        """Name of the arm or robot."""
        return self.mechanism.name

    @property
    def arm(self) -> Arm:
        """The arm; what is planned of arms alone asks for it."""
        return cast(Arm, self.mechanism)

    @property
    def needs_sizes(self) -> bool:
        """Whether experiments must be made for the arm."""
        return not self.scenarios and not is_the_papers(self.arm)

    @property
    def has_fixed_steps(self) -> bool:
        """Whether the experiments are the paper's, whose steps and durations are settled."""
        return not self.scenarios and is_the_papers(self.arm)


def request_cross_check(chosen: Selection, quick: bool, seed: int) -> CrossCheckRequest:
    """The request for a cross-check of what was selected. Raises InputError."""
    mechanism, scenarios, switches, file_json = chosen
    return CrossCheckRequest(mechanism, quick, seed, scenarios, switches, arm_file_json=file_json)


def draft_experiments(request: CrossCheckRequest, sizes: sizing.Sizes | None) -> list[Experiment]:
    """The experiments at the steps of their scenarios: what must be known before the plan."""
    laws = request.chosen or usual_switches(request.arm)
    scenarios = request.scenarios
    if not scenarios and sizes is not None:
        scenarios = (sizing.make_step_scenario(sizes), sizing.make_pd_scenario(sizes))
    if scenarios:
        return [Experiment(s.name, Case(request.arm, s, laws)) for s in scenarios]
    experiments = []
    for law, duration in (QUICK_S if request.quick else FULL_S).items():
        scenario = load_scenario(law).model_copy(update={"duration_s": duration})
        experiments.append(Experiment(law, Case(request.arm, scenario, laws)))
    if request.chosen is None:
        name = f"{experiments[0].name}-{PAPER_PHASE.phase}"
        experiments.append(Experiment(name, experiments[0].case._replace(switches=PAPER_PHASE)))
    return experiments


def set_stable_step(experiment: Experiment, limit_s: float) -> Experiment:
    """The experiment with its step halved until it is well within the limit of stability.

    It is also halved until twice the step meets every recorded time. limit_s: largest stable step
    [s] of the arm's models. Raises InputError for an arm whose teeth need a forbidding number of
    steps.
    """
    scenario = experiment.case.scenario
    step, duration, halvings = scenario.step_s, scenario.duration_s, 0
    while RESOLVED * step > limit_s or (scenario.stride << halvings) % 2:
        step, halvings = step / 2, halvings + 1
        if duration / step > MOST_STEPS:
            allowed = f"the teeth need steps below {limit_s:.2g} s, too many in {duration:g} s"
            raise InputError(experiment.case.arm.name, "joints", None, allowed)
    return replace(experiment, case=set_step(experiment.case, step)) if halvings else experiment


def limit_duration(request: CrossCheckRequest, experiment: Experiment) -> Experiment:
    """The experiment, cut to as many of its first steps as a cross-check has time for.

    Its last state is on the recording grid.
    """
    if request.has_fixed_steps:
        return experiment
    most = QUICK_STEPS if request.quick else FULL_STEPS if request.needs_sizes else MOST_STEPS
    scenario = experiment.case.scenario
    intervals = min(scenario.steps, max(most, scenario.stride)) // scenario.stride
    if intervals * scenario.stride == scenario.steps:
        return experiment
    duration = intervals * scenario.stride * scenario.step_s
    shorter = scenario.model_copy(update={"duration_s": duration})
    return replace(experiment, case=experiment.case._replace(scenario=shorter))


def make_probe_experiment() -> Experiment:
    """An experiment of the probe arm: a drive that depends on time, differently on each joint."""
    sizes, rates = (150.0, 90.0), (300.0, 170.0)
    drive = SinusoidDrive(
        kind="sinusoid", amplitude_N_m=sizes, rate_rad_per_s=rates, argument="time"
    )
    scenario = load_scenario("constant-torque")
    update = {"name": "probe", "duration_s": PROBE_S, "drive": drive}
    case = Case(load_arm("probe"), scenario.model_copy(update=update), PAPER_PHASE)
    return Experiment("probe", case)


def make_short_experiments(arm: Arm, first: Experiment, limit_s: float) -> list[Experiment]:
    """Experiments of some thousand fine steps, for models with constraints: both tooth flanks.

    first: the experiment whose torques are tried; limit_s: largest stable step [s] of the arm's
    models.
    """
    step = resolved_step(first, limit_s, SHORT_RESOLVED)
    duration = SHORT_STEPS * step
    largest = largest_torques(arm, first.case.scenario)
    torques = np.maximum(largest, _crossing_torques(arm, duration / 3))
    experiments = []
    for name, sign in zip(SHORT_NAMES[bool(geared_joints(arm))], (1.0, -1.0), strict=True):
        scenario = sizing.make_bent_scenario(name, SHORT_STEPS, SHORT_RECORDS, step, sign * torques)
        case = Case(arm, scenario, usual_switches(arm))
        experiments.append(Experiment(name, case, purpose="short"))
    return experiments


def _crossing_torques(arm: Arm, within_s: float) -> np.ndarray:
    """Torques [N m], (joints,), that take a sun's teeth across their backlash in this time."""
    torques = np.zeros(len(arm.joints))
    for number, joint in geared_joints(arm):
        play = 4 * max(mesh.backlash_m for mesh in meshes(joint))
        radius, ratio = base_radius(joint, joint.sun_teeth), 1 + joint.ring_teeth / joint.sun_teeth
        inertia = joint.sun_inertia_kg_m2 or (joint.sun_equivalent_mass_kg or 0.0) * radius**2
        torques[number] = 2 * play / within_s**2 / radius * inertia * ratio
    return torques


def resolved_step(first: Experiment, limit_s: float, times: int) -> float:
    """A step [s] of at most 1 / times the limit, to two digits, downwards enough."""
    longest = min(limit_s, 8 * first.case.scenario.step_s) / times
    return float(f"{0.97 * longest:.1e}")


def make_order_experiments(arm: Arm, first: Experiment, limit_s: float) -> list[Experiment]:
    """Runs for the order: teeth without clearance, whose force has no kink, and with backlash.

    An arm without teeth has none: its motion is so smooth that rounding hides the order.
    """
    if not geared_joints(arm):
        return []
    step = resolved_step(first, limit_s, ORDER_RESOLVED)
    stretched = np.zeros(len(arm.joints))
    for number, joint in geared_joints(arm):
        stretched[number] = ORDER_OFFSET * base_radius(joint, joint.sun_teeth)
    start = Start(mesh="centre", sun_planet_offset_m=tuple(map(float, stretched)))
    scenario = sizing.build_scenario(
        "order",
        duration_s=ORDER_STEPS * step,
        step_s=step,
        record_every=8,
        start=start,
        drive=sizing.make_torque_drive(largest_torques(arm, first.case.scenario)),
    )
    impact = Case(arm, scenario, usual_switches(arm))
    smooth = impact._replace(arm=remove_backlash(arm))
    cases = {"order-smooth": smooth, "order-impact": impact}
    return [Experiment(name, case, purpose="order") for name, case in cases.items()]


def make_energy_experiments(arm: Arm, first: Experiment, limit_s: float) -> list[Experiment]:
    """Runs without losses: without backlash, also finer and shorter, with it, by the paper's law.

    first: the experiment whose torques are tried; limit_s: largest stable step [s] of the arm's
    models. An arm without teeth has none.
    """
    if not geared_joints(arm):
        return []
    step = resolved_step(first, limit_s, SHORT_RESOLVED)
    torques = largest_torques(arm, first.case.scenario)
    scenario = sizing.make_bent_scenario("energy", ENERGY_STEPS, SHORT_RECORDS, step, torques)
    smooth = {"friction_N_m_s_per_rad": 0.0}
    smooth_joints = (joint.model_copy(update=smooth) for joint in replace_damping(arm, 0.0).joints)
    lossless = arm.model_copy(update={"joints": tuple(smooth_joints)})
    free = usual_switches(arm, planets="free")
    springs = free.model_copy(update={"mesh_work": "conservative"})
    touching = Case(remove_backlash(lossless), scenario, springs)
    # For integrators of second order: half as long, at a quarter of the step.
    half = {"duration_s": scenario.duration_s / 2, "step_s": scenario.step_s / 4}
    cases = {
        "energy": touching,
        "energy-fine": touching._replace(scenario=scenario.model_copy(update=half)),
        "energy-impacts": Case(lossless, scenario, springs),
        "energy-paper": Case(lossless, scenario, free),
    }
    return [Experiment(name, case, purpose="energy") for name, case in cases.items()]


def remove_backlash(arm: Arm) -> Arm:
    """The arm with teeth that touch on both sides."""
    return change_meshes(arm, lambda mesh: mesh.model_copy(update={"backlash_m": 0.0}))


def set_step(case: Case, step_s: float) -> Case:
    """The case at another step, recorded at the very same times.

    Raises ValueError unless the recording interval is a multiple of the step.
    """
    scenario = case.scenario
    ratio = scenario.step_s * scenario.stride / step_s
    if round(ratio) < 1 or abs(ratio - round(ratio)) > 1e-6:
        raise ValueError(f"steps of {step_s:g} s miss the recorded times of {scenario.name}")
    update = {"step_s": step_s, "record_every": round(ratio)}
    return case._replace(scenario=scenario.model_copy(update=update))


def perturb_start_by_one_ulp(case: Case) -> Case:
    """The case with every angle and mesh displacement started one rounding further.

    Planets that are free start forth and back in turn.
    """
    joints, start, slip = len(case.arm.joints), case.scenario.start, rounding(case.arm)
    shifts = {"theta_rad": EPS, "sun_planet_offset_m": slip, "planet_ring_offset_m": slip}
    update: dict[str, object] = {
        name: tuple(value + by for value in expand_to_joints(getattr(start, name), joints))
        for name, by in shifts.items()
    }
    if case.switches.planets == "free":
        update["planet_offset_m"] = tuple(
            tuple(
                offset + slip * (1 if planet % 2 else -1)
                for planet, offset in enumerate(planet_offsets(start, number, joint.planet_count))
            )
            for number, joint in enumerate(case.arm.joints)
        )
    moved = {"start": start.model_copy(update=update)}
    return case._replace(scenario=case.scenario.model_copy(update=moved))


def arm_variants(request: CrossCheckRequest) -> list[tuple[Arm, Content]]:
    """The arms of state checks: both readings of the paper's table, or the user's arm alone.

    Each comes with what its file holds, or with its own fields where it is of none.
    """
    if is_the_papers(request.arm):
        return [(arm, read_raw_arm(arm.name)) for arm in load_paper_arms()]
    return [(request.arm, json.loads(request.arm_file_json or request.arm.model_dump_json()))]

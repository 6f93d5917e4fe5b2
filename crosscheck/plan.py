"""What a cross-check runs and compares, for any arm."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from crosscheck.registry import PAPER_FORMS, RIGID_LEVELS, build
from crosscheck.simulations import Simulation, nudged, with_step
from models.arm import Arm
from models.errors import InputError
from models.loading import Case, load_arm, load_scenario
from models.scenario import ConstantDrive, SinusoidDrive
from models.switches import Switches, switches

# Long enough for the paper's events; the quick plan keeps the start impact and the first drive.
FULL_S = {"constant-torque": 0.5, "pd": 3.0}
QUICK_S = {"constant-torque": 0.05, "pd": 0.1}
RIGID_STEP_S = 1e-4  # RK4 on the smooth rigid arm: its error is far below 1e-10 rad
REFERENCE_RTOL, COARSE_RTOL = 1e-10, 1e-8
ORDER_S, ORDER_LEVELS = 0.004, 3
# At a quarter of the step the fastest mesh mode turns by 0.08 rad a step: there the order shows.
ASYMPTOTIC = 4
ORDERS = {"analytic:physical": 4, "exudyn:tree": 4}  # fixed-step models and their formal orders
# The constraint solver is of second order: the fastest mesh mode needs a microsecond or less.
SHORT_S, SHORT_STEP_S = 0.005, 1e-6
PROBE_S = 0.05
MECHANISM = switches()
PAPER_PHASE = switches(phase="omega_t")


@dataclass(frozen=True)
class Experiment:
    """One scenario of the plan, with a short name for ids."""

    name: str
    case: Case


def experiments(arm: Arm, quick: bool) -> list[Experiment]:
    """Constant torque and PD under the angle law, constant torque under omega_t, the probe."""
    durations = QUICK_S if quick else FULL_S
    chosen = (
        ("constant-torque", "constant-torque", MECHANISM),
        ("pd", "pd", MECHANISM),
        ("constant-torque-omega_t", "constant-torque", PAPER_PHASE),
    )
    own = [Experiment(name, _case(arm, law, durations, phase)) for name, law, phase in chosen]
    return [*own, probe_experiment()]


def probe_experiment() -> Experiment:
    """A drive that depends on time, differently on each joint, on the arm of unequal numbers."""
    drive = SinusoidDrive(
        kind="sinusoid",
        amplitude_N_m=(150.0, 90.0),
        rate_rad_per_s=(300.0, 170.0),
        argument="time",
    )
    scenario = load_scenario("constant-torque")
    update = {"name": "probe", "duration_s": PROBE_S, "drive": drive}
    case = Case(load_arm("probe"), scenario.model_copy(update=update), PAPER_PHASE)
    return Experiment("probe", case)


def _case(arm: Arm, scenario: str, durations: dict[str, float], chosen: Switches) -> Case:
    loaded = load_scenario(scenario).model_copy(update={"duration_s": durations[scenario]})
    case = Case(arm, loaded, chosen)
    step, limit = loaded.step_s, _stable_step(case)
    while 2 * step > limit:  # the coarse run of the refinement takes twice the step
        step /= 2
    return case if step == loaded.step_s else with_step(case, step)


def _stable_step(case: Case) -> float:
    """Of the analytic model; without it no limit is known, and its checks will say so."""
    try:
        return build("analytic:physical", *case).largest_stable_step()
    except InputError:
        return float("inf")


def geared_simulations(experiment: Experiment) -> Iterator[Simulation]:
    """Both engines' fixed-step runs, their refinements, the reference and a nudged start."""
    case, name = experiment.case, experiment.name
    step = case.scenario.step_s
    for model in ("analytic:physical", "exudyn:tree"):
        yield Simulation(f"{name}/{model}", model, case)
    if experiment.case.switches != MECHANISM:
        return
    yield Simulation(f"{name}/exudyn:tree/coarse", "exudyn:tree", with_step(case, 2 * step))
    yield Simulation(f"{name}/analytic:physical/nudged", "analytic:physical", nudged(case))
    for label, rtol in (("reference", REFERENCE_RTOL), ("reference/coarse", COARSE_RTOL)):
        yield Simulation(f"{name}/analytic:physical/{label}", "analytic:physical", case, rtol)


def rigid_simulations(experiment: Experiment) -> Iterator[Simulation]:
    """Every rigid level, in Pinocchio and analytically, with a refinement of each."""
    if experiment.case.switches != MECHANISM:
        return
    case, name = experiment.case, experiment.name
    for level in RIGID_LEVELS:
        pinocchio, analytic = f"pinocchio:{level}", f"analytic:{level}"
        yield Simulation(f"{name}/{pinocchio}", pinocchio, case)
        yield Simulation(f"{name}/{pinocchio}/coarse", pinocchio, case, 1e-11)
        fine = with_step(case, RIGID_STEP_S)
        yield Simulation(f"{name}/{analytic}", analytic, fine)
        yield Simulation(f"{name}/{analytic}/coarse", analytic, with_step(case, 2 * RIGID_STEP_S))


def form_simulations(experiment: Experiment) -> Iterator[Simulation]:
    """The paper's own forms, where they cover the arm."""
    if experiment.case.switches != MECHANISM or not covered_by_paper(experiment.case.arm):
        return
    for form in PAPER_FORMS:
        yield Simulation(f"{experiment.name}/{form}", form, experiment.case)


def covered_by_paper(arm: Arm) -> bool:
    """Whether the paper's forms are about such an arm: two joints with three planets each."""
    return [joint.planet_count for joint in arm.joints] == [3, 3]


def short_experiments(arm: Arm) -> list[Experiment]:
    """A few milliseconds at fine steps, for the tier with constraints: both flanks of the teeth."""
    scenario = load_scenario("constant-torque")
    experiments = []
    for name, torque in (("short-contact", 100.0), ("short-crossing", -100.0)):
        drive = ConstantDrive(kind="constant", torque_N_m=torque)
        update = {
            "duration_s": SHORT_S,
            "step_s": SHORT_STEP_S,
            "record_every": 100,
            "drive": drive,
        }
        case = Case(arm, scenario.model_copy(update=update), MECHANISM)
        experiments.append(Experiment(name, case))
    return experiments


def short_simulations(experiment: Experiment) -> Iterator[Simulation]:
    """Both Exudyn tiers, each at two steps."""
    for model in ("exudyn:tree", "exudyn:bodies"):
        for label, factor in (("", 1), ("/coarse", 2)):
            case = with_step(experiment.case, factor * SHORT_STEP_S)
            yield Simulation(f"{experiment.name}/{model}{label}", model, case)


@dataclass(frozen=True)
class OrderCase:
    """A short run repeated at h, h/2, h/4 to see the order of an integrator."""

    name: str
    case: Case
    smooth: bool


def order_cases(arm: Arm) -> list[OrderCase]:
    """Teeth without clearance, whose force has no kink, and teeth that meet after free play."""
    tight = tuple(joint.model_copy(update={"backlash_m": 0.0}) for joint in arm.joints)
    base = experiments(arm, quick=True)[0].case.scenario
    start = base.start.model_copy(update={"mesh": "centre"})
    scenario = base.model_copy(update={"duration_s": ORDER_S, "start": start})
    without = Case(arm.model_copy(update={"joints": tight}), scenario, MECHANISM)
    return [
        OrderCase("order-smooth", without, True),
        OrderCase("order-impact", Case(arm, scenario, MECHANISM), False),
    ]


def order_simulations(case: OrderCase) -> Iterator[Simulation]:
    """Every fixed-step model at each of the three steps."""
    for model in ORDERS:
        for level in range(ORDER_LEVELS):
            step = case.case.scenario.step_s / ASYMPTOTIC / 2**level
            yield Simulation(f"{case.name}/{model}/{level}", model, with_step(case.case, step))


def readings(arm: Arm) -> list[Arm]:
    """State checks run for both readings of the paper's table, or for the user's arm alone."""
    return papers_arms() if is_the_papers(arm) else [arm]


def papers_arms() -> list[Arm]:
    """Both readings of Table I."""
    return [load_arm(f"paper-{name}") for name in ("labelled", "swapped")]


def is_the_papers(arm: Arm) -> bool:
    """Whether this is the paper's arm, in either reading."""
    return arm in papers_arms()

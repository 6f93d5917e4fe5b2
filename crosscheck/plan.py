"""What a cross-check runs, for any arm: experiments, and the runs of each."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from crosscheck.registry import MODELS
from crosscheck.tasks import RunKey, Simulation
from models.arm import Arm
from models.errors import InputError
from models.loading import Case, load_arm, load_scenario
from models.scenario import ConstantDrive, SinusoidDrive
from models.switches import Switches, switches

# Long enough for the paper's events; the quick plan keeps the start impact and the first drive.
FULL_S = {"constant-torque": 0.5, "pd": 3.0}
QUICK_S = {"constant-torque": 0.05, "pd": 0.1}
# The paper's own step of 1e-5 s is a ninth of its arm's limit; other arms are resolved as finely.
# The tier with constraints is of second order and needs a tenth of that step.
RESOLVED, SHORT_RESOLVED = 8, 80
RIGID_STEP_S = 1e-4  # RK4 on the smooth rigid arm: its error is far below 1e-10 rad
REFERENCE_RTOL, COARSE_RTOL = 1e-10, 1e-8
RIGID_COARSE_RTOL = 1e-11
ORDER_S, ORDER_LEVELS = 0.004, 3
# At a quarter of the step the fastest mesh mode turns by 0.08 rad a step: there the order shows.
ASYMPTOTIC = 4
SHORT_S, SHORT_STEP_S = 0.005, 1e-6
PROBE_S = 0.05
# Longer runs than this nobody waits for: an arm that needs them is refused beforehand.
MOST_STEPS = 20_000_000
MECHANISM = switches()
PAPER_PHASE = switches(phase="omega_t")

Variant = Literal["", "coarse", "nudged", "reference", "reference-coarse"]


@dataclass(frozen=True)
class Experiment:
    """One scenario of the plan, with a short name for ids."""

    name: str
    case: Case

    def run(self, model: str, variant: Variant = "") -> Simulation:
        """One of a model's runs: at its step, at twice that, or from a start one ulp away.

        An adaptive model has a looser tolerance instead of a step twice as long; ``reference``
        is an adaptive run of a model that otherwise takes fixed steps.
        """
        key = RunKey(self.name, model, variant)
        if variant.startswith("reference"):
            rtol = REFERENCE_RTOL if variant == "reference" else COARSE_RTOL
            return Simulation(key, self.case, rtol)
        if MODELS[model].order is None:
            return Simulation(key, self.case, RIGID_COARSE_RTOL if variant == "coarse" else None)
        step = self._step(model) * (2 if variant == "coarse" else 1)
        case = with_step(self.case, step)
        return Simulation(key, nudged(case) if variant == "nudged" else case)

    def _step(self, model: str) -> float:
        """The rigid arm has no mesh to resolve."""
        if MODELS[model].role != "rigid":
            return self.case.scenario.step_s
        interval = self.case.scenario.step_s * self.case.scenario.stride
        return interval / (2 * max(1, np.ceil(interval / (2 * RIGID_STEP_S) - 1e-9)))


def experiments(arm: Arm, quick: bool, limit_s: float) -> list[Experiment]:
    """Constant torque and PD under the angle law, constant torque under omega_t, the probe.

    limit_s: largest stable step [s] of the arm's models. Raises InputError for an arm whose
    teeth would need a forbidding number of steps.
    """
    durations = QUICK_S if quick else FULL_S
    chosen = (
        ("constant-torque", "constant-torque", MECHANISM),
        ("pd", "pd", MECHANISM),
        ("constant-torque-omega_t", "constant-torque", PAPER_PHASE),
    )
    own = [
        Experiment(name, _case(arm, law, durations[law], phase, limit_s))
        for name, law, phase in chosen
    ]
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


def _case(arm: Arm, scenario: str, duration_s: float, chosen: Switches, limit_s: float) -> Case:
    loaded = load_scenario(scenario).model_copy(update={"duration_s": duration_s})
    return _resolved(Case(arm, loaded, chosen), RESOLVED, limit_s)


def _resolved(case: Case, times: int, limit_s: float) -> Case:
    """The case with its step halved until so many of them are within the limit [s].

    Raises InputError for an arm whose teeth would need a forbidding number of steps.
    """
    step, duration = case.scenario.step_s, case.scenario.duration_s
    while times * step > limit_s:
        step /= 2
        if duration / step > MOST_STEPS:
            allowed = f"the teeth need steps below {limit_s:.2g} s, too many in {duration:g} s"
            raise InputError(case.arm.name, "joints", None, allowed)
    return case if step == case.scenario.step_s else with_step(case, step)


def short_experiments(arm: Arm, limit_s: float) -> list[Experiment]:
    """A few milliseconds at fine steps, for the tier with constraints: both flanks of the teeth.

    limit_s: largest stable step [s] of the arm's models.
    """
    scenario = load_scenario("constant-torque")
    found = []
    for name, torque in (("short-contact", 100.0), ("short-crossing", -100.0)):
        numbers = range(len(arm.joints))
        torques = tuple(torque * (1 - 0.1 * number) for number in numbers)
        bent = {"theta_rad": tuple(0.4 - 0.7 * number for number in numbers)}
        update = {
            "duration_s": SHORT_S,
            "step_s": SHORT_STEP_S,
            "record_every": 100,
            "drive": ConstantDrive(kind="constant", torque_N_m=torques),
            "start": scenario.start.model_copy(update=bent),
        }
        case = Case(arm, scenario.model_copy(update=update), MECHANISM)
        found.append(Experiment(name, _resolved(case, SHORT_RESOLVED, limit_s)))
    return found


@dataclass(frozen=True)
class OrderCase:
    """A short run repeated at h, h/2, h/4 to see the order of an integrator."""

    name: str
    case: Case
    smooth: bool

    def runs(self, model: str) -> tuple[Simulation, ...]:
        """A model's run at each of the steps, the largest first."""
        step = self.case.scenario.step_s / ASYMPTOTIC
        return tuple(
            Simulation(
                RunKey(self.name, model, f"level-{level}"), with_step(self.case, step / 2**level)
            )
            for level in range(ORDER_LEVELS)
        )


def order_cases(arm: Arm, limit_s: float) -> list[OrderCase]:
    """Teeth without clearance, whose force has no kink, and teeth that meet after free play."""
    tight = tuple(joint.model_copy(update={"backlash_m": 0.0}) for joint in arm.joints)
    base = experiments(arm, True, limit_s)[0].case.scenario
    start = base.start.model_copy(update={"mesh": "centre"})
    scenario = base.model_copy(update={"duration_s": ORDER_S, "start": start})
    without = Case(arm.model_copy(update={"joints": tight}), scenario, MECHANISM)
    return [
        OrderCase("order-smooth", without, True),
        OrderCase("order-impact", Case(arm, scenario, MECHANISM), False),
    ]


def with_step(case: Case, step_s: float) -> Case:
    """The case at another step, recorded at the very same times.

    Raises ValueError unless the recording interval is a multiple of the step.
    """
    scenario = case.scenario
    ratio = scenario.step_s * scenario.stride / step_s
    if round(ratio) < 1 or abs(ratio - round(ratio)) > 1e-6:
        raise ValueError(f"steps of {step_s:g} s miss the recorded times of {scenario.name}")
    update = {"step_s": step_s, "record_every": round(ratio)}
    return case._replace(scenario=scenario.model_copy(update=update))


def nudged(case: Case) -> Case:
    """The case with x_sp1 one unit in the last place away from where it starts."""
    start = case.scenario.start
    at = case.arm.joints[0].backlash_m if start.mesh == "contact" else 0.0
    offset = (float(np.spacing(at)), *([0.0] * (len(case.arm.joints) - 1)))
    moved = start.model_copy(update={"sun_planet_offset_m": offset})
    return case._replace(scenario=case.scenario.model_copy(update={"start": moved}))


def readings(arm: Arm) -> list[Arm]:
    """State checks run for both readings of the paper's table, or for the user's arm alone."""
    return papers_arms() if is_the_papers(arm) else [arm]


def papers_arms() -> list[Arm]:
    """Both readings of Table I."""
    return [load_arm(f"paper-{name}") for name in ("labelled", "swapped")]


def is_the_papers(arm: Arm) -> bool:
    """Whether this is the paper's arm, in either reading."""
    return arm in papers_arms()

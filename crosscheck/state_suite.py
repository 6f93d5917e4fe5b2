"""Every comparison that needs no run: states, modes, invariants."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product

from crosscheck.checks import invariants, modes, states
from crosscheck.findings import Finding, failed
from crosscheck.registry import GEARED, PAPER_FORMS, RIGID_LEVELS, build
from models.arm import Arm
from models.errors import InputError
from models.interface import STATE_ABILITIES, Model
from models.loading import load_arm, load_scenario
from models.scenario import PdDrive, Scenario
from models.switches import Switches, switches

COUNT, QUICK_COUNT = 200, 20
# Per switch setting; M and bias know no switch, so they are compared under one setting alone.
SWITCH_COUNT, SWITCHED = 20, ("generalized_force", "acceleration")


@dataclass(frozen=True)
class StateChecks:
    """One family of state checks on one arm, as a task: ``geared``, ``rigid`` or ``switches``."""

    family: str
    arm: Arm
    quick: bool
    seed: int

    @property
    def key(self) -> str:
        """Unique among tasks."""
        return f"states/{self.arm.name}/{self.family}"

    @property
    def cost(self) -> float:
        """Rough seconds."""
        return {"geared": 5.0, "switches": 15.0, "rigid": 2.0}[self.family]

    def perform(self) -> list[Finding]:
        """The Findings."""
        count = QUICK_COUNT if self.quick else COUNT
        families = {
            "geared": lambda: geared_findings(self.arm, count, self.seed),
            "rigid": lambda: rigid_findings(self.arm, count, self.seed),
            "switches": lambda: switched_findings(self.arm, self.seed),
        }
        return list(families[self.family]())


def state_checks(arm: Arm, quick: bool, seed: int) -> list[StateChecks]:
    """Everything about one arm that needs no run."""
    return [StateChecks(family, arm, quick, seed) for family in ("geared", "rigid")]


def probe_checks(quick: bool, seed: int) -> list[StateChecks]:
    """The same on the arm of unequal numbers, which tells parameters apart; and the switches."""
    arm = load_arm("probe")
    families = ("geared", "rigid") if quick else ("geared", "rigid", "switches")
    return [StateChecks(family, arm, quick, seed) for family in families]


def rigid_findings(arm: Arm, count: int, seed: int) -> Iterator[Finding]:
    """States of the rigid levels, analytic against Pinocchio."""
    for level in RIGID_LEVELS:
        names = (f"analytic:{level}", f"pinocchio:{level}")
        case = f"{arm.name}/{level}"
        models, missing = built(case, names, arm, switches())
        yield from missing
        if len(models) > 1:
            yield from states.compare_states(case, models, STATE_ABILITIES, count, seed)


def switched_findings(arm: Arm, seed: int) -> Iterator[Finding]:
    """Forces and accelerations of the geared models under every setting of the switches."""
    for chosen in all_switches():
        case = f"{arm.name}/{_label(chosen)}"
        models, missing = built(case, GEARED, arm, chosen)
        yield from missing
        if len(models) > 1:
            yield from states.compare_states(case, models, SWITCHED, SWITCH_COUNT, seed)


def geared_findings(arm: Arm, count: int, seed: int) -> Iterator[Finding]:
    """States, balances and modes of the geared models, and what the paper's forms differ by."""
    case = f"{arm.name}/geared"
    models, missing = built(case, GEARED, arm, switches())
    yield from missing
    if len(models) > 1:
        yield from states.compare_states(case, models, STATE_ABILITIES, count, seed)
    yield from invariants.invariants(arm.name, models, count, seed)
    yield from invariants.constraints(arm.name, models, count, seed)
    unforced, _ = built(case, GEARED, arm, switches(), load_scenario("constant-torque"))
    yield from modes.compare_modes(arm.name, unforced)
    yield from _locked_stages(arm)
    for model in models[1:]:
        for form in paper_forms(arm):
            yield from states.measure_states(
                case, form, model, ("mass_matrix", "bias", "acceleration"), count, seed
            )


def paper_forms(arm: Arm) -> list[Model]:
    """The paper's own forms, for arms that they cover."""
    try:
        return [build(name, arm, load_scenario("pd")) for name in PAPER_FORMS]
    except InputError:
        return []


def _locked_stages(arm: Arm) -> Iterator[Finding]:
    for number, (joint, link) in enumerate(zip(arm.joints, arm.links, strict=True), start=1):
        heavy = link.model_copy(update={"density_kg_per_m3": modes.LOCK * link.density_kg_per_m3})
        one = arm.model_copy(update={"joints": (joint,), "links": (heavy,)})
        models, _ = built("locked", GEARED, one, switches(), load_scenario("constant-torque"))
        for model in models:
            if "mesh_modes" in model.abilities:
                yield from modes.locked_stage(f"{arm.name}/joint{number}", joint, model)


def all_switches() -> list[Switches]:
    """The sixteen combinations of the four switches."""
    fields = ("phase", "ring_rate", "dead_zone", "damping")
    values = (("angle", "omega_t"), ("eq13", "corrected"), ("exact", "tanh"), ("always", "contact"))
    return [switches(**dict(zip(fields, chosen, strict=True))) for chosen in product(*values)]


def _label(chosen: Switches) -> str:
    return "-".join((chosen.phase, chosen.ring_rate, chosen.dead_zone, chosen.damping))


def built(
    case: str, names: Sequence[str], arm: Arm, chosen: Switches, scenario: Scenario | None = None
) -> tuple[list[Model], list[Finding]]:
    """The models that can be built, and a failed check for each that cannot.

    Without a scenario: PD control with gains that differ from joint to joint.
    """
    models: list[Model] = []
    missing: list[Finding] = []
    for name in names:
        try:
            models.append(build(name, arm, scenario or unequal_gains(arm), chosen))
        except Exception as error:  # a missing or broken engine fails its checks
            reason = f"{type(error).__name__}: {error}"
            missing.append(missing_model(f"states/{case}", name, reason))
    return models, missing


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


def missing_model(where: str, model: str, reason: str) -> Finding:
    """A model that cannot be built or run is a failed check, never a skipped one."""
    return failed(
        id=f"{where}/{model}",
        quantity="model",
        unit="1",
        left=model,
        right=model,
        metric="the model can be built and run",
        note=reason,
    )

"""The cross-check from end to end: plan, simulate, compare."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import product

import xarray as xr

from crosscheck.checks import states, trajectories
from crosscheck.findings import Agreement, Finding, failed
from crosscheck.plan import (
    Experiment,
    experiments,
    geared_simulations,
    readings,
    rigid_simulations,
)
from crosscheck.provenance import provenance
from crosscheck.registry import GEARED, RIGID_LEVELS, build
from crosscheck.simulations import Failure, Outcome, perform_all
from models.arm import Arm
from models.interface import STATE_ABILITIES, Model
from models.loading import load_arm, load_scenario
from models.switches import Switches, switches

Told = Callable[[str, int], None]  # (what is being done, steps still to come)
STATE_COUNT, QUICK_STATE_COUNT = 200, 20
SWITCH_STATE_COUNT = 20


@dataclass(frozen=True)
class CrossCheck:
    """An Agreement and the trajectories that it was drawn from, by experiment and model."""

    arm: Arm
    agreement: Agreement
    runs: dict[str, Outcome]


def cross_check(
    arm: Arm | str, *, quick: bool, jobs: int, seed: int, told: Told = lambda what, left: None
) -> CrossCheck:
    """Run every check on an arm. Raises InputError for an arm that cannot be loaded."""
    arm = load_arm(arm) if isinstance(arm, str) else arm
    plan = experiments(arm, quick)
    simulations = [s for e in plan for s in (*geared_simulations(e), *rigid_simulations(e))]
    left = len(simulations)

    def done(key: str) -> None:
        nonlocal left
        left -= 1
        told(key, left)

    told("states", left)
    findings = [f for reading in readings(arm) for f in state_findings(reading, quick, seed)]
    runs = perform_all(simulations, jobs, done)
    findings += [f for experiment in plan for f in run_findings(experiment, runs)]
    return CrossCheck(arm, Agreement(findings, provenance(arm, seed, quick)), runs)


def state_findings(arm: Arm, quick: bool, seed: int) -> Iterator[Finding]:
    """M, bias, force and acceleration of all models that share coordinates."""
    count = QUICK_STATE_COUNT if quick else STATE_COUNT
    yield from _states(arm, f"{arm.name}/geared", GEARED, switches(), count, seed)
    for level in RIGID_LEVELS:
        names = (f"analytic:{level}", f"pinocchio:{level}")
        yield from _states(arm, f"{arm.name}/{level}", names, switches(), count, seed)
    if not quick:
        for chosen in all_switches():
            yield from _states(
                arm, f"{arm.name}/{_label(chosen)}", GEARED, chosen, SWITCH_STATE_COUNT, seed
            )


def all_switches() -> list[Switches]:
    """The sixteen combinations of the four switches."""
    fields = ("phase", "ring_rate", "dead_zone", "damping")
    values = (("angle", "omega_t"), ("eq13", "corrected"), ("exact", "tanh"), ("always", "contact"))
    return [switches(**dict(zip(fields, chosen, strict=True))) for chosen in product(*values)]


def _label(chosen: Switches) -> str:
    return "-".join((chosen.phase, chosen.ring_rate, chosen.dead_zone, chosen.damping))


def _states(
    arm: Arm, case: str, names: tuple[str, ...], chosen: Switches, count: int, seed: int
) -> Iterator[Finding]:
    scenario = load_scenario("pd")
    models: list[Model] = []
    for name in names:
        try:
            models.append(build(name, arm, scenario, chosen))
        except Exception as error:  # a missing or broken engine fails its checks
            yield _missing(f"states/{case}", name, f"{type(error).__name__}: {error}")
    # M and bias know no switch: compare them once.
    quantities = STATE_ABILITIES if count != SWITCH_STATE_COUNT else STATE_ABILITIES[2:]
    if len(models) > 1:
        yield from states.compare_states(case, models, quantities, count, seed)


def run_findings(experiment: Experiment, runs: dict[str, Outcome]) -> Iterator[Finding]:
    """Every comparison that this experiment's runs allow."""
    name = experiment.name
    missing = {key: run for key, run in runs.items() if isinstance(run, Failure)}
    for key, error in missing.items():
        if key.startswith(f"{name}/"):
            yield _missing(f"run/{key}", key.split("/")[1], str(error))
    good = {key: run for key, run in runs.items() if isinstance(run, xr.Dataset)}
    yield from _geared_findings(name, good)
    for level in RIGID_LEVELS:
        yield from _rigid_findings(experiment, level, good)


def _missing(where: str, model: str, reason: str) -> Finding:
    return failed(
        id=f"{where}/{model}",
        quantity="model",
        unit="1",
        left=model,
        right=model,
        metric="the model can be built and run",
        note=reason,
    )


def _geared_findings(name: str, runs: dict[str, xr.Dataset]) -> Iterator[Finding]:
    ours, theirs = (runs.get(f"{name}/{m}") for m in ("analytic:physical", "exudyn:tree"))
    if ours is None or theirs is None:
        return
    yield from trajectories.same_step(name, ours, theirs)
    if float(ours["time"][-1]) > 2:
        yield from trajectories.at_time(name, ours, theirs, 2.0)
    labels = ("analytic:physical/reference", "analytic:physical/reference/coarse")
    reference, coarse_reference = (runs.get(f"{name}/{label}") for label in labels)
    coarse = runs.get(f"{name}/exudyn:tree/coarse")
    if reference is not None and coarse_reference is not None and coarse is not None:
        yield from trajectories.refined(name, (reference, coarse_reference), (theirs, coarse))
    nudged = runs.get(f"{name}/analytic:physical/nudged")
    if nudged is not None:
        yield from trajectories.sensitivity(name, ours, nudged)


def _rigid_findings(
    experiment: Experiment, level: str, runs: dict[str, xr.Dataset]
) -> Iterator[Finding]:
    name = experiment.name
    sides = [
        tuple(runs.get(f"{name}/{engine}:{level}{kind}") for kind in ("", "/coarse"))
        for engine in ("pinocchio", "analytic")
    ]
    (fine, coarse), (other, other_coarse) = sides
    if fine is not None and coarse is not None and other is not None and other_coarse is not None:
        yield from trajectories.refined(name, (fine, coarse), (other, other_coarse), ("theta",))
    geared = runs.get(f"{name}/analytic:physical")
    if fine is not None and geared is not None:
        yield from trajectories.deviation(name, fine, geared, experiment.case.arm)

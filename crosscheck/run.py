"""The cross-check from end to end: plan, simulate, compare."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from crosscheck.findings import Agreement
from crosscheck.plan import (
    experiments,
    form_simulations,
    geared_simulations,
    order_cases,
    order_simulations,
    readings,
    rigid_simulations,
)
from crosscheck.provenance import provenance
from crosscheck.run_suite import order_findings, run_findings
from crosscheck.simulations import Outcome, perform_all
from crosscheck.state_suite import state_findings
from models.arm import Arm
from models.loading import load_arm

Told = Callable[[str, int], None]  # (what is being done, steps still to come)


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
    plan, orders = experiments(arm, quick), order_cases(arm)
    families = (geared_simulations, rigid_simulations, form_simulations)
    simulations = [s for experiment in plan for family in families for s in family(experiment)]
    simulations += [s for case in orders for s in order_simulations(case)]
    left = len(simulations)

    def done(key: str) -> None:
        nonlocal left
        left -= 1
        told(key, left)

    told("states", left)
    findings = [f for reading in readings(arm) for f in state_findings(reading, quick, seed)]
    runs = perform_all(simulations, jobs, done)
    findings += [f for experiment in plan for f in run_findings(experiment, runs)]
    findings += [f for case in orders for f in order_findings(case, runs)]
    return CrossCheck(arm, Agreement(findings, provenance(arm, seed, quick)), runs)

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
    short_experiments,
    short_simulations,
)
from crosscheck.provenance import provenance
from crosscheck.run_suite import order_findings, run_findings
from crosscheck.simulations import Outcome, perform_all
from crosscheck.state_suite import probe_checks, state_checks
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
    plan, shorts, orders = experiments(arm, quick), short_experiments(arm), order_cases(arm)
    families = (geared_simulations, rigid_simulations, form_simulations)
    checks = [check for reading in readings(arm) for check in state_checks(reading, quick, seed)]
    checks += probe_checks(quick, seed)
    simulations = [s for experiment in plan for family in families for s in family(experiment)]
    simulations += [s for short in shorts for s in short_simulations(short)]
    simulations += [s for case in orders for s in order_simulations(case)]
    left = len(checks) + len(simulations)

    def done(key: str) -> None:
        nonlocal left
        left -= 1
        told(key, left)

    told("starting", left)
    results = perform_all([*checks, *simulations], jobs, done)
    findings = [finding for check in checks for finding in results[check.key]]
    runs = {simulation.key: results[simulation.key] for simulation in simulations}
    findings += [f for experiment in [*plan, *shorts] for f in run_findings(experiment, runs)]
    findings += [f for case in orders for f in order_findings(case, runs)]
    return CrossCheck(arm, Agreement(findings, provenance(arm, seed, quick)), runs)

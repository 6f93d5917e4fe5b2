"""Every comparison of the runs of an experiment."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import xarray as xr

from crosscheck.checks import convergence, invariants, trajectories
from crosscheck.findings import Finding
from crosscheck.plan import ORDER_LEVELS, ORDERS, Experiment, OrderCase
from crosscheck.registry import PAPER_FORMS, RIGID_LEVELS
from crosscheck.simulations import Failure, Outcome
from crosscheck.state_suite import missing_model

Runs = Mapping[str, xr.Dataset]


def run_findings(experiment: Experiment, outcomes: Mapping[str, Outcome]) -> Iterator[Finding]:
    """Every comparison that this experiment's runs allow."""
    name = experiment.name
    for key, outcome in outcomes.items():
        if isinstance(outcome, Failure) and key.startswith(f"{name}/"):
            yield missing_model(f"run/{key}", key.split("/")[1], str(outcome))
    runs = {key: run for key, run in outcomes.items() if isinstance(run, xr.Dataset)}
    yield from _geared_findings(name, runs)
    yield from _tier_findings(name, runs)
    yield from _form_findings(name, runs)
    for level in RIGID_LEVELS:
        yield from _rigid_findings(experiment, level, runs)


def order_findings(case: OrderCase, outcomes: Mapping[str, Outcome]) -> Iterator[Finding]:
    """Observed order of each fixed-step integrator, smooth and through impacts."""
    for model, formal in ORDERS.items():
        keys = [f"{case.name}/{model}/{level}" for level in range(ORDER_LEVELS)]
        runs = [outcomes[key] for key in keys]
        good = [run for run in runs if isinstance(run, xr.Dataset)]
        if len(good) == len(runs):
            yield from convergence.order(case.name, good, formal, case.smooth)
        else:
            reason = "; ".join(str(run) for run in runs if isinstance(run, Failure))
            yield missing_model(f"order/{case.name}", model, reason)


def _geared_findings(name: str, runs: Runs) -> Iterator[Finding]:
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
        yield from invariants.energy_over_run(name, reference)
    nudged = runs.get(f"{name}/analytic:physical/nudged")
    if nudged is not None:
        yield from trajectories.sensitivity(name, ours, nudged)


def _tier_findings(name: str, runs: Runs) -> Iterator[Finding]:
    """Exudyn's tier with constraints against its tree."""
    tiers = [
        [runs.get(f"{name}/{tier}{kind}") for kind in ("", "/coarse")]
        for tier in ("exudyn:tree", "exudyn:bodies")
    ]
    (tree, coarse_tree), (bodies, coarse_bodies) = tiers
    if tree is None or coarse_tree is None or bodies is None or coarse_bodies is None:
        return
    yield from trajectories.refined(name, (tree, coarse_tree), (bodies, coarse_bodies))


def _form_findings(name: str, runs: Runs) -> Iterator[Finding]:
    engine = runs.get(f"{name}/exudyn:tree")
    for form in PAPER_FORMS:
        run = runs.get(f"{name}/{form}")
        if run is not None and engine is not None:
            yield from trajectories.form_deviation(name, run, engine)


def _rigid_findings(experiment: Experiment, level: str, runs: Runs) -> Iterator[Finding]:
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

"""Short cross-checks and what is done to their records."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from crosscheck.baseline_file import read_baseline, sealed
from crosscheck.checks.trajectories import UNITS
from crosscheck.findings import Agreement, Finding, checked, measured_only
from crosscheck.plan import Experiment, geared_simulations, rigid_simulations
from crosscheck.provenance import provenance
from crosscheck.regression import compare
from crosscheck.run import CrossCheck
from crosscheck.run_suite import run_findings
from crosscheck.simulations import perform_all
from models.arm import Arm
from models.loading import Case, load_arm, load_scenario
from models.switches import switches

DURATION_S = 0.02  # PD: impact of the start, mesh vibration, its decay
ANALYTIC, EXUDYN = "pd/analytic:physical", "pd/exudyn:tree"
RENEW = "crosscheck baseline accept paper-labelled --quick"
Change = Callable[[dict[str, Any]], object]


def short_check(arm: Arm, only: str | None = None) -> CrossCheck:
    """A cross-check of one short experiment: real engines, real checks; or one run of it."""
    scenario = load_scenario("pd").model_copy(update={"duration_s": DURATION_S})
    experiment = Experiment("pd", Case(arm, scenario, switches()))
    rigid = (s for s in rigid_simulations(experiment) if "coupled" in s.key)
    simulations = [s for s in (*geared_simulations(experiment), *rigid) if only in (None, s.key)]
    runs = perform_all(simulations, 1, lambda key: None)
    findings = list(run_findings(experiment, runs))
    return CrossCheck(arm, Agreement(findings, provenance(arm, 0, True)), runs)


def invented_check(arm: Arm) -> CrossCheck:
    """A cross-check that no engine made: one check, one run of smooth numbers of every quantity."""
    scenario = load_scenario("pd").model_copy(update={"duration_s": 0.004})
    time, joints = np.linspace(0, 0.004, 41), len(arm.joints)
    phase = np.sin(40 * time[:, None] + np.arange(joints))
    lengths = {"time": len(time), "joint": joints, "planet": 3}
    run = xr.Dataset(coords={"time": time, "joint": np.arange(1, joints + 1)})
    for quantity in ("theta", "theta_dot", "theta_ddot", "x_sp", "x_pr", "F_sp", "F_pr"):
        dims = ("time", "joint", *(["planet"] if quantity[1] == "_" else []))
        values = np.broadcast_to(
            phase.reshape(*phase.shape, *[1] * (len(dims) - 2)), [lengths[d] for d in dims]
        )
        run[quantity] = (dims, values, {"units": UNITS[quantity]})
    settings = {"scenario": scenario, "switches": switches()}
    texts = {name: json.dumps(value.model_dump()) for name, value in settings.items()}
    run = run.assign_attrs(model="analytic:physical", step_s=scenario.step_s, **texts)
    agreement = Agreement([green()], provenance(arm, 0, True))
    return CrossCheck(arm, agreement, {ANALYTIC: run})


def fields(name: str) -> dict[str, str]:
    """What every Finding needs beside its numbers."""
    return {
        "id": name,
        "quantity": "theta",
        "unit": "rad",
        "left": "a:b",
        "right": "c:d",
        "metric": "",
        "basis": "",
    }


def green() -> Finding:
    """A check that agrees."""
    return checked(measured=1e-12, tolerance=1e-10, **fields("same-step/pd/theta/a~b"))


def red(measured: float = 3e-3) -> Finding:
    """A check that differs."""
    return checked(measured=measured, tolerance=1e-10, **fields("refined/pd/theta/a~b"))


def measurement(name: str, measured: float = 1.0) -> Finding:
    """A measurement of a difference."""
    return measured_only(measured=measured, **fields(name))


def with_run(result: CrossCheck, key: str, run: Any) -> CrossCheck:
    """The result with another run in the place of one."""
    return replace(result, runs={**result.runs, key: run})


def with_findings(result: CrossCheck, findings: Iterable[Finding]) -> CrossCheck:
    """The result with other Findings."""
    return replace(result, agreement=Agreement([*findings], result.agreement.provenance))


def edited(path: Path, change: Change) -> None:
    """Change the record and its digest: as a program would, or someone who means harm."""
    data = json.loads(path.read_text(encoding="utf-8"))
    change(data)
    path.write_text(json.dumps(sealed(data)), encoding="utf-8")


def held_against(path: Path, result: CrossCheck) -> Agreement:
    """The comparison of a recorded file with a result."""
    return compare(read_baseline(path, load_arm("paper-labelled"), True, RENEW), result)


def moved(agreement: Agreement) -> dict[str, Finding]:
    """Red Findings by id."""
    return {finding.id: finding for finding in agreement.red}

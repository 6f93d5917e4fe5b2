"""Short cross-checks and what is done to their records."""

import json
from collections.abc import Callable, Iterable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from crosscheck.baseline.file import read_baseline
from crosscheck.baseline.regression import compare
from crosscheck.checks.trajectories import UNITS
from crosscheck.findings import (
    Agreement,
    ComparisonKey,
    Finding,
    Subject,
    make_check,
    make_measurement,
)
from crosscheck.models.arm.arm import Arm
from crosscheck.models.experiment.scenario import switches
from crosscheck.models.loading import Case, load_arm, load_scenario
from crosscheck.planning.arms import plan_experiment_comparisons
from crosscheck.planning.comparison import Comparison, Results, collect_tasks, judge_comparisons
from crosscheck.planning.plan import CrossCheckRequest, Experiment
from crosscheck.provenance import record_provenance
from crosscheck.registry import MODELS
from crosscheck.run import CrossCheck, cases_by_run, runs_by_key
from crosscheck.runner.tasks import RunKey, Simulation

DURATION_S = 0.01  # PD: impact of the start, mesh vibration, its decay
ANALYTIC, EXUDYN = RunKey("pd", "analytic:physical"), RunKey("pd", "exudyn:tree")
NUDGED = replace(ANALYTIC, variant="nudged")
RENEW = "crosscheck baseline accept paper-labelled --quick"
Change = Callable[[dict[str, Any]], object]


def quick(arm: Arm) -> CrossCheckRequest:
    """What these cross-checks and their records are of."""
    return CrossCheckRequest(arm, quick=True)


def short_check(arm: Arm, only: RunKey | None = None) -> CrossCheck:
    """A cross-check of one short experiment: real engines, real checks; or one run of it."""
    scenario = load_scenario("pd").model_copy(update={"duration_s": DURATION_S})
    experiment = Experiment("pd", Case(arm, scenario, switches()))
    planned = [c for c in plan_experiment_comparisons(experiment) if _is_wanted(c, only)]
    results = Results({task.key: task.perform() for task in collect_tasks(planned)})
    findings = list(judge_comparisons(planned, results))
    agreement = Agreement(findings, record_provenance(arm, 0, True))
    return CrossCheck(quick(arm), agreement, cases_by_run(planned), runs_by_key(results))


def _is_wanted(comparison: Comparison, only: RunKey | None) -> bool:
    """The geared models and one rigid level; or what needs one run alone."""
    keys = [task.key for task in comparison.needs if isinstance(task, Simulation)]
    if only is not None:
        return keys == [only]
    levels = [key for key in keys if MODELS[key.model].role == "rigid"]
    return all(key.model.endswith("coupled") for key in levels)


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
    agreement = Agreement([green()], record_provenance(arm, 0, True))
    cases = {ANALYTIC: Case(arm, scenario, switches())}
    return CrossCheck(quick(arm), agreement, cases, {ANALYTIC: run})


def about(family: str, case: str = "pd") -> Subject:
    """What an invented Finding is of: its id is family/case/theta/a~b."""
    return Subject(ComparisonKey(family, case, "theta", "a", "b"), "rad", "")


def green() -> Finding:
    """A check that agrees."""
    return make_check(about("same-step"), measured=1e-12, tolerance=1e-10, basis="")


def red(measured: float = 3e-3) -> Finding:
    """A check that differs."""
    return make_check(about("refined"), measured=measured, tolerance=1e-10, basis="")


def measurement(case: str, measured: float = 1.0) -> Finding:
    """A measurement of a difference."""
    return make_measurement(about("deviation", case), measured=measured)


def with_run(result: CrossCheck, key: RunKey, run: Any) -> CrossCheck:
    """The result with another run in the place of one."""
    return replace(result, runs={**result.runs, key: run})


def with_findings(result: CrossCheck, findings: Iterable[Finding]) -> CrossCheck:
    """The result with other Findings."""
    return replace(result, agreement=Agreement([*findings], result.agreement.provenance))


def edited(path: Path, change: Change) -> None:
    """Change the record."""
    data = json.loads(path.read_text(encoding="utf-8"))
    change(data)
    path.write_text(json.dumps(data), encoding="utf-8")


def put(value: object, *place: str | int) -> Change:
    """Put a value at a place; what is made of the one there where it is a function."""
    *above, last = place

    def change(data: dict[str, Any]) -> None:
        target: Any = data
        for key in above:
            target = target[key]
        target[last] = value(target[last]) if callable(value) else value

    return change


def held_against(path: Path, result: CrossCheck) -> Agreement:
    """The comparison of a recorded file with a result."""
    return compare(read_baseline(path, quick(load_arm("paper-labelled")), RENEW), result)


def moved(agreement: Agreement) -> dict[str, Finding]:
    """Red Findings by id."""
    return {finding.id: finding for finding in agreement.disagreeing}

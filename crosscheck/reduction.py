"""A cross-check reduced to what a baseline records: verdicts, samples, and how far they may move.

A repetition takes the same steps, so that its truncation error repeats too and rounding alone may
differ: between machines, versions of a compiler, orders of summation. Only where the integrator
chooses its own steps may rounding choose others, and the numerical uncertainty counts. A fixed-step
run's own uncertainty is recorded beside the tolerance: 2e-8 m, for a backlash whose millionth is
5e-11 m, would let real changes pass.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any, NamedTuple, cast, get_args

import numpy as np
import xarray as xr
from pydantic import ValidationError

from crosscheck import __version__
from crosscheck.baseline import (
    BEST_FIRST,
    WIDEST,
    Baseline,
    CheckVerdict,
    ExtremesName,
    Known,
    Measurement,
    Misfit,
    Provenance,
    Run,
    SampledName,
)
from crosscheck.checks.states import LOOSEST
from crosscheck.checks.trajectories import SAME_STEP, Incomparable, Limit, largest_difference
from crosscheck.checks.trajectories import uncertainty as refinement
from crosscheck.findings import Agreement, Finding
from crosscheck.report.words import outcome
from crosscheck.run import CrossCheck
from crosscheck.run_suite import ANALYTIC
from crosscheck.tasks import Failure, RunKey
from models.arm import Arm

SAMPLED: tuple[str, ...] = get_args(SampledName)
EXTREMES: tuple[str, ...] = get_args(ExtremesName)
INTERVALS = 20
# Runs that are recorded for themselves, and the run that measures the uncertainty of each; all
# others (another step, a nudged start) are not recorded.
COARSER = {"": "coarse", "reference": "reference-coarse"}
# Rounding growth of the same steps. Two engines on the paper's arm stay below these by a factor of
# 30 and more over the full runs: 4.9e-14 rad, 4.9e-13 rad/s, 6.2e-9 rad/s2, 3.3e-15 m, 3.9e-7 N.
# The implicit tier, started 1e-16 rad and 3e-17 m apart, stays below 2e-16 rad and 6e-17 m.
REPEATED = {
    name: Limit(limit.value, "the same steps again: rounding growth only, as between two engines")
    for name, limit in SAME_STEP.items()
}
# Every variable is rounded in every step, one ulp in the start only once.
ROUNDINGS = 1000
# For a measurement whose uncertainty nobody measured: of its own value, and of its quantity's size.
UNKNOWN, UNKNOWN_OF_SIZE = 1e-6, 1e-10
RECORDED = tuple(Provenance.model_fields)

Datasets = dict[RunKey, xr.Dataset]


class Bound(NamedTuple):
    """Tolerance of a repetition (None: not comparable), its reason, measured uncertainty."""

    tolerance: float | None
    basis: str
    uncertainty: float | None = None


Bounds = dict[RunKey, dict[str, Bound]]


def baseline_of(result: CrossCheck) -> Baseline:
    """What to record of a cross-check. Runs that failed are left out."""
    agreement = result.agreement
    runs: dict[str, Run] = {}
    bounds: Bounds = {}
    for key in filter(is_recorded, result.runs):
        reduced = reduced_run(key, result)
        if not isinstance(reduced, Failure):
            runs[str(key)], bounds[key] = reduced

    def number(finding: Finding) -> Measurement:
        return _measurement(finding, bounds, result.arm)

    checks = checks_by_id(agreement)
    red = {name: finding for name, finding in checks.items() if finding.verdict != "agree"}
    return Baseline(
        project_version=__version__,
        checks={name: cast(CheckVerdict, finding.verdict) for name, finding in checks.items()},
        known={
            name: Known(said=outcome(f), number=None if f.measured is None else number(f))
            for name, f in red.items()
        },
        measurements={name: number(f) for name, f in measurements_by_id(agreement).items()},
        runs=runs,
        provenance=Provenance(**{name: agreement.provenance[name] for name in RECORDED}),
    )


def checks_by_id(agreement: Agreement) -> dict[str, Finding]:
    """The checks by id; of several with one id the worst stands."""
    worst_last = sorted(agreement.checks, key=lambda finding: BEST_FIRST.index(finding.verdict))
    return {finding.id: finding for finding in worst_last}


def measurements_by_id(agreement: Agreement) -> dict[str, Finding]:
    """The measurements by id."""
    return {f.id: f for f in agreement.findings if f.kind == "measurement"}


def reduced_run(key: RunKey, result: CrossCheck) -> tuple[Run, dict[str, Bound]] | Failure:
    """What is recorded of a run, and how far each quantity may move; or why it has no record.

    A run holds whatever its model put there: what cannot be reduced is a failed run, no crash.
    """
    run = result.runs[key]
    if isinstance(run, Failure):
        return run
    try:
        bounds = bounds_of(key, datasets(result))
        return _reduced(run, bounds), bounds
    except Exception as error:
        return Failure("cannot be recorded", _reason(error))


def unrecorded(result: CrossCheck) -> Iterator[str]:
    """Runs that have a trajectory of which nothing can be recorded, as ``run: reason``."""
    for key in filter(is_recorded, datasets(result)):
        reduced = reduced_run(key, result)
        if isinstance(reduced, Failure):
            yield f"{key} {reduced}"


def _reason(error: Exception) -> str:
    if isinstance(error, ValidationError):
        first = error.errors()[0]
        misfit = first.get("ctx", {}).get("error")
        where = [*map(str, first["loc"]), *([misfit.field] if isinstance(misfit, Misfit) else [])]
        return f"{'.'.join(where)} = {first['input']!r:.60}: {first['msg']}"
    return f"{type(error).__name__}: {' '.join(str(error).split()):.200}"


def is_recorded(key: RunKey) -> bool:
    """Whether the run of this key is recorded for itself, not for what it says of another."""
    return key.variant in COARSER


def datasets(result: CrossCheck) -> Datasets:
    """The runs that have a trajectory."""
    return {key: run for key, run in result.runs.items() if isinstance(run, xr.Dataset)}


def settings_of(run: xr.Dataset) -> dict[str, Any]:
    """Scenario and switches of a run, as its Dataset states them."""
    return {name: json.loads(run.attrs[name]) for name in ("scenario", "switches")}


def sample_times(run: xr.Dataset) -> np.ndarray:
    """Indices of about 20 equally spaced records, first and last among them, shape (samples,)."""
    return np.unique(np.linspace(0, run.sizes["time"] - 1, INTERVALS + 1).round().astype(int))


def per_joint(run: xr.Dataset, quantity: str) -> np.ndarray:
    """A quantity of planet 1, shape (times, joints), in its own unit."""
    values = run[quantity]
    return np.asarray(values.isel(planet=0) if "planet" in values.dims else values)


def extreme_rows(run: xr.Dataset, quantity: str) -> np.ndarray:
    """Per joint: number, minimum, its time [s], maximum, its time; shape (joints, 5)."""
    values, time = per_joint(run, quantity), run["time"].values.round(10)
    low, high = values.argmin(axis=0), values.argmax(axis=0)
    joints = run["joint"].values
    return np.column_stack([joints, values.min(axis=0), time[low], values.max(axis=0), time[high]])


def bounds_of(key: RunKey, runs: Datasets) -> dict[str, Bound]:
    """Quantity -> how far a repetition of this run may move."""
    run, coarse = runs[key], runs.get(replace(key, variant=COARSER[key.variant]))
    # A coarser run at the same step is one whose integrator chooses its own.
    own_steps = coarse is not None and coarse.attrs["step_s"] == run.attrs["step_s"]
    bounds = {}
    for quantity in (name for name in (*SAMPLED, *EXTREMES) if name in run):
        measured = _measured(refinement, run, coarse, quantity)
        if own_steps:
            limit = _adaptive(quantity, measured)
        else:
            limit = _repeated(quantity, _growth(key.experiment, run, quantity, runs))
        bounds[quantity] = _meaningful(quantity, limit, _short(measured))
    return bounds


def _growth(experiment: str, run: xr.Dataset, quantity: str, runs: Datasets) -> float | None:
    """What one ulp in the start grows to in a geared run, whichever engine it is from."""
    pair = [runs.get(RunKey(experiment, ANALYTIC, kind)) for kind in ("", "nudged")]
    return _measured(largest_difference, pair[0], pair[1], quantity) if "x_sp" in run else None


def _measured(
    measure: Callable[[xr.Dataset, xr.Dataset, str], float],
    one: xr.Dataset | None,
    other: xr.Dataset | None,
    quantity: str,
) -> float | None:
    """A measure of two runs; None where one is missing, or spoilt: that costs no third run."""
    try:
        return None if one is None or other is None else measure(one, other, quantity)
    except Incomparable:
        return None


def _adaptive(quantity: str, measured: float | None) -> Limit:
    floor = REPEATED[quantity]
    if measured is None or measured <= floor.value:
        return floor._replace(basis="numerical uncertainty is less; no run is held to more digits")
    basis = "numerical uncertainty by a coarser tolerance: the integrator chooses its own steps"
    return Limit(measured, basis)


def _repeated(quantity: str, growth: float | None) -> Limit:
    floor = REPEATED[quantity]
    if growth is None or ROUNDINGS * growth <= floor.value:
        return floor
    return Limit(ROUNDINGS * growth, f"{ROUNDINGS} x what one ulp in the start grows to")


def _meaningful(quantity: str, limit: Limit, uncertainty: float | None) -> Bound:
    widest = WIDEST[quantity]
    if not limit.value <= widest.value:
        reason = f"not compared: {limit.basis}, {limit.value:.2g}; {widest.value:g} at most"
        return Bound(None, f"{reason}, {widest.basis}", uncertainty)
    return Bound(_short(limit.value), limit.basis, uncertainty)


def _short(value: float | None) -> float | None:
    """Rounded up to three digits; None for what is no number."""
    if value is None or not math.isfinite(value) or value == 0:
        return 0.0 if value == 0 else None
    digits = float(f"{value:.2e}")
    return digits if digits >= value else float(f"{value * 1.005:.2e}")


def _reduced(run: xr.Dataset, bounds: dict[str, Bound]) -> Run:
    times = run["time"].values.round(10)
    at = sample_times(run)
    tables: dict[str, dict[str, Any]] = {"sampled": {}, "extremes": {}}
    for quantity, bound in bounds.items():
        if quantity in SAMPLED:
            rows, section = np.column_stack([times[at], per_joint(run, quantity)[at]]), "sampled"
        else:
            rows, section = extreme_rows(run, quantity), "extremes"
        fields = {"unit": run[quantity].attrs["units"], **bound._asdict()}
        tables[section][quantity] = {"rows": rows.tolist(), **fields}
    return Run.model_validate({**settings_of(run), **tables})


def _measurement(finding: Finding, bounds: Bounds, arm: Arm) -> Measurement:
    assert finding.measured is not None  # a measurement always has a number
    bound = _measurement_bound(finding, bounds, arm)
    return Measurement(unit=finding.unit, measured=finding.measured, **bound._asdict())


def _measurement_bound(finding: Finding, bounds: Bounds, arm: Arm) -> Bound:
    key = finding.about.key
    if key.family == "one-ulp" and finding.quantity in REPEATED:
        # Rounding itself: its digits mean nothing, but it must stay below what matters.
        return Bound(REPEATED[finding.quantity].value, "rounding: must stay below same-step limit")
    if key.family in ("states", "form-states"):
        return Bound(LOOSEST, "states repeat to rounding: the loosest tolerance of state checks")
    quantity = "theta" if finding.quantity == "tip" else finding.quantity
    sides = [bounds.get(RunKey(key.case, model), {}) for model in (key.left, key.right)]
    own = [side[quantity].tolerance for side in sides if quantity in side]
    if len(own) < 2:
        return _unknown(finding)
    known = [value for value in own if value is not None]
    if len(known) < 2:
        return Bound(None, "not compared: neither are the runs that it compares")
    reach = _reach(arm) if finding.quantity == "tip" else 1.0
    along = " in theta, along the links" if finding.quantity == "tip" else ""
    return Bound(_short(sum(known) * reach), f"sum of both runs' tolerances{along}")


def _unknown(finding: Finding) -> Bound:
    value = abs(finding.measured or 0.0)
    size = value / finding.relative if finding.relative else 0.0
    tolerance = max(UNKNOWN * value, UNKNOWN_OF_SIZE * size)
    basis = f"no uncertainty measured: {UNKNOWN:g} of it, or {UNKNOWN_OF_SIZE:g} of the quantity"
    return Bound(_short(tolerance), basis)


def _reach(arm: Arm) -> float:
    """How far the tip moves [m] at most if every joint turns by one radian."""
    return sum(number * link.length_m for number, link in enumerate(arm.links, start=1))


def uncompared(baseline: Baseline) -> Iterator[str]:
    """Quantities that are recorded but not comparable, as ``run quantity: reason``."""
    for key, run in baseline.runs.items():
        for quantity, table in run.tables.items():
            if table.tolerance is None:
                yield f"{key} {quantity}: {table.basis}"

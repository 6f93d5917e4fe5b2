"""A cross-check reduced to what a baseline records: verdicts, samples, and how far they may move.

A repetition takes the same steps, so that its truncation error repeats too and rounding alone may
differ: between machines, versions of a compiler, orders of summation. Only where the integrator
chooses its own steps may rounding choose others, and the numerical uncertainty counts. A fixed-step
run's own uncertainty is recorded beside the tolerance: 2e-8 m, for a backlash whose millionth is
5e-11 m, would let real changes pass.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any, cast, get_args

import numpy as np
from pydantic import ValidationError

from crosscheck import __version__
from crosscheck.baseline import record
from crosscheck.checks import trajectories
from crosscheck.checks.records import BY_PLANET
from crosscheck.checks.scales import LOOSEST, ReasonedLimit, acceptance_limit
from crosscheck.checks.trajectories import ONE_ROUNDING, Pair, size
from crosscheck.findings import Agreement, Finding
from crosscheck.models.errors import rephrase
from crosscheck.models.loading import Case
from crosscheck.registry import reference_model
from crosscheck.report.formatting import describe_outcome
from crosscheck.run import CrossCheck
from crosscheck.runner.outcomes import Failure
from crosscheck.runner.tasks import RunKey

if TYPE_CHECKING:
    import xarray as xr

SAMPLED: tuple[str, ...] = get_args(record.SampledName)
EXTREMES: tuple[str, ...] = get_args(record.ExtremesName)
INTERVALS = 20
# Runs that are recorded for themselves, and the run that measures the uncertainty of each; all
# others (another step, a nudged start) are not recorded.
COARSER = {"": "coarse", "reference": "reference-coarse"}
# Limits for a measurement of unknown uncertainty: of its value, and of its quantity's size.
UNKNOWN, UNKNOWN_OF_SIZE = 1e-6, 1e-10
# Growth of one rounding that is assumed where no second run measures it.
UNMEASURED_ROUNDINGS = 1000
BY_ROUNDING = "the same steps again: rounding as it was measured to grow over the run"


RunBounds = dict[str, record.BoundedRecord]  # by quantity
Bounds = dict[RunKey, RunBounds]


def make_baseline(result: CrossCheck) -> record.Baseline:
    """The Baseline of a cross-check. Runs that failed and checks not judged are left out."""
    agreement = result.agreement
    assert agreement.provenance is not None  # as cross_check gives it
    runs: dict[str, record.RecordedRun] = {}
    bounds: Bounds = {}
    for key in filter(is_recorded, result.runs):
        reduced = reduce_run(key, result)
        if not isinstance(reduced, Failure):
            runs[str(key)], bounds[key] = reduced

    def make_measurement(finding: Finding) -> record.Measurement:
        assert finding.measured is not None  # a measurement always has a number
        tolerance, basis = _measurement_bound(finding, bounds, result.cases)
        return record.Measurement(
            unit=finding.unit, tolerance=tolerance, basis=basis, measured=finding.measured
        )

    judged = checks_by_id(agreement).items()
    checks = {name: finding for name, finding in judged if finding.verdict != "unfinished"}
    red = {name: finding for name, finding in checks.items() if finding.verdict != "agree"}
    return record.Baseline(
        project_version=__version__,
        checks={
            name: cast(record.CheckVerdict, finding.verdict) for name, finding in checks.items()
        },
        known={
            name: record.AcceptedFailure(
                said=describe_outcome(f), number=None if f.measured is None else make_measurement(f)
            )
            for name, f in red.items()
        },
        measurements={
            name: make_measurement(f) for name, f in measurements_by_id(agreement).items()
        },
        runs=runs,
        provenance=agreement.provenance,
    )


def checks_by_id(agreement: Agreement) -> dict[str, Finding]:
    """The checks by id."""
    return {finding.id: finding for finding in agreement.checks}


def measurements_by_id(agreement: Agreement) -> dict[str, Finding]:
    """The measurements by id."""
    return {f.id: f for f in agreement.findings if f.kind == "measurement"}


def reduce_run(key: RunKey, result: CrossCheck) -> tuple[record.RecordedRun, RunBounds] | Failure:
    """The record of a run, and how far each quantity may move; or why it has no record.

    A run holds whatever its model put there: what cannot be reduced is a failed run, no crash.
    """
    run = result.runs[key]
    if isinstance(run, Failure):
        return run
    try:
        bounds = compute_bounds(key, result)
        return _make_record(run, result.cases[key], bounds), bounds
    except ValidationError as error:
        first = error.errors()[0]
        place = ".".join(map(str, first["loc"]))
        what = f"{place} = {first['input']!r:.60}: {rephrase(first['msg'])}"
    except Exception as error:
        what = f"{type(error).__name__}: {' '.join(str(error).split()):.200}"
    return Failure("cannot be recorded", what)


def find_unrecorded_runs(result: CrossCheck) -> Iterator[str]:
    """Runs that have a trajectory of which nothing can be recorded, as ``run: reason``."""
    for key, run in result.runs.items():
        if is_recorded(key) and not isinstance(run, Failure):
            reduced = reduce_run(key, result)
            if isinstance(reduced, Failure):
                yield f"{key} {reduced}"


def is_recorded(key: RunKey) -> bool:
    """Whether the run of this key is recorded as a run of its own."""
    return key.variant in COARSER


def compute_bounds(key: RunKey, result: CrossCheck) -> RunBounds:
    """The largest change of this run in a repetition, by quantity."""
    runs = {key: run for key, run in result.runs.items() if not isinstance(run, Failure)}
    case = result.cases[key]
    run, coarse = runs[key], runs.get(replace(key, variant=COARSER[key.variant]))
    pair = _find_pair(key.experiment, runs)
    # A coarser run at the same step is one whose integrator chooses its own, as references do.
    has_same_step = coarse is not None and coarse.attrs["step_s"] == run.attrs["step_s"]
    adaptive_steps = key.variant == "reference" or has_same_step
    bounds = {}
    for quantity in (name for name in (*SAMPLED, *EXTREMES) if name in run):
        measured = _refinement_uncertainty(run, coarse, quantity)
        limit = _repetition_limit(pair, run, quantity)
        if adaptive_steps:
            limit = _adaptive_limit(limit, measured)
        widest = acceptance_limit(quantity, case.arm, case.scenario, size(run, quantity))
        tolerance, basis = _round_up(limit.value), limit.basis
        if not limit.value <= widest.value:
            tolerance, basis = None, f"not compared: {limit.basis}"
            if math.isfinite(limit.value):
                basis += f", {limit.value:.2g}; {widest.value:.2g} at most, {widest.basis}"
        bounds[quantity] = record.BoundedRecord(
            unit=run.variables[quantity].attrs["units"],
            tolerance=tolerance,
            basis=basis,
            uncertainty=_round_up(measured),
            widest=_round_up(widest.value),
        )
    return bounds


def _find_pair(experiment: str, runs: dict[RunKey, xr.Dataset]) -> Pair | None:
    """The reference model's run of an experiment, and the one that started a rounding away.

    Their planets are counted as the experiment does, or free. None where there are no such two.
    """
    for variants in (("", "nudged"), ("free", "free-nudged")):
        run, nudged = (runs.get(RunKey(experiment, reference_model(), each)) for each in variants)
        if run is not None and nudged is not None:
            return Pair(run, nudged)
    return None


def _refinement_uncertainty(
    run: xr.Dataset, coarse: xr.Dataset | None, quantity: str
) -> float | None:
    """Uncertainty by a coarser run; None where that is missing, or one of the two is spoilt."""
    try:
        return None if coarse is None else trajectories.uncertainty(run, coarse, quantity)
    except trajectories.RunMismatch:
        return None


def _adaptive_limit(floor: ReasonedLimit, measured: float | None) -> ReasonedLimit:
    """The limit of a run whose integrator chooses its own steps.

    Rounding differs between processors (SciPy's sums are BLAS's) and may choose other steps.
    """
    if measured is None:
        basis = "the integrator chooses its own steps, and no second run was made"
        return ReasonedLimit(math.inf, basis)
    if measured <= floor.value:
        return floor._replace(basis="numerical uncertainty is less; no run is held to more digits")
    basis = "numerical uncertainty by a coarser tolerance: the integrator chooses its own steps"
    return ReasonedLimit(measured, basis)


def _repetition_limit(pair: Pair | None, run: xr.Dataset, quantity: str) -> ReasonedLimit:
    """The change that rounding alone makes of the same steps again, in any engine."""
    try:
        if pair is not None and quantity in pair.run:
            return ReasonedLimit(trajectories.repetition_limit(pair, quantity).value, BY_ROUNDING)
    except trajectories.RunMismatch:
        pass
    value = UNMEASURED_ROUNDINGS * trajectories.run_rounding(run, quantity)
    basis = f"{UNMEASURED_ROUNDINGS} x rounding, whose growth could not be measured"
    return ReasonedLimit(value, basis)


def _round_up(value: float | None) -> float | None:
    """A value rounded up to three digits; None for what is no number."""
    if value is None or not math.isfinite(value) or value == 0:
        return 0.0 if value == 0 else None
    digits = float(f"{value:.2e}")
    return digits if digits >= value else float(f"{value * 1.005:.2e}")


def _make_record(run: xr.Dataset, case: Case, bounds: RunBounds) -> record.RecordedRun:
    """The record of a run: planet 1, and the joints that have a quantity (direct: no teeth)."""
    times = run["time"].values.round(10)
    # About 20 equally spaced records, first and last among them.
    at = np.unique(np.linspace(0, times.size - 1, INTERVALS + 1).round().astype(int))
    every = run["joint"].values.tolist()
    toothed = [number for number in every if case.arm.joints[number - 1].planet_count]
    tables: dict[str, dict[str, Any]] = {"sampled": {}, "extremes": {}}
    for quantity, bound in bounds.items():
        joints = toothed if quantity in BY_PLANET else every
        variable = run.variables[quantity]
        selection = variable.isel(joint=[every.index(joint) for joint in joints])
        values = np.asarray(selection.isel(planet=0) if "planet" in selection.dims else selection)
        if quantity in SAMPLED:
            rows, section = np.column_stack([times[at], values[at]]), "sampled"
        else:
            low, high = values.argmin(axis=0), values.argmax(axis=0)
            ends = values.min(axis=0), times[low], values.max(axis=0), times[high]
            rows, section = np.column_stack([joints, *ends]), "extremes"
        table = {**bound.model_dump(), "joints": joints, "rows": rows.tolist()}
        tables[section][quantity] = table
    settings = {"scenario": case.scenario, "switches": case.switches}
    return record.RecordedRun.model_validate({**settings, **tables})


def _measurement_bound(
    finding: Finding, bounds: Bounds, cases: Mapping[RunKey, Case]
) -> tuple[float | None, str]:
    """The change of a measurement that a repetition may make, None if not comparable; and why."""
    key = finding.about.key
    if key.family == ONE_ROUNDING:
        # Rounding itself: its digits mean nothing, but it must stay below what matters.
        granted = bounds.get(RunKey(key.case, key.left), {}).get(finding.quantity)
        tolerance = None if granted is None else granted.tolerance
        return tolerance, "rounding: must stay below what the run may move by"
    if key.family in ("states", "form-states", "trial-states"):
        return LOOSEST, "states repeat to rounding: the loosest tolerance of state checks"
    quantity = "theta" if finding.quantity == "tip" else finding.quantity
    sides = [bounds.get(RunKey(key.case, model), {}) for model in (key.left, key.right)]
    tolerances = [side[quantity].tolerance for side in sides if quantity in side]
    if len(tolerances) < 2:
        reference = bounds.get(RunKey(key.case, key.left, "reference"), {})
        if reference and all(bound.tolerance is None for bound in reference.values()):
            return None, "not compared: neither is the run that it measures"
        value = abs(finding.measured or 0.0)
        size = value / finding.relative if finding.relative else 0.0
        by = f"{UNKNOWN:g} of it, or {UNKNOWN_OF_SIZE:g} of the quantity"
        tolerance = _round_up(max(UNKNOWN * value, UNKNOWN_OF_SIZE * size))
        return tolerance, f"no uncertainty measured: {by}"
    defined_tolerances = [value for value in tolerances if value is not None]
    if len(defined_tolerances) < 2:
        return None, "not compared: neither are the runs that it compares"
    if finding.quantity != "tip":
        return _round_up(sum(defined_tolerances)), "sum of both runs' tolerances"
    # How far the tip moves [m] at most if every joint turns by one radian.
    links = cases[RunKey(key.case, key.left)].arm.links
    reach = sum(number * link.length_m for number, link in enumerate(links, start=1))
    basis = "sum of both runs' tolerances in theta, along the links"
    return _round_up(sum(defined_tolerances) * reach), basis


def find_uncompared(baseline: record.Baseline) -> Iterator[str]:
    """Quantities that are recorded but not comparable, as ``run quantity: reason``."""
    for key, run in baseline.runs.items():
        for quantity, table in run.tables.items():
            if table.tolerance is None:
                yield f"{key} {quantity}: {table.basis}"

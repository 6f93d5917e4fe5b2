"""A cross-check compared with a recorded one: each change, relative to the allowed one."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from crosscheck.baseline import reduction
from crosscheck.baseline.record import (
    BEST_FIRST,
    AcceptedFailure,
    Baseline,
    BoundedRecord,
    Extremes,
    RecordedRun,
    SampledQuantity,
    find_differences,
)
from crosscheck.checks.trajectories import UNITS
from crosscheck.findings import (
    Agreement,
    ComparisonKey,
    Finding,
    Subject,
    make_check,
    make_failed_check,
    make_measurement,
    make_unfinished_check,
)
from crosscheck.registry import is_plugin
from crosscheck.report.formatting import describe_outcome
from crosscheck.run import CrossCheck
from crosscheck.runner.outcomes import Failure

DIGEST = 12  # digits of a hash that a reader compares
# Measured uncertainties differ between machines, by less than this. A tolerance that is wider than
# today's by more was not granted by the program, or no longer is.
WIDENED = 100.0
_GONE = "disappeared"
_NEW = "appeared: nothing on record"
_PLUGIN = "of a model that came in after the record was made; accept again to hold it"


def compare(baseline: Baseline, result: CrossCheck) -> Agreement:
    """The Agreement of a cross-check with its record: one check for every recorded result.

    ``differ``: it changed beyond its tolerance; ``make_failed_check``: one of the two sides does
    not exist, or was made with other settings; ``make_unfinished_check``: it was not judged now.
    ``known`` of the Agreement names the checks that failed as accepted in the record's ``known``.
    """
    now = reduction.make_baseline(result)
    findings = [*_compare_verdicts(baseline, now, result.agreement)]
    findings += _compare_measurements(baseline, now, result.agreement)
    for name in sorted({*baseline.runs, *now.runs}):
        findings += _compare_runs(name, baseline.runs.get(name), now.runs.get(name), result)
    accepted_keys = [_key("verdict", name) for name in sorted(baseline.known)]
    return Agreement(findings, result.agreement.provenance, baseline.provenance, accepted_keys)


def find_accepted_differences(agreement: Agreement) -> list[Finding]:
    """The checks that failed as accepted. agreement: as compare returns it."""
    keys = agreement.accepted_keys
    return [f for f in agreement.checks if f.about.key in keys and f.verdict == "agree"]


def describe_changes(agreement: Agreement) -> list[str]:
    """Differences between the record's surroundings and those now, such as `exudyn 1.13.6 -> 2`.

    agreement: as compare returns it.
    """
    then, now = agreement.record, agreement.provenance
    if then is None or now is None:
        return []
    named = {"python", "machine", "revision", "lock_sha256", "arm_sha256"}
    old, new = (each.versions | each.model_dump(include=named) for each in (then, now))
    changes = []
    for name, was, is_now in find_differences(old, new):
        digits = DIGEST if name.endswith("sha256") else None
        changes.append(f"{name} {str(was)[:digits]} -> {str(is_now)[:digits]}")
    return changes


def _compare_verdicts(baseline: Baseline, now: Baseline, agreement: Agreement) -> Iterator[Finding]:
    findings = reduction.checks_by_id(agreement)
    for name in sorted({*baseline.checks, *findings}):
        was, finding = baseline.checks.get(name), findings.get(name)
        about = _subject("verdict", name, finding, "1")
        if finding is None:
            yield make_failed_check(about, f"{_GONE}; was {was}")
        elif finding.verdict == "unfinished":
            yield make_unfinished_check(about, describe_outcome(finding))
        elif was is None and finding.verdict == "agree" and _has_plugin(finding):
            note = f"{finding.id}: {_PLUGIN}; agree: {describe_outcome(finding)}"
            yield make_measurement(about, measured=0.0, basis="nothing on record", note=note)
        elif was is None:
            note = f"{_NEW}; {finding.verdict}: {describe_outcome(finding)}"
            yield make_failed_check(about, note)
        elif was != finding.verdict:
            steps = BEST_FIRST.index(finding.verdict) - BEST_FIRST.index(was)
            way = "worse" if steps > 0 else "better"
            note = f"{way}: {was} -> {finding.verdict}: {describe_outcome(finding)}"
            yield _verdict(about, abs(steps), note)
        else:
            yield _compare_failures(about, baseline.known.get(name), now.known.get(name), finding)


def _has_plugin(finding: Finding) -> bool:
    """Whether one of the finding's models is a plug-in, which may be newer than the record."""
    return any(map(is_plugin, (finding.left, finding.right)))


def _compare_failures(
    about: Subject, was: AcceptedFailure | None, now: AcceptedFailure | None, finding: Finding
) -> Finding:
    """The Finding of a check of the same verdict; one that failed must fail by as much."""
    if was is None or now is None:
        return _verdict(about, 0, "")
    note = f"known difference, {finding.verdict}: {describe_outcome(finding)}"
    if was.number is not None and now.number is not None:
        values = was.number.measured, now.number.measured
        number = replace(about, unit=finding.unit)
        result = _compare_numbers(number, was.number, now.number, values, note)
        if result.kind == "check":
            return result
    return _verdict(about, 0, note)


def _verdict(about: Subject, steps: int, note: str) -> Finding:
    basis = "the same verdict"
    return make_check(about, measured=float(steps), tolerance=0.0, basis=basis, note=note)


def _compare_measurements(
    baseline: Baseline, now: Baseline, agreement: Agreement
) -> Iterator[Finding]:
    findings = reduction.measurements_by_id(agreement)
    unjudged = {finding.id for finding in agreement.disagreeing if finding.verdict == "unfinished"}
    for name in sorted({*baseline.measurements, *now.measurements} - unjudged):
        record, is_now = baseline.measurements.get(name), now.measurements.get(name)
        finding = findings.get(name)
        unit = finding.unit if finding else record.unit if record else ""
        about = _subject("measurement", name, finding, unit)
        if finding is None or is_now is None:
            yield make_failed_check(about, _GONE)
        elif record is None and _has_plugin(finding):
            basis = "nothing on record"
            yield make_measurement(about, measured=is_now.measured, basis=basis, note=_PLUGIN)
        elif record is None:
            yield make_failed_check(about, _NEW)
        else:
            yield _compare_numbers(about, record, is_now, (record.measured, is_now.measured))


def _compare_runs(
    name: str, record: RecordedRun | None, now: RecordedRun | None, result: CrossCheck
) -> Iterator[Finding]:
    whole = _run_subject(name, "run", "1")
    recorded_keys = filter(reduction.is_recorded, result.runs)
    key = next((key for key in recorded_keys if str(key) == name), None)
    if record is None and key is not None and is_plugin(key.model):
        yield make_measurement(whole, measured=0.0, basis="nothing on record", note=_PLUGIN)
    elif record is None:
        yield make_failed_check(whole, _NEW)
    elif now is None:
        why = None if key is None else reduction.reduce_run(key, result)
        is_unfinished = isinstance(why, Failure) and why.unfinished
        missing = make_unfinished_check if is_unfinished else make_failed_check
        yield missing(whole, f"{_GONE}: {why or 'no longer part of the plan'}")
    else:
        yield from _compare_tables(name, record, now)


def _compare_tables(name: str, record: RecordedRun, now: RecordedRun) -> Iterator[Finding]:
    """Findings of a run against its record, one a quantity, if it has the same settings."""
    settings = {"scenario", "switches"}
    then, today = (run.model_dump(mode="json", include=settings) for run in (record, now))
    moved = [f"{path} {was!r} -> {is_now!r}" for path, was, is_now in find_differences(then, today)]
    if moved:
        note = f"other settings, numbers not compared: {'; '.join(moved)}"
        yield make_failed_check(_run_subject(name, "settings", "1"), note)
        return
    before, after = record.tables, now.tables
    for quantity in sorted({*before, *after}):
        about = _run_subject(name, quantity, UNITS[quantity])
        yield _compare_table(about, before.get(quantity), after.get(quantity))


def _compare_table(
    about: Subject,
    record: SampledQuantity | Extremes | None,
    now: SampledQuantity | Extremes | None,
) -> Finding:
    if now is None:
        return make_failed_check(about, f"{_GONE}: the run has no such quantity")
    if record is None:
        return make_failed_check(about, _NEW)
    was, is_now = np.array(record.rows), np.array(now.rows)
    if was.shape != is_now.shape or not np.array_equal(was[:, 0], is_now[:, 0]):
        return make_failed_check(about, "recorded at other times or of another number of joints")
    with np.errstate(over="ignore"):
        changes = np.abs(is_now - was)[:, record.values]
    row, place = map(int, np.unravel_index(int(changes.argmax()), changes.shape))
    column = record.values[place]
    values = float(was[row, column]), float(is_now[row, column])
    return _compare_numbers(about, record, now, values, record.place(row, column))


def _compare_numbers(
    about: Subject,
    record: BoundedRecord,
    now: BoundedRecord,
    values: tuple[float, float],
    where: str = "",
) -> Finding:
    """The Finding of a recorded number and today's; where: the place to state before it."""
    was, is_now = values
    difference = abs(is_now - was)
    note = f"{where}: {was:.12g} -> {is_now:.12g}".removeprefix(": ")
    if record.unit != now.unit:
        return make_failed_check(about, f"recorded in {record.unit!r}, now in {now.unit!r}; {note}")
    if record.uncertainty is not None and record.uncertainty > (record.tolerance or 0.0):
        note += f" (numerical uncertainty {record.uncertainty:g})"
    moved = record.tolerance is not None and difference > record.tolerance
    # The lack of a tolerance counts as the widest that there may be.
    uncompared = math.inf if now.widest is None else now.widest
    granted = uncompared if record.tolerance is None else record.tolerance
    if not moved and now.tolerance is not None and granted > WIDENED * now.tolerance:
        tolerance_change = f"{record.tolerance} on record, {now.tolerance} now; renew the record"
        note = f"a tolerance that is not granted: {tolerance_change}; {note}"
        return make_failed_check(about, note)
    if record.tolerance is None:
        return make_measurement(about, measured=difference, basis=record.basis, note=note)
    return make_check(
        about, measured=difference, tolerance=record.tolerance, basis=record.basis, note=note
    )


def _key(what: str, name: str) -> ComparisonKey:
    return ComparisonKey(f"recorded-{what}", name, "", "")


def _subject(what: str, name: str, finding: Finding | None, unit: str) -> Subject:
    models = f" of {finding.left}~{finding.right}" if finding else ""
    return Subject(_key(what, name), unit, f"change of the {what}{models}", "the record")


def _run_subject(name: str, quantity: str, unit: str) -> Subject:
    key = ComparisonKey("recorded-run", name, quantity, "")
    return Subject(key, unit, "largest absolute change", "the record")

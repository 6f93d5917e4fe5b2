"""A cross-check held against a recorded one: what moved, by how much of what it may move."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from crosscheck.baseline import (
    BEST_FIRST,
    WIDEST,
    Baseline,
    Bounded,
    Extremes,
    Run,
    Sampled,
    differences,
)
from crosscheck.checks.trajectories import UNITS
from crosscheck.findings import Agreement, Finding, checked, failed, measured_only
from crosscheck.reduction import baseline_of, checks_by_id, measurements_by_id, reduced_run
from crosscheck.report.words import outcome
from crosscheck.run import CrossCheck

DIGEST = 12  # digits of a hash that a reader compares
# Measured uncertainties differ between machines, by less than this. A tolerance that is wider than
# today's by more was not granted by the program, or no longer is.
WIDENED = 100.0
_GONE = "disappeared"
_NEW = "appeared: nothing on record"


def compare(baseline: Baseline, result: CrossCheck) -> Agreement:
    """Every recorded result against the same result now, one check each.

    ``differ``: it moved beyond its tolerance; ``failed``: one of the two sides does not exist, or
    was made with other settings. ``left`` is ``recorded``, ``right`` the model. The provenance
    names the checks that are red as accepted in ``known``.
    """
    now = baseline_of(result)
    findings = [*_verdicts(baseline, now, result.agreement)]
    findings += _measurements(baseline, now, result.agreement)
    for key in sorted({*baseline.runs, *now.runs}):
        findings += _run_findings(key, baseline.runs.get(key), now.runs.get(key), result)
    record = baseline.provenance.model_dump(mode="json")
    known = [_verdict_id(name) for name in sorted(baseline.known)]
    return Agreement(findings, {**result.agreement.provenance, "recorded": record, "known": known})


def known_differences(agreement: Agreement) -> list[Finding]:
    """The checks that are red as they were accepted. agreement: as compare returns it."""
    known = set(agreement.provenance["known"])
    return [f for f in agreement.checks if f.id in known and f.verdict == "agree"]


def changed_since(agreement: Agreement) -> list[str]:
    """What differs between the record's surroundings and those now, such as `exudyn 1.13.6 -> 2`.

    agreement: as compare returns it.
    """
    now = agreement.provenance
    then = now["recorded"]
    names = ("python", "machine", "revision", "lock_sha256", "arm_sha256")
    before, after = ({**p["versions"], **{name: p[name] for name in names}} for p in (then, now))
    return [
        f"{name} {_brief(name, was)} -> {_brief(name, is_now)}"
        for name, was, is_now in differences(before, after)
    ]


def _brief(name: str, value: Any) -> str:
    return str(value)[:DIGEST] if name.endswith("sha256") else str(value)


def _verdicts(baseline: Baseline, now: Baseline, agreement: Agreement) -> Iterator[Finding]:
    findings = checks_by_id(agreement)
    for name in sorted({*baseline.checks, *now.checks}):
        was, finding = baseline.checks.get(name), findings.get(name)
        fields = _fields(_verdict_id(name), finding, "verdict", "1")
        if finding is None:
            yield failed(note=f"{_GONE}; was {was}", **fields)
        elif was is None:
            yield failed(note=f"{_NEW}; {finding.verdict}: {outcome(finding)}", **fields)
        elif was != finding.verdict:
            yield _turned(was, finding, fields)
        else:
            yield _unturned(name, baseline, now, finding, fields)


def _turned(was: str, finding: Finding, fields: dict[str, Any]) -> Finding:
    steps = BEST_FIRST.index(finding.verdict) - BEST_FIRST.index(was)
    way = "worse" if steps > 0 else "better"
    note = f"{way}: {was} -> {finding.verdict}: {outcome(finding)}"
    return checked(
        measured=float(abs(steps)), tolerance=0.0, basis="the same verdict", note=note, **fields
    )


def _unturned(
    name: str, baseline: Baseline, now: Baseline, finding: Finding, fields: dict[str, Any]
) -> Finding:
    """A check of the same verdict; one that is red must also be red by as much."""
    if finding.verdict == "agree":
        return checked(measured=0.0, tolerance=0.0, basis="the same verdict", **fields)
    said = f"known difference, {finding.verdict}: {outcome(finding)}"
    record, is_now = baseline.known[name].number, now.known[name].number
    if record is not None and is_now is not None:
        number = {**fields, "unit": finding.unit}
        found = _number(record, is_now, record.measured, is_now.measured, said, number)
        if found.kind == "check":
            return found
    return checked(measured=0.0, tolerance=0.0, basis="the same verdict", note=said, **fields)


def _measurements(baseline: Baseline, now: Baseline, agreement: Agreement) -> Iterator[Finding]:
    findings = measurements_by_id(agreement)
    for name in sorted({*baseline.measurements, *now.measurements}):
        record, is_now = baseline.measurements.get(name), now.measurements.get(name)
        finding = findings.get(name)
        fields = _fields(
            f"recorded-measurement/{name}", finding, "measurement", finding.unit if finding else ""
        )
        if is_now is None:
            yield failed(note=_GONE, **fields)
        elif record is None:
            yield failed(note=_NEW, **fields)
        else:
            yield _number(record, is_now, record.measured, is_now.measured, "", fields)


def _run_findings(
    key: str, record: Run | None, now: Run | None, result: CrossCheck
) -> Iterator[Finding]:
    if record is None:
        yield failed(note=_NEW, **_run_fields(key, "run", "1"))
    elif now is None:
        yield failed(note=f"{_GONE}: {_absence(key, result)}", **_run_fields(key, "run", "1"))
    elif moved := _moved_settings(record, now):
        note = f"other settings, numbers not compared: {'; '.join(moved)}"
        yield failed(note=note, **_run_fields(key, "settings", "1"))
    else:
        before, after = record.tables, now.tables
        for quantity in sorted({*before, *after}):
            yield _table(key, quantity, before.get(quantity), after.get(quantity))


def _absence(key: str, result: CrossCheck) -> str:
    """Why there is no such run now."""
    return str(reduced_run(key, result)) if key in result.runs else "no longer part of the plan"


def _moved_settings(record: Run, now: Run) -> list[str]:
    then, today = (
        run.model_dump(mode="json", include={"scenario", "switches"}) for run in (record, now)
    )
    return [f"{path} {was!r} -> {is_now!r}" for path, was, is_now in differences(then, today)]


def _table(
    key: str, quantity: str, record: Sampled | Extremes | None, now: Sampled | Extremes | None
) -> Finding:
    fields = _run_fields(key, quantity, UNITS[quantity])
    if now is None:
        return failed(note=f"{_GONE}: the run has no such quantity", **fields)
    if record is None:
        return failed(note=_NEW, **fields)
    was, is_now = np.array(record.rows), np.array(now.rows)
    if was.shape != is_now.shape or not np.array_equal(was[:, 0], is_now[:, 0]):
        return failed(note="recorded at other times or of another number of joints", **fields)
    with np.errstate(over="ignore"):
        apart = np.abs(is_now - was)[:, record.values]
    row, place = map(int, np.unravel_index(int(apart.argmax()), apart.shape))
    column = record.values[place]
    values = float(was[row, column]), float(is_now[row, column])
    return _number(record, now, *values, record.place(row, column), fields)


def _number(
    record: Bounded, now: Bounded, was: float, is_now: float, where: str, fields: dict[str, Any]
) -> Finding:
    apart = abs(is_now - was)
    note = f"{where}: {was:.12g} -> {is_now:.12g}".removeprefix(": ")
    if record.unit != now.unit:
        return failed(note=f"recorded in {record.unit!r}, now in {now.unit!r}; {note}", **fields)
    if record.uncertainty is not None and record.uncertainty > (record.tolerance or 0.0):
        note += f" (numerical uncertainty {record.uncertainty:g})"
    moved = record.tolerance is not None and apart > record.tolerance
    if not moved and _is_widened(record, now, fields["quantity"]):
        said = f"{record.tolerance} on record, {now.tolerance} now; renew the record"
        return failed(note=f"a tolerance that is not granted: {said}; {note}", **fields)
    values = {"measured": apart, "basis": record.basis, "note": note, **fields}
    if record.tolerance is None:
        return measured_only(**values)
    return checked(tolerance=record.tolerance, **values)


def _is_widened(record: Bounded, now: Bounded, quantity: str) -> bool:
    """Whether a tolerance on record, or the lack of one, is far from what is granted now."""
    if now.tolerance is None:
        return False
    widest = WIDEST.get("theta" if quantity == "tip" else quantity)
    uncompared = widest.value if widest else math.inf
    was = uncompared if record.tolerance is None else record.tolerance
    return was > WIDENED * now.tolerance


def _verdict_id(name: str) -> str:
    return f"recorded-verdict/{name}"


def _fields(name: str, finding: Finding | None, what: str, unit: str) -> dict[str, Any]:
    return {
        "id": name,
        "quantity": finding.quantity if finding else what,
        "unit": unit,
        "left": "recorded",
        "right": f"{finding.left}~{finding.right}" if finding else "now",
        "metric": f"change of the {what}",
    }


def _run_fields(key: str, quantity: str, unit: str) -> dict[str, Any]:
    return {
        "id": f"recorded-run/{key}/{quantity}",
        "quantity": quantity,
        "unit": unit,
        "left": "recorded",
        "right": key.split("/", 1)[-1],
        "metric": "largest absolute change",
    }

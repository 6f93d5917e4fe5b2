"""A cross-check held against a recorded one: what moved, by how much of what it may move."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import xarray as xr

from crosscheck.baseline import Baseline, Bounded, Run, differences
from crosscheck.findings import About, Agreement, Finding, Key, checked, failed, measured_only
from crosscheck.reduction import extreme_rows, is_recorded, per_joint, settings_of
from crosscheck.run import CrossCheck
from crosscheck.tasks import Failure, RunKey

BEST_FIRST = ("agree", "unresolved", "differ", "failed")
DIGEST = 12  # digits of a hash that a reader compares


def compare(baseline: Baseline, result: CrossCheck) -> Agreement:
    """Every recorded result against the same result now, one check each.

    ``differ``: it moved beyond its tolerance; ``failed``: one of the two sides does not exist, or
    was made with other settings. ``left`` is ``recorded``, ``right`` the model.
    """
    findings = [*_verdicts(baseline, result.agreement), *_measurements(baseline, result.agreement)]
    now = {str(key): key for key in result.runs if is_recorded(key)}
    for name in sorted({*baseline.runs, *now}):
        findings += _run_findings(name, baseline.runs.get(name), now.get(name), result)
    record = baseline.provenance.model_dump(mode="json")
    return Agreement(findings, {**result.agreement.provenance, "recorded": record})


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


def _verdicts(baseline: Baseline, agreement: Agreement) -> Iterator[Finding]:
    now = {finding.id: finding for finding in agreement.checks}
    for name in sorted({*baseline.checks, *now}):
        about = _about("recorded-verdict", name, now.get(name), "verdict", "1")
        if name not in now:
            yield failed(about, f"disappeared; was {baseline.checks[name]}")
        elif name not in baseline.checks:
            yield failed(about, f"appeared: {now[name].verdict}, nothing on record")
        else:
            yield _verdict(baseline.checks[name], now[name], about)


def _verdict(was: str, finding: Finding, about: About) -> Finding:
    steps = BEST_FIRST.index(finding.verdict) - BEST_FIRST.index(was)
    way = "worse" if steps > 0 else "better"
    note = f"{way}: {was} -> {finding.verdict} {finding.note}".strip() if steps else ""
    return checked(
        about, measured=float(abs(steps)), tolerance=0.0, basis="the same verdict", note=note
    )


def _measurements(baseline: Baseline, agreement: Agreement) -> Iterator[Finding]:
    now = {f.id: f for f in agreement.findings if f.kind == "measurement"}
    for name in sorted({*baseline.measurements, *now}):
        finding, record = now.get(name), baseline.measurements.get(name)
        unit = finding.unit if finding else record.unit if record else ""
        about = _about("recorded-measurement", name, finding, "measurement", unit)
        if finding is None or finding.measured is None:
            yield failed(about, "disappeared")
        elif record is None:
            yield failed(about, "appeared: nothing on record")
        else:
            yield _number(record, record.measured, finding.measured, "", about)


def _run_findings(
    name: str, record: Run | None, key: RunKey | None, result: CrossCheck
) -> Iterator[Finding]:
    outcome = None if key is None else result.runs[key]
    run = outcome if isinstance(outcome, xr.Dataset) else None
    if record is None:
        if run is not None:
            yield failed(_run_about(name, "run", "1"), "appeared: nothing on record")
        return
    if run is None:
        why = str(outcome) if isinstance(outcome, Failure) else "no longer part of the plan"
        yield failed(_run_about(name, "run", "1"), f"disappeared: {why}")
        return
    moved = _moved_settings(record, run)
    if moved:
        note = f"other settings, numbers not compared: {'; '.join(moved)}"
        yield failed(_run_about(name, "settings", "1"), note)
        return
    yield from _quantities(name, record, run)


def _moved_settings(record: Run, run: xr.Dataset) -> list[str]:
    scenario, switches = settings_of(run)
    now = {"scenario": scenario, "switches": switches}
    then = {"scenario": record.scenario, "switches": record.switches}
    return [f"{path} {was!r} -> {is_now!r}" for path, was, is_now in differences(then, now)]


def _quantities(key: str, record: Run, run: xr.Dataset) -> Iterator[Finding]:
    for quantity, sampled in sorted(record.sampled.items()):
        yield _compared(key, quantity, sampled, np.array(sampled.samples), run)
    for quantity, extremes in sorted(record.extremes.items()):
        yield _compared(key, quantity, extremes, np.array(extremes.extremes), run)


def _compared(
    key: str, quantity: str, record: Bounded, rows: np.ndarray, run: xr.Dataset
) -> Finding:
    about = _run_about(key, quantity, record.unit)
    if quantity not in run:
        return failed(about, "disappeared: the run has no such quantity")
    now = extreme_rows(run, quantity) if rows.shape[1] == 5 else _samples(run, quantity, rows[:, 0])
    if now is None or now.shape != rows.shape:
        return failed(about, "the record's rows do not fit the run")
    columns = np.array([1, 3]) if rows.shape[1] == 5 else np.arange(1, rows.shape[1])
    apart = np.abs(now - rows)[:, columns]
    row, place = np.unravel_index(int(apart.argmax()), apart.shape)
    column = int(columns[place])
    where = _place(rows[row], column)
    return _number(record, float(rows[row, column]), float(now[row, column]), where, about)


def _samples(run: xr.Dataset, quantity: str, times: np.ndarray) -> np.ndarray | None:
    """Rows of time and a value per joint at these times [s]; None if the run has not all."""
    grid = run["time"].values.round(10)
    at = np.searchsorted(grid, times.round(10)).clip(max=len(grid) - 1)
    if not np.array_equal(grid[at], times.round(10)):
        return None
    return np.column_stack([grid[at], per_joint(run, quantity)[at]])


def _place(row: np.ndarray, column: int) -> str:
    if len(row) == 5:
        return f"{'minimum' if column == 1 else 'maximum'} of joint {row[0]:.0f}"
    return f"joint {column} at {row[0]:g} s"


def _number(record: Bounded, was: float, is_now: float, where: str, about: About) -> Finding:
    apart = abs(is_now - was)
    note = f"{where}: {was:.12g} -> {is_now:.12g}".removeprefix(": ")
    if record.uncertainty is not None and record.uncertainty > (record.tolerance or 0.0):
        note += f" (numerical uncertainty {record.uncertainty:g})"
    relative = apart / abs(was) if was else None
    if record.tolerance is None:
        return measured_only(
            about, measured=apart, basis=record.basis, relative=relative, note=note
        )
    return checked(
        about,
        measured=apart,
        tolerance=record.tolerance,
        basis=record.basis,
        relative=relative,
        note=note,
    )


def _about(family: str, name: str, finding: Finding | None, quantity: str, unit: str) -> About:
    key = Key(family, name, "", "")
    models = f"{finding.left}~{finding.right}" if finding else "now"
    return About(key, unit, f"change of the {quantity} of {models}", "the record")


def _run_about(name: str, quantity: str, unit: str) -> About:
    return About(
        Key("recorded-run", name, quantity, ""), unit, "largest absolute change", "the record"
    )

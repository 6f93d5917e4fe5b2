"""What moved since a baseline, in the terminal."""

from __future__ import annotations

import math

from crosscheck.baseline.regression import changed_since, known_differences
from crosscheck.findings import Agreement, Finding
from crosscheck.report.words import counted, printable

MOST = 40  # lines; a real change moves everything at once, and the largest say enough


def print_moved(agreement: Agreement) -> None:
    """Everything that moved, largest first; known differences; what else changed; the count.

    agreement: as regression.compare returns it.
    """
    moved, known = sorted(agreement.red, key=_from_largest), known_differences(agreement)
    for finding in moved[:MOST]:
        print(printable(_line(finding)))
    if len(moved) > MOST:
        print(f"... and {counted(len(moved) - MOST, 'smaller one')} (all are in --junit)")
    for finding in known:
        print(printable(f"{finding.id}: {finding.note}"))
    changed = "; ".join(changed_since(agreement)) or "nothing"
    print(printable(f"changed since the record: {changed}"))
    left = f"; {counted(len(known), 'known difference')} left as accepted" if known else ""
    print(f"{len(moved)} of {counted(len(agreement.checks), 'recorded result')} moved{left}")


def _from_largest(finding: Finding) -> float:
    return -times_allowed(finding)


def times_allowed(finding: Finding) -> float:
    """How many tolerances a result moved by; inf for one that has gone, appeared or turned."""
    if finding.measured is None or not finding.tolerance:
        return math.inf
    return finding.measured / finding.tolerance


def _line(finding: Finding) -> str:
    if finding.measured is None or not finding.tolerance:
        return f"{finding.id}: {finding.note}"
    by = f"{finding.measured:.3g} {finding.unit}, {times_allowed(finding):.3g} x the allowed"
    return f"{finding.id}: moved by {by} {finding.tolerance:.3g}; {finding.note}"

"""What moved since a baseline, in the terminal."""

from __future__ import annotations

import math

from crosscheck.findings import Agreement, Finding
from crosscheck.regression import changed_since

MOST = 40  # lines; a real change moves everything at once, and the largest say enough


def print_moved(agreement: Agreement) -> None:
    """Everything that moved, largest first; what else changed since; the count."""
    moved = sorted(agreement.red, key=times_allowed, reverse=True)
    for finding in moved[:MOST]:
        print(_line(finding))
    if len(moved) > MOST:
        print(f"... and {len(moved) - MOST} smaller ones (all are in --junit)")
    print(f"changed since the record: {'; '.join(changed_since(agreement)) or 'nothing'}")
    print(f"{len(moved)} of {len(agreement.checks)} recorded results moved")


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

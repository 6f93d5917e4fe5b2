"""What has changed since a baseline, in the terminal."""

from __future__ import annotations

import math

from crosscheck.baseline.regression import changed_since, known_differences
from crosscheck.findings import Agreement, Finding
from crosscheck.report.words import counted, printable

MOST = 40  # lines; a real change concerns everything at once, and the largest say enough


def print_changed(agreement: Agreement) -> None:
    """Everything that has changed, largest first; known differences; what else changed; the count.

    agreement: as regression.compare returns it.
    """
    beyond = sorted(agreement.disagreeing, key=lambda finding: -times_allowed(finding))
    known = known_differences(agreement)
    for finding in beyond[:MOST]:
        print(printable(_line(finding)))
    if len(beyond) > MOST:
        print(f"... and {counted(len(beyond) - MOST, 'smaller one')} (all are in --junit)")
    for finding in known:
        print(printable(f"{finding.id}: {finding.note}"))
    changed = "; ".join(changed_since(agreement)) or "nothing"
    print(printable(f"changed since the record: {changed}"))
    left = f"; {counted(len(known), 'known difference')} left as accepted" if known else ""
    print(f"{len(beyond)} of {counted(len(agreement.checks), 'recorded result')} changed{left}")


def times_allowed(finding: Finding) -> float:
    """How many tolerances a result changed by; inf for one that has gone, appeared or turned."""
    if finding.measured is None or not finding.tolerance:
        return math.inf
    return finding.measured / finding.tolerance


def _line(finding: Finding) -> str:
    if finding.measured is None or not finding.tolerance:
        return f"{finding.id}: {finding.note}"
    by = f"{finding.measured:.3g} {finding.unit}, {times_allowed(finding):.3g} x the allowed"
    return f"{finding.id}: changed by {by} {finding.tolerance:.3g}; {finding.note}"

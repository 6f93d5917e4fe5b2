"""The Agreement in the terminal: as a table, or as what has changed since a baseline."""

from __future__ import annotations

import math

from rich.console import Console
from rich.table import Table
from rich.text import Text

from crosscheck.baseline.regression import changed_since, known_differences
from crosscheck.findings import Agreement, Finding
from crosscheck.models.arm.arm import Arm
from crosscheck.report.answers import QUESTIONS, answers
from crosscheck.report.matrix import cells, folded
from crosscheck.report.words import counted, outcome, printable, tally

MOST = 40  # lines; a real change concerns everything at once, and the largest say enough
COLOURS = {
    "agree": "green",
    "differ": "red",
    "unresolved": "yellow",
    "unfinished": "yellow",
    "failed": "red",
    "measured": "",
}


def print_answers(agreement: Agreement, arm: Arm) -> None:
    """Print the verdict, the three questions with their answers, all checks, the verdict again."""
    found = answers(agreement, arm)
    print(printable(found.verdict))
    texts = found.equations, found.rigid, found.trust
    for question, answer in zip(QUESTIONS, texts, strict=True):
        print(printable(f"{question} {answer}"))
    print()
    print_agreement(agreement)
    print(printable(found.verdict))


def print_agreement(agreement: Agreement) -> None:
    """Print the verdict matrix, then every check that is not green, then the count."""
    table = Table("left", "right", "verdict", "checks", "digits in common", box=None)
    for cell in folded(cells(agreement.findings)):
        digits = ", ".join(f"{value:.1f} {family}" for family, value in cell.digits.items())
        verdict = Text(cell.verdict, COLOURS[cell.verdict])
        table.add_row(
            Text(cell.left), Text(cell.right), verdict, str(cell.checks or "no limit"), digits
        )
    console = Console()
    console.print(table)
    for finding in agreement.disagreeing:
        told = printable(f" {finding.id}: {outcome(finding)}")
        line = Text.assemble((finding.verdict, COLOURS[finding.verdict]), told)  # never markup
        console.print(line, soft_wrap=True, highlight=False)
    print(tally(agreement))


def print_changed(agreement: Agreement) -> None:
    """Print what has changed, largest first; known differences; what else changed; the count.

    agreement: as regression.compare returns it.
    """
    beyond = sorted(agreement.disagreeing, key=lambda finding: -times_allowed(finding))
    known = known_differences(agreement)
    for finding in beyond[:MOST]:
        said = ""
        if finding.measured is not None and finding.tolerance:
            times = f"{times_allowed(finding):.3g} x the allowed {finding.tolerance:.3g}"
            said = f"changed by {finding.measured:.3g} {finding.unit}, {times}; "
        print(printable(f"{finding.id}: {said}{finding.note}"))
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

"""The Agreement as a table in the terminal."""

from __future__ import annotations

from rich.console import Console
from rich.table import Table
from rich.text import Text

from crosscheck.findings import Agreement
from crosscheck.models.arm.arm import Arm
from crosscheck.report.answers import QUESTIONS, answers
from crosscheck.report.matrix import cells, folded
from crosscheck.report.words import outcome, printable, tally

COLOURS = {
    "agree": "green",
    "differ": "red",
    "unresolved": "yellow",
    "unfinished": "yellow",
    "failed": "red",
    "measured": "",
}


def print_answers(agreement: Agreement, arm: Arm) -> None:
    """The three questions with their answers, a line each, then all checks as a table."""
    found = answers(agreement, arm)
    texts = found.equations, found.rigid, found.trust
    for question, answer in zip(QUESTIONS, texts, strict=True):
        print(printable(f"{question} {answer}"))
    print()
    print_agreement(agreement)


def print_agreement(agreement: Agreement) -> None:
    """Verdict matrix, then every check that is not green, then the count."""
    table = Table("left", "right", "verdict", "checks", "digits in common", box=None)
    for cell in folded(cells(agreement.findings)):
        digits = ", ".join(f"{value:.1f} {family}" for family, value in cell.digits.items())
        verdict = Text(cell.verdict, COLOURS[cell.verdict])
        table.add_row(Text(cell.left), Text(cell.right), verdict, str(cell.checks), digits)
    console = Console()
    console.print(table)
    for finding in agreement.disagreeing:
        told = printable(f" {finding.id}: {outcome(finding)}")
        line = Text.assemble((finding.verdict, COLOURS[finding.verdict]), told)  # never markup
        console.print(line, soft_wrap=True, highlight=False)
    print(tally(agreement))

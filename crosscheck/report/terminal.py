"""The Agreement as a table in the terminal."""

from __future__ import annotations

from rich.console import Console
from rich.table import Table

from crosscheck.findings import Agreement, Finding
from crosscheck.report.matrix import cells

COLOURS = {"agree": "green", "differ": "red", "unresolved": "yellow", "failed": "red"}


def print_agreement(agreement: Agreement) -> None:
    """Verdict matrix, then every check that is not green, then the count."""
    console = Console()
    console.print(_matrix(agreement))
    for finding in agreement.red:
        console.print(_line(finding), soft_wrap=True, highlight=False)
    agreeing = len(agreement.checks) - len(agreement.red)
    print(f"{agreeing} of {len(agreement.checks)} checks agree")


def _matrix(agreement: Agreement) -> Table:
    table = Table("left", "right", "verdict", "checks", "digits in common", box=None)
    for cell in cells(agreement.findings):
        digits = ", ".join(f"{value:.1f} {family}" for family, value in cell.digits.items())
        verdict = f"[{COLOURS[cell.verdict]}]{cell.verdict}[/]"
        table.add_row(cell.left, cell.right, verdict, str(cell.checks), digits)
    return table


def _line(finding: Finding) -> str:
    measured = "" if finding.measured is None else f" measured {finding.measured:.3g}"
    allowed = "" if finding.tolerance is None else f", allowed {finding.tolerance:.3g}"
    unit = f" {finding.unit}" if measured else ""
    return (
        f"[{COLOURS[finding.verdict]}]{finding.verdict}[/] {finding.id}:"
        f"{measured}{allowed}{unit} {finding.note}"
    )

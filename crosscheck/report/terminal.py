"""The Agreement in the terminal: as a table, or as what has changed since a baseline."""

from __future__ import annotations

from collections.abc import Sequence

from rich.console import Console
from rich.table import Table
from rich.text import Text

from crosscheck.findings import Agreement, Finding
from crosscheck.models.errors import make_printable
from crosscheck.models.mechanism import Mechanism
from crosscheck.report.answers import answer_questions
from crosscheck.report.finding_groups import describe_by_reason, tolerance_share
from crosscheck.report.formatting import describe_tally, format_count, format_unit, join_words
from crosscheck.report.matrix import collect_cells, fold_cells

MOST = 40  # lines; a real change concerns everything at once, and the largest say enough
MOST_FAILED = 10  # checks that `run` prints; the page has all
COLOURS = {
    "agree": "green",
    "differ": "red",
    "unresolved": "yellow",
    "unfinished": "yellow",
    "failed": "red",
    "measured": "",
}


def print_answers(agreement: Agreement, mechanism: Mechanism) -> None:
    """Print the verdict, the three questions with their answers, all checks, the verdict again."""
    report_answers = answer_questions(agreement, mechanism)
    print(make_printable(report_answers.verdict))
    texts = report_answers.equations, report_answers.rigid, report_answers.trust
    for question, answer in zip(report_answers.outline.questions, texts, strict=True):
        if answer:
            print(make_printable(f"{question} {answer}"))
    print()
    print_agreement(agreement)
    print(make_printable(report_answers.verdict))


def print_report_summary(agreement: Agreement, mechanism: Mechanism) -> None:
    """Print a line for each model, how far levels are off, and the verdict."""
    report_answers = answer_questions(agreement, mechanism)
    quantities = report_answers.outline.quantities
    table = Table("model", "verdict", *quantities.values(), box=None)
    for row in report_answers.rows:
        numbers = [row.number(quantity) for quantity in quantities]
        table.add_row(row.model, Text(row.verdict, COLOURS[row.verdict]), *numbers)
    Console().print(table)
    printed = [
        row.model for row in report_answers.rows if row.model in report_answers.outline.forms
    ]
    if printed:
        print(f"Printed in the paper, so measured and not checked: {join_words(printed)}.")
    if report_answers.rigid:
        print(make_printable(report_answers.rigid))
    _print_disagreeing(agreement.disagreeing[:MOST_FAILED])
    if len(agreement.disagreeing) > MOST_FAILED:
        print(f"... and {len(agreement.disagreeing) - MOST_FAILED} more on the page")
    print(describe_tally(agreement))
    print(make_printable(report_answers.verdict))


def _print_disagreeing(findings: Sequence[Finding]) -> None:
    """Print a line for each finding; those that failed for one reason have one line."""
    console = Console()
    for finding, words in describe_by_reason(findings):
        description = make_printable(f" {finding.id}: {words}")
        verdict = finding.verdict, COLOURS[finding.verdict]
        line = Text.assemble(verdict, description)  # never markup
        console.print(line, soft_wrap=True, highlight=False)


def print_agreement(agreement: Agreement) -> None:
    """Print the verdict matrix, then every check that is not green, then the count."""
    table = Table("left", "right", "verdict", "checks", "digits in common", box=None)
    for cell in fold_cells(collect_cells(agreement.findings)):
        digits = ", ".join(f"{value:.1f} {family}" for family, value in cell.digits.items())
        verdict = Text(cell.verdict, COLOURS[cell.verdict])
        ends, count = (Text(cell.left), Text(cell.right)), str(cell.checks or "no limit")
        table.add_row(*ends, verdict, count, digits)
    Console().print(table)
    _print_disagreeing(agreement.disagreeing)
    print(describe_tally(agreement))


def print_changed(agreement: Agreement) -> None:
    """Print what has changed, largest first; known differences; what else changed; the count.

    agreement: as regression.compare returns it.
    """
    from crosscheck.baseline.regression import describe_changes, find_accepted_differences

    beyond = sorted(agreement.disagreeing, key=lambda finding: -tolerance_share(finding))
    accepted_differences = find_accepted_differences(agreement)
    for finding in beyond[:MOST]:
        change = ""
        if finding.measured is not None and finding.tolerance:
            times = f"{tolerance_share(finding):.3g} x the allowed {finding.tolerance:.3g}"
            size = f"{finding.measured:.3g} {format_unit(finding.unit)}".rstrip()
            change = f"changed by {size}, {times}; "
        print(make_printable(f"{finding.id}: {change}{finding.note}"))
    if len(beyond) > MOST:
        print(f"... and {format_count(len(beyond) - MOST, 'smaller one')} (all are in --junit)")
    for finding in accepted_differences:
        print(make_printable(f"{finding.id}: {finding.note}"))
    changed = "; ".join(describe_changes(agreement)) or "nothing"
    print(make_printable(f"changed since the record: {changed}"))
    count = format_count(len(accepted_differences), "known difference")
    left = f"; {count} left as accepted" if accepted_differences else ""
    total = format_count(len(agreement.checks), "recorded result")
    print(f"{len(beyond)} of {total} changed{left}")

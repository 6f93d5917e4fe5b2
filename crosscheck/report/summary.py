"""A cross-check as a notebook shows it: a few lines, the heat map, a report."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from crosscheck.findings import Agreement, list_first
from crosscheck.models.errors import make_printable
from crosscheck.report.answers import describe_verdict, find_wrong_entries
from crosscheck.report.formatting import (
    describe_outcome,
    describe_tally,
    format_count,
    format_percent,
)
from crosscheck.report.heat_map import make_entry_maps
from crosscheck.report.rendering import render_page
from crosscheck.run import CrossCheck


@dataclass(frozen=True, repr=False)
class CheckResult(Agreement):
    """The Agreement of a cross-check, with its runs for the report."""

    cross_check: CrossCheck | None = None

    def __repr__(self) -> str:
        """The verdict, the count, and the largest of what is wrong."""
        return "\n".join(summarize_agreement(self))

    def _repr_html_(self) -> str:
        """The same with the heat map of the mass matrix, for a notebook."""
        maps = make_entry_maps(self.entries)
        return render_page("summary", lines=summarize_agreement(self), changes=(), maps=maps)

    def write_report(self, folder: Path | str) -> None:
        """Write index.html and agreement.json, as `crosscheck run` does. Raises InputError."""
        from crosscheck.report.html import write_report  # Matplotlib, for a page alone

        assert self.cross_check is not None  # as made by crosscheck.check
        write_report(self.cross_check, Path(folder))


def summarize_agreement(agreement: Agreement) -> list[str]:
    """The verdict, the count, and the largest of the failures, in lines."""
    lines = [describe_verdict(agreement)]
    measured = len(agreement.findings) - len(agreement.checks)
    more = f"; {format_count(measured, 'difference')} measured without a limit" if measured else ""
    lines.append(f"{describe_tally(agreement)}{more}")
    entries = find_wrong_entries(agreement.entries)
    wrong = [f"wrong {entry.name}: {format_percent(entry.relative)}" for entry in entries]
    failed = [f"{f.verdict} {f.id}: {describe_outcome(f)}" for f in agreement.disagreeing]
    return [make_printable(line) for line in (*lines, *list_first(failed or wrong))]

"""A cross-check as a notebook shows it: a few lines, the heat map, a report."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from crosscheck.findings import Agreement, list_first
from crosscheck.models.errors import make_printable
from crosscheck.output import write_files
from crosscheck.report.answers import describe_verdict, find_wrong_entries, format_agreement_json
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
        return render_agreement_summary(self)

    def write_report(self, folder: Path | str) -> None:
        """Write index.html and agreement.json, as `crosscheck run` does. Raises InputError."""
        from crosscheck.report.html import render_report_page  # Matplotlib, for a page alone
        from crosscheck.report.plots.charts import Charts

        assert self.cross_check is not None  # as made by make_check_result
        charts, target = Charts(), Path(folder)
        for key, run in self.cross_check.runs.items():
            charts.show(key, run)
        page = render_report_page(self.cross_check, charts.build_pictures())
        data = format_agreement_json(self, self.cross_check.mechanism)
        write_files({target / "index.html": page, target / "agreement.json": data})


def make_check_result(cross_check: CrossCheck) -> CheckResult:
    """The result of a cross-check."""
    return CheckResult(**vars(cross_check.agreement), cross_check=cross_check)


def summarize_agreement(agreement: Agreement) -> list[str]:
    """The verdict, the count, and the largest of the failures, in lines."""
    lines = [describe_verdict(agreement)]
    measured = len(agreement.findings) - len(agreement.checks)
    more = f"; {format_count(measured, 'difference')} measured without a limit" if measured else ""
    lines.append(f"{describe_tally(agreement)}{more}")
    wrong = [
        f"wrong {entry.name}: {format_percent(entry.relative)}"
        for entry in find_wrong_entries(agreement.entries)
    ]
    failed = [f"{f.verdict} {f.id}: {describe_outcome(f)}" for f in agreement.disagreeing]
    return [make_printable(line) for line in (*lines, *list_first(failed or wrong))]


def render_agreement_summary(agreement: Agreement) -> str:
    """HTML of the lines, and of the mass matrix entry by entry."""
    maps = make_entry_maps(agreement.entries)
    return render_page("summary", lines=summarize_agreement(agreement), changes=(), maps=maps)

"""What `crosscheck.check` returns: an agreement that shows itself and writes its report."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from crosscheck.findings import Agreement
from crosscheck.output import write_files
from crosscheck.report.answers import format_agreement_json
from crosscheck.report.summary import render_agreement_summary, summarize_agreement
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
    agreement = cross_check.agreement
    return CheckResult(
        agreement.findings, agreement.provenance, entries=agreement.entries, cross_check=cross_check
    )

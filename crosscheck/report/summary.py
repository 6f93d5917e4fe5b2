"""Results as a notebook shows them: a few lines, the heat map, a table of rows, a report."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from crosscheck.findings import MOST_LISTED, Agreement
from crosscheck.output import write_files
from crosscheck.report.answers import (
    describe_verdict,
    find_wrong_entries,
    format_agreement_json,
)
from crosscheck.report.formatting import (
    describe_outcome,
    describe_tally,
    format_count,
    format_percent,
    make_printable,
)
from crosscheck.report.heat_map import PART_NAMES, make_entry_maps, make_trial_maps
from crosscheck.report.rendering import render_page
from crosscheck.run import CrossCheck

if TYPE_CHECKING:
    import pandas as pd

    from crosscheck.trial.trial import Trial


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


def summarize_agreement(agreement: Agreement) -> list[str]:
    """The verdict, the count, and the largest of what is wrong, in lines."""
    lines = [describe_verdict(agreement)]
    measured = len(agreement.findings) - len(agreement.checks)
    more = f"; {format_count(measured, 'difference')} measured without a limit" if measured else ""
    lines.append(f"{describe_tally(agreement)}{more}")
    wrong = [
        f"wrong {entry.name}: {format_percent(entry.relative)}"
        for entry in find_wrong_entries(agreement.entries)
    ]
    failed = [f"{f.verdict} {f.id}: {describe_outcome(f)}" for f in agreement.disagreeing]
    return [make_printable(line) for line in (*lines, *_cut(failed or wrong))]


def summarize_trial(trial: Trial) -> list[str]:
    """Whose equations, how many checks agree, and what is wrong, in lines."""
    from crosscheck.report.trial import describe_errors, describe_notes, describe_trial

    title = next(describe_trial(trial))
    tally = describe_tally(trial.agreement)
    wrong = [f"wrong {line}" for line in describe_errors(trial)]
    notes = [f"note: {line}" for line in describe_notes(trial)]
    raised = [f"{part} raised" for part in trial.traces]
    return [make_printable(line) for line in (title, tally, *_cut(wrong), *_cut(notes), *raised)]


def render_agreement_summary(agreement: Agreement) -> str:
    """HTML of the lines, and of the mass matrix entry by entry."""
    maps = make_entry_maps(agreement.entries)
    return render_page("summary", lines=summarize_agreement(agreement), maps=maps)


def render_trial_summary(trial: Trial) -> str:
    """HTML of the lines, and of each part entry by entry."""
    return render_page("summary", lines=summarize_trial(trial), maps=list(make_trial_maps(trial)))


def tabulate_entries(trial: Trial) -> pd.DataFrame:
    """A row for each entry of each part: part, entry, relative difference, tolerance, agrees, why.

    An entry of the bias is what stands before a product of two rates.
    """
    import pandas as pd

    from crosscheck.report.trial import explain_wrong_entry
    from crosscheck.trial.judge.entries import entry_place, format_entry

    names = trial.problem.frame.names
    reasons = {each.place: explain_wrong_entry(each) for each in trial.wrong_entries}
    rows = []
    for quantity, relative in trial.relative_errors.items():
        for index, value in np.ndenumerate(relative):
            place = entry_place(quantity, index)
            if place.rates is not None and place.rates[0] > place.rates[1]:
                continue  # the same product of rates
            rows.append(
                {
                    "part": PART_NAMES.get(quantity, quantity),
                    "entry": format_entry(place, names),
                    "relative": value,
                    "tolerance": trial.allowed[quantity],
                    "agrees": bool(value <= trial.allowed[quantity]),
                    "why": reasons.get(place, ""),
                }
            )
    return pd.DataFrame(rows)


def write_trial_report(trial: Trial, folder: Path | str) -> None:
    """Write trial.html and trial.json, as `crosscheck trial` does. Raises InputError."""
    from crosscheck.report.trial import format_trial_json
    from crosscheck.report.trial_page import render_trial_page

    target = Path(folder)
    page, data = render_trial_page(trial), format_trial_json(trial)
    write_files({target / "trial.html": page, target / "trial.json": data})


def _cut(lines: list[str]) -> list[str]:
    """The first of the lines, and how many more there are."""
    more = len(lines) - MOST_LISTED
    return lines if more <= 0 else [*lines[:MOST_LISTED], f"... and {more} more"]

"""A trial as a notebook shows it: a few lines, heat maps, a table of rows, a report."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from crosscheck.findings import list_first
from crosscheck.output import write_files
from crosscheck.report.formatting import describe_tally, make_printable
from crosscheck.report.heat_map import PART_NAMES, make_trial_maps
from crosscheck.report.rendering import render_page
from crosscheck.report.trials.trial import (
    describe_errors,
    describe_notes,
    describe_trial,
    explain_wrong_entry,
    format_trial_json,
)
from crosscheck.trial.judge.entries import entry_place, format_entry
from crosscheck.trial.trial import Trial

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True, repr=False)
class TrialResult(Trial):
    """A Trial that prints itself, that a notebook shows, and that writes its report."""

    def __repr__(self) -> str:
        """Whose equations, how many checks agree, and what is wrong, in a few lines."""
        return "\n".join(summarize_trial(self))

    def _repr_html_(self) -> str:
        """The same with a heat map of each part, for a notebook."""
        return render_page("summary", lines=summarize_trial(self), maps=list(make_trial_maps(self)))

    def to_dataframe(self) -> pd.DataFrame:
        """A row for each entry: part, entry, relative difference, tolerance, agrees, why.

        An entry of the bias is what stands before a product of two rates.
        """
        import pandas as pd

        names = self.problem.frame.names
        reasons = {each.place: explain_wrong_entry(each) for each in self.wrong_entries}
        rows = []
        for quantity, relative in self.relative_errors.items():
            for index, value in np.ndenumerate(relative):
                place = entry_place(quantity, index)
                if place.rates is not None and place.rates[0] > place.rates[1]:
                    continue  # the same product of rates
                rows.append(
                    {
                        "part": PART_NAMES.get(quantity, quantity),
                        "entry": format_entry(place, names),
                        "relative": value,
                        "tolerance": self.allowed[quantity],
                        "agrees": bool(value <= self.allowed[quantity]),
                        "why": reasons.get(place, ""),
                    }
                )
        return pd.DataFrame(rows)

    def write_report(self, folder: Path | str) -> None:
        """Write trial.html and trial.json, as `crosscheck trial` does. Raises InputError."""
        # It imports Matplotlib, for a page alone.
        from crosscheck.report.trials.trial_page import render_trial_page

        target = Path(folder)
        page, data = render_trial_page(self), format_trial_json(self)
        write_files({target / "trial.html": page, target / "trial.json": data})


def summarize_trial(trial: Trial) -> list[str]:
    """Whose equations, how many checks agree, and what is wrong, in lines."""
    title, tally = next(describe_trial(trial)), describe_tally(trial.agreement)
    wrong = [f"wrong {line}" for line in describe_errors(trial)]
    changes = trial.source_answer.sentences if trial.source_answer else ()
    notes = [f"note: {line}" for line in describe_notes(trial)]
    raised = [f"{part} raised" for part in trial.traces]
    lines = (title, tally, *list_first(wrong), *changes, *list_first(notes), *raised)
    return [make_printable(line) for line in lines]

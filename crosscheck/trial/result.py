"""What every trial offers, of an arm or a robot: its answer in each view."""

from __future__ import annotations

from abc import ABC, abstractmethod
from pathlib import Path
from typing import TYPE_CHECKING

from crosscheck.findings import Agreement

if TYPE_CHECKING:
    import pandas as pd

    from crosscheck.report.trials.answer import TrialAnswer


class TrialResult(ABC):
    """A trial that prints itself, that a notebook shows, and that writes its report."""

    @property
    @abstractmethod
    def answer(self) -> TrialAnswer:
        """What the trial has to say, the most important first."""

    @property
    def agreement(self) -> Agreement:
        """All checks of the trial."""
        return self.answer.agreement

    @property
    def exit_code(self) -> int:
        """The exit code of the agreement."""
        return self.agreement.exit_code

    def __repr__(self) -> str:
        """The lines that the command prints."""
        return "\n".join(self.answer.lines)

    def _repr_html_(self) -> str:
        """The same with a heat map of each part, for a notebook."""
        from crosscheck.report.trials.output import render_summary

        return render_summary(self.answer)

    def to_dataframe(self) -> pd.DataFrame:
        """A row for each entry: part, entry, relative difference, tolerance, agrees, why."""
        import pandas as pd

        return pd.DataFrame(self.answer.rows)

    def write_report(self, folder: Path | str) -> None:
        """Write trial.html and trial.json, as `crosscheck trial` does. Raises InputError."""
        from crosscheck.output import write_files
        from crosscheck.report.trials.output import format_trial_json, render_trial_page

        target, answer = Path(folder), self.answer
        page, data = render_trial_page(answer), format_trial_json(answer)
        write_files({target / "trial.html": page, target / "trial.json": data})

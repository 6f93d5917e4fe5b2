"""The result of a trial of equations, and its answer in each view."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from crosscheck.findings import Agreement
from crosscheck.run import CrossCheck
from crosscheck.runner.outcomes import Failure
from crosscheck.trial.judge.checks import SelfCheck
from crosscheck.trial.judge.entries import EntryMismatch, LevelDistance
from crosscheck.trial.request import TrialRequest
from crosscheck.trial.source.source_edit import SourceAnswer

if TYPE_CHECKING:
    import pandas as pd

    from crosscheck.report.trials.answer import TrialAnswer
    from crosscheck.trial.changes.arms.dependence import IgnoredNumber


@dataclass(frozen=True)
class TrialDiagnosis:
    """Errors of equations and their explanations.

    Args:
        level: The level beside which they are: that of the fewest wrong entries, or the next at
            which one change explains all; '' of geared ones.
        entries: The entries that differ from it.
        notes: Sentences on units, on single parts and on entries.
        explanations: Words that complete `the equations of the level with ...`, each of which
            alone explains all.
        links: Links whose ten inertial parameters together would explain all, where nothing else
            does.
        readings: Other coordinates, in words, in which all is right; then no other reason is
            looked for.
        hidden: Entries that are right here, and not on other mechanisms of the structure.
        ignored_numbers: Numbers of the file that the equations do not follow, which those
            mechanisms keep.
        left_out: Names of all numbers that the equations do not follow, errors or not.
    """

    level: Any
    entries: tuple[EntryMismatch, ...] = ()
    notes: tuple[str, ...] = ()
    explanations: tuple[str, ...] = ()
    links: tuple[str, ...] = ()
    readings: tuple[str, ...] = ()
    hidden: tuple[EntryMismatch, ...] = ()
    ignored_numbers: tuple[IgnoredNumber, ...] = ()
    left_out: tuple[str, ...] = ()


@dataclass(frozen=True, repr=False)
class Trial:
    """Equations of an arm or a robot, judged. It prints itself, and a notebook shows it.

    Args:
        request: What was asked for.
        problem: The equations, and what they are compared with.
        cross_check: All findings, as a baseline records them.
        distances: How far the equations are from each level, the nearest first.
        diagnosis: What is wrong, and what explains it.
        relative_errors: By part, how far each entry is from the level's at most, relative to its
            size: M (n, n), terms of an arm's bias (n, n, n), others (n,).
        allowed: By part, what of the relative error is no error.
        failures: By part that did not answer, the reason.
        self_checks: What the equations owe to themselves, judged, unless the diagnosis has it.
        remarks: How the equations were read, and what was not judged.
        notes: Remarks that concern no error.
        is_single_precision: Whether a part's answers have no more digits than that.
        source_answer: What must change in the user's source, where a small edit mends it.
    """

    request: TrialRequest
    problem: Any
    cross_check: CrossCheck
    distances: tuple[LevelDistance, ...]
    diagnosis: TrialDiagnosis
    relative_errors: Mapping[str, np.ndarray]
    allowed: Mapping[str, float]
    failures: Mapping[str, Failure]
    self_checks: tuple[SelfCheck, ...]
    remarks: tuple[str, ...]
    notes: tuple[str, ...]
    is_single_precision: bool = False
    source_answer: SourceAnswer | None = None

    @property
    def agreement(self) -> Agreement:
        """All checks and measurements of the trial."""
        return self.cross_check.agreement

    @property
    def exit_code(self) -> int:
        """The exit code of the agreement."""
        return self.agreement.exit_code

    @property
    def agrees(self) -> bool:
        """Whether all that was judged agrees with the level and every engine."""
        return self.exit_code == 0

    @property
    def level(self) -> str:
        """The level that the equations are, or are closest to; '' of geared ones."""
        level: str = self.problem.name_level(self.diagnosis.level)
        return level

    @property
    def answer(self) -> TrialAnswer:
        """What the trial has to say, the most important first."""
        from crosscheck.report.trials.answer import answer_trial

        return answer_trial(self)

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

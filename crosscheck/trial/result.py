"""The result of a trial of equations, and what every view shows of it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from crosscheck.findings import Agreement
from crosscheck.report.finding_groups import describe_by_reason
from crosscheck.report.formatting import describe_tally, format_percent, format_rounded
from crosscheck.run import CrossCheck
from crosscheck.runner.outcomes import Failure
from crosscheck.trial.changes.search import list_equals
from crosscheck.trial.input.equations import SINGLE
from crosscheck.trial.input.source_lines import SourceLines, find_source
from crosscheck.trial.judge.checks import SelfCheck, has_engine_conflict
from crosscheck.trial.judge.entries import (
    PART_TITLES,
    ROUNDINGS,
    EntryMismatch,
    LevelDistance,
    entry_place,
    format_entry,
    select_counted,
)
from crosscheck.trial.request import TrialRequest
from crosscheck.trial.source.source_edit import SourceAnswer, SourceSearch

if TYPE_CHECKING:
    import pandas as pd

    from crosscheck.trial.changes.arms.dependence import IgnoredNumber

DIGITS = f"single precision (float32, {SINGLE:.0e} relative)"
MOST_CAUSES = 4  # causes that the terminal shows; the JSON file has all
# Verdicts that no wrong entry accounts for.
UNACCOUNTED = ("failed", "unfinished", "unresolved")


class PartDeviation(NamedTuple):
    """A part, its title in views, largest relative deviations of its entries, what is allowed."""

    part: str
    title: str
    relative: np.ndarray
    allowed: float


class TrialVerdict(NamedTuple):
    """What is wrong, or with what all agrees, without names of equations and mechanism.

    is_predicate: whether it continues a sentence that begins with these names.
    """

    text: str
    is_predicate: bool = False


@dataclass(frozen=True)
class TrialDiagnosis:
    """Errors of equations and their explanations.

    Args:
        level: The level beside which they are: that of the fewest wrong entries, or the next at
            which one change explains all; '' of geared ones.
        entries: The entries that differ from it.
        notes: Sentences on units, on single parts and on entries.
        unexplained: Sentences on what no change explains.
        explanations: Words that complete `the equations of the level with ...`, each of which
            alone explains all.
        is_unusual: Whether the first of these changes several numbers, or one to a value of no
            meaning.
        readings: Other coordinates, in words, in which all is right; then no other reason is
            looked for.
        hidden: Entries that are right here, and not on other mechanisms of the structure.
        ignored_numbers: Numbers of the file that the equations do not follow, which those
            mechanisms keep.
        left_out: Names of all numbers that the equations do not follow, errors or not.
        is_nearer_absolute: Whether far fewer entries are wrong if the angles are absolute.
    """

    level: Any
    entries: tuple[EntryMismatch, ...] = ()
    notes: tuple[str, ...] = ()
    unexplained: tuple[str, ...] = ()
    explanations: tuple[str, ...] = ()
    is_unusual: bool = False
    readings: tuple[str, ...] = ()
    hidden: tuple[EntryMismatch, ...] = ()
    ignored_numbers: tuple[IgnoredNumber, ...] = ()
    left_out: tuple[str, ...] = ()
    is_nearer_absolute: bool = False


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
        scope: How the equations were read, and what was not judged.
        notes: Remarks that concern no error.
        is_single_precision: Whether a part's answers have no more digits than that.
        search: The search of the user's source for the edit that mends it.
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
    scope: tuple[str, ...]
    notes: tuple[str, ...]
    is_single_precision: bool = False
    search: SourceSearch = field(default_factory=SourceSearch)

    @property
    def change(self) -> SourceAnswer | None:
        """What must change in the user's source, where a small edit mends it."""
        return self.search.answer

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
        return self.problem.name_level(self.diagnosis.level)

    @property
    def is_rounded(self) -> bool:
        """Whether rounding of float32 numbers explains all differences, which are no errors."""
        shares = [each.share for each in self.diagnosis.entries]
        return self.is_single_precision and 0 < max(shares, default=0) <= ROUNDINGS * SINGLE

    @property
    def wrong(self) -> tuple[EntryMismatch, ...]:
        """Entries that are not right."""
        if not self.is_rounded:
            return self.diagnosis.entries
        nothing: Any = {"explanation": None, "difference": ()}
        entries = self.diagnosis.entries
        return tuple(replace(each, notes=(DIGITS,), **nothing) for each in entries)

    @property
    def verdict(self) -> TrialVerdict:
        """What is wrong, or with what all agrees."""
        problem, wrong = self.problem, self.diagnosis.entries
        if self.is_rounded:
            return TrialVerdict(f"differs by the rounding of {DIGITS} alone", is_predicate=True)
        if readings := self.diagnosis.readings:
            words = f"is right in {' or in '.join(readings)}, and not in {', '.join(problem.names)}"
            return TrialVerdict(words, is_predicate=True)
        lost = [describe_lost(*each) for each in self.failures.items()][:1]
        if not self.relative_errors:
            return TrialVerdict("; ".join([*lost, "no part answered"]))
        compared, agreeing = problem.describe_level(self.diagnosis.level, self.distances)
        if wrong or self.exit_code:
            disagreeing = self.agreement.disagreeing
            is_rest_right = lost and all(each.verdict in UNACCOUNTED for each in disagreeing)
            others = "the rest agrees" if is_rest_right else "not all checks agree"
            faults = [*lost, describe_wrong(wrong) if wrong else others]
            return TrialVerdict(f"{'; '.join(faults)}; compared with {compared}")
        return TrialVerdict(f"agrees with {agreeing}", is_predicate=True)

    @property
    def causes(self) -> tuple[str, ...]:
        """What else explains it, the likeliest first: of all entries, then of single ones."""
        if self.is_rounded:
            return (f"its answers have {DIGITS}: with float64 in their place, they can be judged",)
        return tuple(self._list_causes())

    def _list_causes(self) -> Iterator[str]:
        diagnosis = self.diagnosis
        if has_engine_conflict(self.agreement.findings):
            yield "the engines differ on this mechanism: `crosscheck run` shows where"
        for check in self.self_checks:  # what follows from wrong entries alone has no words
            if check.finding.verdict in ("differ", "failed") and check.fault:
                yield f"{check.fault}{f' ({check.finding.note})' if check.finding.note else ''}"
        has_line = self.change is not None and self.change.is_whole
        is_needless = has_line and diagnosis.is_unusual
        first, *others = ("",) if is_needless else (diagnosis.explanations or ("",))
        if first:
            level, _ = self.problem.describe_level(diagnosis.level, self.distances)
            yield f"yours are the equations of {level} with {first}"
        if others:
            yield f"would also be explained by {list_equals(others)}"
        yield from diagnosis.notes
        if self.change is None or not self.change.is_whole:
            yield from diagnosis.unexplained

    @property
    def parts(self) -> list[PartDeviation]:
        """The parts, with the deviation of each entry."""
        return [
            PartDeviation(part, PART_TITLES.get(part, part), relative, self.allowed[part])
            for part, relative in self.relative_errors.items()
        ]

    @cached_property
    def sources(self) -> dict[str, SourceLines | None]:
        """The functions that answer wrong parts."""
        parts = dict.fromkeys(each.part for each in self.wrong)
        return {part: find_source(self.problem.equations, part) for part in parts}

    @property
    def traces(self) -> dict[str, str]:
        """Tracebacks of parts that raised, each once."""
        parts = dict[str, str]()
        for part, why in self.failures.items():
            parts.setdefault(why.trace, part)
        return {part: trace for trace, part in parts.items() if trace}

    @property
    def headline(self) -> str:
        """The verdict behind the names of equations and mechanism."""
        verdict, problem = self.verdict, self.problem
        link = " " if verdict.is_predicate else ": "
        return f"{problem.name} on {problem.mechanism.name}{link}{verdict.text}"

    @property
    def lines(self) -> Iterator[str]:
        """The lines of the terminal: what is wrong, the change that corrects it, evidence."""
        yield self.headline
        yield from self.search.sentences
        more = len(self.causes) - MOST_CAUSES
        yield from self.causes[: MOST_CAUSES if more > 1 else None]
        if more > 1:  # a line for one would take the place of that one
            yield f"and {more} more"
        yield from self.failing_checks
        yield from (f"note: {note}" for note in self.notes)
        yield from self.scope
        for part, trace in self.traces.items():
            yield f"{part} raised:"
            yield from trace.splitlines()
        yield describe_tally(self.agreement)

    @property
    def failing_checks(self) -> Iterator[str]:
        """Checks that do not agree although no wrong entry accounts for it."""
        findings = [
            finding
            for finding in self.agreement.disagreeing
            if not self.wrong or finding.verdict in UNACCOUNTED
        ]
        for finding, words in describe_by_reason(findings):
            yield f"{finding.verdict} {finding.id}: {words}"

    @property
    def first_error(self) -> str:
        """The change or cause that is first, else what is wrong; '' of no wrong entry."""
        if not self.wrong:
            return ""
        changes = self.change.sentences if self.change else ()
        return (*changes, *self.causes, self.verdict.text)[0]

    @property
    def rows(self) -> list[dict[str, Any]]:
        """A record for each entry of each part: its deviation, what is allowed, and the cause."""
        causes = {(each.part, each.name): each.cause for each in self.wrong}
        return [
            {
                "part": part.title,
                "entry": name,
                "relative": value,
                "tolerance": part.allowed,
                "agrees": bool(value <= part.allowed),
                "why": causes.get((part.part, name), ""),
            }
            for part in self.parts
            for name, value in name_entries(part, self.problem.names)
        ]

    def __repr__(self) -> str:
        """The lines that the command prints."""
        return "\n".join(self.lines)

    def _repr_html_(self) -> str:
        """The same with a heat map of each part, for a notebook."""
        from crosscheck.report.trials.output import render_summary

        return render_summary(self)

    def to_dataframe(self) -> pd.DataFrame:
        """A row for each entry: part, entry, relative difference, tolerance, agrees, why."""
        import pandas as pd

        return pd.DataFrame(self.rows)

    def write_report(self, folder: Path | str) -> None:
        """Write trial.html and trial.json, as `crosscheck trial` does. Raises InputError."""
        from crosscheck.output import write_files
        from crosscheck.report.trials.output import format_trial_json, render_trial_page

        target = Path(folder)
        page, data = render_trial_page(self), format_trial_json(self)
        write_files({target / "trial.html": page, target / "trial.json": data})


def name_entries(part: PartDeviation, names: Sequence[str]) -> Iterator[tuple[str, float]]:
    """Each entry of a part in words, and its deviation; of a product of rates once."""
    for place, value in np.ndenumerate(part.relative):
        if len(place) < 3 or place[1] <= place[2]:
            yield format_entry(entry_place(part.part, place), names), value


def describe_lost(part: str, why: Failure) -> str:
    """That a part did not answer, and why, without the state."""
    return f"{part} raised {why.reason}" if why.trace else f"{part} did not answer: {why.reason}"


def describe_wrong(wrong: Sequence[EntryMismatch]) -> str:
    """The entry that is wrong, how many others are, and by how much, in words."""
    wrong = select_counted(wrong)
    count, largest = len(wrong), max(each.share for each in wrong)
    others = f" and {count - 1} more {'entry' if count == 2 else 'entries'}" if count > 1 else ""
    verb, whose = ("are", "their") if count > 1 else ("is", "its")
    is_large, times = 10 <= largest < 1e6, f"{format_rounded(largest)} times"
    share = times if is_large else f"{format_percent(largest)} of"
    return f"{wrong[0].name}{others} {verb} wrong, by up to {share} {whose} natural size"

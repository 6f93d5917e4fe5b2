"""The answer of a trial, as a record: every view shows this and nothing else."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from crosscheck.checks.states import ROUNDINGS
from crosscheck.findings import Agreement, Finding
from crosscheck.report.finding_groups import describe_by_reason
from crosscheck.report.formatting import describe_tally, format_percent
from crosscheck.trial.changes.search import list_equals
from crosscheck.trial.input.equations import SINGLE
from crosscheck.trial.input.source_lines import SourceLines, find_source
from crosscheck.trial.judge.checks import AGAINST, SelfCheck
from crosscheck.trial.judge.entries import EntryMismatch, LevelDistance
from crosscheck.trial.result import Trial
from crosscheck.trial.source.source_edit import SourceAnswer

if TYPE_CHECKING:
    from crosscheck.trial.changes.arms.dependence import IgnoredNumber

DIGITS = f"single precision (float32, {SINGLE:.0e} relative)"
PART_TITLES = {"mass_matrix": "M", "rate_terms": "bias"}
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
class TrialAnswer:
    """What a trial has to say.

    Args:
        name: What reports call the equations.
        mechanism: Name of the arm or robot.
        description: Lines that describe it.
        level: The level that the equations are, or are closest to; '' of geared ones.
        coordinates: Names of the coordinates in which entries are named.
        verdict: What is wrong, or with what all agrees.
        change: What must change in the user's source, where a small edit corrects it.
        causes: What else explains it, the likeliest first.
        wrong: Entries that are not right.
        hidden: Entries that are right here, and not on other mechanisms of the same structure.
        scope: How the equations were read, and what could not be judged.
        notes: Remarks that concern no error.
        levels: How far the equations are from each level.
        unfollowed: Numbers of the file that the equations do not follow.
        sources: The functions that answer wrong parts.
        parts: The parts, with the deviation of each entry.
        traces: Tracebacks of parts that raised.
        agreement: All checks.
    """

    name: str
    mechanism: str
    description: tuple[str, ...]
    level: str
    coordinates: tuple[str, ...]
    verdict: TrialVerdict
    change: SourceAnswer | None
    causes: tuple[str, ...]
    wrong: tuple[EntryMismatch, ...]
    hidden: tuple[EntryMismatch, ...]
    scope: tuple[str, ...]
    notes: tuple[str, ...]
    levels: tuple[LevelDistance, ...]
    parts: tuple[PartDeviation, ...]
    traces: Mapping[str, str]
    agreement: Agreement
    unfollowed: tuple[IgnoredNumber, ...]
    sources: Mapping[str, SourceLines | None]

    def attribute_to_single_precision(self) -> TrialAnswer:
        """The answer on float32 numbers: differences that their rounding explains are no errors."""
        if not self.wrong or max(each.share for each in self.wrong) > ROUNDINGS * SINGLE:
            return self
        return replace(
            self,
            verdict=TrialVerdict(f"differs by the rounding of {DIGITS} alone", is_predicate=True),
            causes=(f"its answers have {DIGITS}: with float64 in their place, they can be judged",),
            wrong=tuple(
                replace(each, notes=(DIGITS,), explanation=None, difference=(), latex="")
                for each in self.wrong
            ),
        )

    @property
    def lines(self) -> Iterator[str]:
        """The lines of the terminal: what is wrong, the change that corrects it, evidence."""
        yield self.headline
        yield from self.change.sentences if self.change else ()
        yield from self.causes[:MOST_CAUSES]
        if len(self.causes) > MOST_CAUSES:
            yield f"and {len(self.causes) - MOST_CAUSES} more, all in --json and on the page"
        yield from self.failures
        yield from (f"note: {note}" for note in self.notes)
        yield from self.scope
        for part, trace in self.traces.items():
            yield f"{part} raised:"
            yield from trace.splitlines()
        yield describe_tally(self.agreement)

    @property
    def headline(self) -> str:
        """The verdict behind the names of equations and mechanism."""
        link = " " if self.verdict.is_predicate else ": "
        return f"{self.name} on {self.mechanism}{link}{self.verdict.text}"

    @property
    def failures(self) -> Iterator[str]:
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
            for name, value in name_entries(part, self.coordinates)
        ]


def name_entries(part: PartDeviation, names: Sequence[str]) -> Iterator[tuple[str, float]]:
    """Each entry of a part in words, and its deviation; of a product of rates once."""
    for place, value in np.ndenumerate(part.relative):
        words = [names[number] for number in place]
        if len(place) == 3:
            if place[1] <= place[2]:
                square = f"{words[1]}'^2" if place[1] == place[2] else f"{words[1]}' {words[2]}'"
                yield f"{part.title}[{words[0]}] of {square}", value
        else:
            yield f"{part.title}[{', '.join(words)}]", value


def answer_trial(trial: Trial) -> TrialAnswer:
    """The answer of a trial."""
    problem, diagnosis = trial.problem, trial.diagnosis
    wrong = diagnosis.entries
    traces = dict[str, str]()  # each once, of the part that raised it first
    for part, why in trial.failures.items():
        traces.setdefault(why.trace, part)
    answer = TrialAnswer(
        name=problem.name,
        mechanism=problem.mechanism.name,
        description=problem.description,
        level=trial.level,
        coordinates=tuple(problem.names),
        verdict=_describe_verdict(trial, wrong),
        change=trial.source_answer,
        causes=tuple(_describe_causes(trial)),
        wrong=wrong,
        hidden=diagnosis.hidden,
        scope=trial.remarks,
        notes=trial.notes,
        levels=trial.distances,
        parts=tuple(
            PartDeviation(part, PART_TITLES.get(part, part), relative, trial.allowed[part])
            for part, relative in trial.relative_errors.items()
        ),
        traces={part: trace for trace, part in traces.items() if trace},
        agreement=trial.agreement,
        unfollowed=diagnosis.ignored_numbers,
        sources={each.part: find_source(problem.equations, each.part) for each in wrong},
    )
    return answer.attribute_to_single_precision() if trial.is_single_precision else answer


def _describe_verdict(trial: Trial, wrong: Sequence[EntryMismatch]) -> TrialVerdict:
    """What is wrong, or with what all agrees."""
    problem, level = trial.problem, trial.diagnosis.level
    if readings := trial.diagnosis.readings:
        words = f"is right in {' or in '.join(readings)}, and not in {', '.join(problem.names)}"
        return TrialVerdict(words, is_predicate=True)
    if not trial.relative_errors:
        return TrialVerdict("no part answered")
    compared, agreeing = problem.describe_level(level, trial.distances)
    if wrong or trial.exit_code:
        fault = describe_wrong(wrong) if wrong else "not all checks agree"
        return TrialVerdict(f"{fault}; compared with {compared}")
    return TrialVerdict(f"agrees with {agreeing}", is_predicate=True)


def _describe_causes(trial: Trial) -> Iterator[str]:
    """Sentences on what explains the differences: of all entries, then of single ones."""
    diagnosis = trial.diagnosis
    if has_engine_conflict(trial.agreement.findings):
        yield "the engines differ on this mechanism: `crosscheck run` shows where"
    yield from describe_faults(trial.self_checks)
    first, *others = diagnosis.explanations or [""]
    if first:
        yield f"yours are the equations of {trial.level} with {first}"
    if others:
        yield f"would also be explained by {list_equals(others)}"
    for link in diagnosis.links:
        yield f"all of it is in {link}: its mass, centre of mass and inertia together explain it"
    yield from diagnosis.notes


def has_engine_conflict(findings: Sequence[Finding]) -> bool:
    """Whether engines judge a part in different ways, so that one of them must be wrong."""
    verdicts: dict[str, set[str]] = {}
    for finding in findings:
        if finding.about.key.family == AGAINST and finding.kind == "check":
            verdicts.setdefault(finding.quantity, set()).add(finding.verdict)
    return any(len(each) > 1 for each in verdicts.values())


def describe_faults(checks: Sequence[SelfCheck]) -> Iterator[str]:
    """Lines on what equations owe to themselves and do not keep.

    What follows from wrong entries alone, as a bias from a wrong M, is left out.
    """
    for check in checks:
        if check.finding.verdict in ("differ", "failed") and check.fault:
            yield f"{check.fault}{f' ({check.finding.note})' if check.finding.note else ''}"


def describe_wrong(wrong: Sequence[EntryMismatch]) -> str:
    """The entry that is wrong, how many others are, and by how much, in words."""
    count, largest = len(wrong), max(each.share for each in wrong)
    others = f" and {count - 1} more {'entry' if count == 2 else 'entries'}" if count > 1 else ""
    verb, whose = ("are", "their") if count > 1 else ("is", "its")
    share = format_percent(largest)
    return f"{wrong[0].name}{others} {verb} wrong, by up to {share} of {whose} size"

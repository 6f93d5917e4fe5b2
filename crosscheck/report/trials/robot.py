"""The answer of a trial on a robot: what is wrong with each entry, and what explains it."""

from __future__ import annotations

from collections.abc import Iterator
from operator import attrgetter

from crosscheck.models.robot.robot import LEVELS
from crosscheck.report.trials.answer import (
    EntryError,
    TrialAnswer,
    TrialVerdict,
    describe_entry_notes,
    describe_faults,
    describe_wrong,
    list_deviations,
    list_wrong,
)
from crosscheck.trial.changes.search import list_equals
from crosscheck.trial.robots.elastic import ELASTIC
from crosscheck.trial.robots.judge import has_engine_conflict
from crosscheck.trial.robots.trial import RobotTrial

NO_CAUSE = "no single number, frame or place explains it"


def answer_robot_trial(trial: RobotTrial) -> TrialAnswer:
    """The answer of a trial on a robot."""
    diagnosis = trial.diagnosis
    names = trial.robot.coordinate_names
    wrong = tuple(list_wrong(diagnosis.entries, names, trial.equations, attrgetter("remark")))
    answer = TrialAnswer(
        name=trial.name,
        mechanism=trial.robot.name,
        description=tuple(repr(trial.robot).splitlines()),
        level=trial.level,
        coordinates=tuple(trial.robot.coordinate_names),
        verdict=_describe_verdict(trial, wrong),
        change=trial.source_answer,
        causes=tuple(_describe_causes(trial)),
        wrong=wrong,
        hidden=(),
        scope=tuple(_describe_scope(trial)),
        notes=trial.robot.notes,
        levels=trial.distances,
        parts=tuple(list_deviations(trial.relative_errors, trial.allowed)),
        traces={part: why.trace for part, why in trial.failures.items() if why.trace},
        agreement=trial.checks,
    )
    return answer.attribute_to_single_precision() if trial.is_single_precision else answer


def _describe_verdict(trial: RobotTrial, wrong: tuple[EntryError, ...]) -> TrialVerdict:
    """What is wrong, or with what all agrees."""
    readings = trial.diagnosis.readings
    if not trial.parts:
        return TrialVerdict("no part answered")
    if readings:
        words = f"is right in {' or in '.join(readings)}, and not in the robot's own coordinates"
        return TrialVerdict(words, is_predicate=True)
    if wrong:
        return TrialVerdict(f"{describe_wrong(wrong)}; compared with {trial.level}")
    words = f"agrees with {_format_levels(trial)}, to {trial.largest:.1e}"
    return TrialVerdict(words, is_predicate=True)


def _format_levels(trial: RobotTrial) -> str:
    """The level that equations agree with, or all that are equal in their parts."""
    level = trial.level
    if level == ELASTIC:
        return f"{level} (links, motors on the output side, and springs between them)"
    equal = [each.level for each in trial.distances if not each.entries]
    if trial.stated or len(equal) == 1:
        return f"{level} ({LEVELS[trial.diagnosis.level]})"
    return f"{', '.join(equal)}, which are equal in these parts"


def _describe_causes(trial: RobotTrial) -> Iterator[str]:
    """Sentences on what explains the differences: of all entries, then of single ones."""
    diagnosis = trial.diagnosis
    if has_engine_conflict(trial.checks.findings):
        yield "the engines differ on this robot: `crosscheck cost` shows where"
    parts = {entry.part for entry in diagnosis.entries}
    yield from describe_faults([each for each in trial.self_checks if each.part not in parts])
    first, *others = diagnosis.explanations or [""]
    if first:
        yield f"yours are the equations of {trial.level} with {first}"
    if others:
        yield f"would also be explained by {list_equals(others)}"
    for link in diagnosis.links:
        yield f"all of it is in {link}: its mass, centre of mass and inertia together explain it"
    yield from diagnosis.notes
    reasons = diagnosis.explanations or diagnosis.links or diagnosis.notes or diagnosis.readings
    if diagnosis.entries and not reasons:
        yield from (
            describe_entry_notes(diagnosis.entries, trial.robot.coordinate_names)
            if any(entry.remark for entry in diagnosis.entries)
            else [NO_CAUSE]
        )


def _describe_scope(trial: RobotTrial) -> Iterator[str]:
    """Lines on how the equations were read, and what was not judged."""
    yield from trial.remarks
    if trial.not_judged:
        yield f"not judged: {', '.join(trial.not_judged)}"

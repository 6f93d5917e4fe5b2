"""A trial of a robot's equations as lines for the terminal and as JSON."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from crosscheck import __version__
from crosscheck.models.robot.robot import LEVELS
from crosscheck.report.formatting import describe_outcome, format_count, make_printable
from crosscheck.report.junit import format_junit
from crosscheck.report.records import format_json, to_json_value
from crosscheck.trial.robots.elastic import ELASTIC
from crosscheck.trial.robots.explain import list_equals
from crosscheck.trial.robots.judge import LETTERS, has_engine_conflict
from crosscheck.trial.robots.trial import RobotTrial

if TYPE_CHECKING:
    from crosscheck.report.heat_map import HeatMap

SCHEMA_VERSION = 1
MOST_ENTRIES, MOST_SENTENCES = 5, 12
NO_CAUSE = "no single number, frame or place explains it"


def format_lines(trial: RobotTrial) -> Iterator[str]:
    """Lines on what the equations are, which entries differ, and what explains it."""
    diagnosis = trial.diagnosis
    yield from first_lines(trial)
    yield from trial.remarks
    for entry in diagnosis.entries[:MOST_ENTRIES]:
        yield f"  {entry.name}: {entry.share:.2g} of its size{entry.remark and f'; {entry.remark}'}"
    if len(diagnosis.entries) > MOST_ENTRIES:
        yield f"  and {len(diagnosis.entries) - MOST_ENTRIES} more"
    yield from trial.source_answer.sentences if trial.source_answer else ()
    yield from diagnosis.notes[:MOST_SENTENCES]
    if len(diagnosis.notes) > MOST_SENTENCES:
        rest = format_count(len(diagnosis.notes) - MOST_SENTENCES, "more sentence")
        yield f"  and {rest}, all in --json"
    yield from _explanations(trial)
    yield from _disagreements(trial)
    for part, why in trial.failures.items():
        if why.trace:
            yield f"{part} raised:"
            yield from why.trace.splitlines()
    for note in trial.robot.notes:
        yield f"note: {note}"


def first_lines(trial: RobotTrial) -> Iterator[str]:
    """Lines on the level that the equations agree with or miss, and on parts not judged."""
    diagnosis, level = trial.diagnosis, trial.level
    left_out = f"; not judged: {', '.join(trial.not_judged)}" if trial.not_judged else ""
    if not trial.parts:
        yield f"no part answered{left_out}"
        return
    if not diagnosis.entries:
        parts = ", ".join(trial.parts)
        yield f"agrees with {_format_levels(trial)}: {parts}, to {trial.largest:.1e}{left_out}"
        return
    if diagnosis.readings:
        yield f"right in {diagnosis.readings[0]}: {', '.join(trial.parts)} of {level}"
        yield from (f"and right in {words}" for words in diagnosis.readings[1:])
        yield "wrong in the coordinates of the robot's joints:"
    wrong = {entry.part for entry in diagnosis.entries}
    parts = ", ".join(part for part in trial.parts if part in wrong)
    by = f"by up to {trial.largest:.2g} of an entry's size"
    yield f"wrong: {parts} off from {level} {by}{left_out}"


def describe_first_error(trial: RobotTrial) -> str:
    """The entry that differs most, and a cause, in one line; '' where no entry differs."""
    diagnosis = trial.diagnosis
    if not diagnosis.entries:
        return ""
    others = len(diagnosis.entries) - 1
    more = f" and {others} more" if others else ""
    causes = [f"right in {words}" for words in diagnosis.readings]
    causes += [f"as with {words}" for words in diagnosis.explanations]
    causes += [f"all of it is in {link}" for link in diagnosis.links]
    cause = (*causes[:1], *diagnosis.notes[::-1], NO_CAUSE)[0]
    return f"{diagnosis.entries[0].name}{more}: {cause}"


def _disagreements(trial: RobotTrial) -> Iterator[str]:
    """Sentences on failed checks that no wrong entry accounts for."""
    if has_engine_conflict(trial.agreement.findings):
        yield "the engines differ on this robot: `crosscheck cost` shows where"
    elif not trial.diagnosis.entries:
        for finding in trial.agreement.disagreeing:
            yield f"{finding.verdict} {finding.quantity}: {describe_outcome(finding)}"


def _format_levels(trial: RobotTrial) -> str:
    """The level that equations agree with, or all that are alike in their parts."""
    level = trial.level
    if level == ELASTIC:
        return f"{level} (links, motors on the output side, and springs between them)"
    alike = [each.level for each in trial.distances if not each.entries]
    if trial.stated or len(alike) == 1:
        return f"{level} ({LEVELS[trial.diagnosis.level]})"
    return f"{', '.join(alike)}, which are alike in these parts"


def _explanations(trial: RobotTrial) -> Iterator[str]:
    """Sentences on what explains all differences: one, and its equals at every state."""
    diagnosis = trial.diagnosis
    first, *others = diagnosis.explanations or [""]
    if first:
        yield f"yours are the equations of {trial.level} with {first}"
    if others:
        yield f"would also be explained by {list_equals(others)}"
    for link in diagnosis.links:
        yield f"all of it is in {link}: its mass, centre of mass and inertia together explain it"
    reasons = diagnosis.explanations or diagnosis.links or diagnosis.notes or diagnosis.readings
    if diagnosis.entries and not reasons:
        yield NO_CAUSE


def format_robot_trial(trial: RobotTrial) -> str:
    """JSON text of all results."""
    diagnosis = trial.diagnosis
    return format_json(
        {
            "schema_version": SCHEMA_VERSION,
            **_name_sources(trial),
            "parts": trial.parts,
            "remarks": trial.remarks,
            "not_judged": trial.not_judged,
            "agrees": trial.agrees,
            "level": trial.level,
            "levels": to_json_value(trial.distances),
            "largest_difference": trial.largest,
            "entries": [
                {
                    "entry": each.name,
                    "part": each.part,
                    "difference": each.share,
                    "told": each.remark,
                }
                for each in diagnosis.entries
            ],
            "notes": [*diagnosis.notes, *trial.robot.notes],
            "explanations": [{"with": words} for words in diagnosis.explanations],
            "links": diagnosis.links,
            "right_in": diagnosis.readings,
            "source_answer": to_json_value(trial.source_answer),
            "findings": [finding.to_dict() for finding in trial.agreement.findings],
        }
    )


def _name_sources(trial: RobotTrial) -> dict[str, object]:
    """Names of the equations and of the program that tried them."""
    program = f"geararm-crosscheck {__version__}"
    names = {"robot": trial.robot.name, "program": program, "equations": trial.name}
    return {**names, "seed": trial.seed}


def robot_trial_junit(trial: RobotTrial) -> str:
    """JUnit XML with a test case for each check."""
    properties = _name_sources(trial)
    return format_junit(trial.agreement, f"trial {trial.name} {trial.robot.name}", properties)


def robot_trial_summary(trial: RobotTrial) -> str:
    """HTML for notebooks: the lines of the terminal, and a heat map of each part."""
    from crosscheck.report.rendering import render_page

    lines = [make_printable(line) for line in format_lines(trial)]
    return render_page("summary", lines=lines, maps=_make_maps(trial))


def _make_maps(trial: RobotTrial) -> list[HeatMap]:
    """A heat map of each part."""
    from crosscheck.report.heat_map import make_entry_map

    return [
        make_entry_map(
            LETTERS.get(part, part), trial.robot.coordinate_names, errors, trial.allowed[part]
        )
        for part, errors in trial.relative_errors.items()
    ]


def robot_trial_page(trial: RobotTrial) -> str:
    """The page on a trial: HTML text."""
    from crosscheck.report.finding_groups import list_findings
    from crosscheck.report.rendering import WrongRow, render_page

    diagnosis, robot = trial.diagnosis, trial.robot
    headline = [*first_lines(trial), *trial.remarks]
    sentences = [*_explanations(trial), *_disagreements(trial)]
    return render_page(
        "trial",
        name=trial.name,
        subject=robot.name,
        agreement=trial.agreement,
        traces={part: why.trace for part, why in trial.failures.items() if why.trace},
        summary=[*headline, *(f"{name}: {value}" for name, value in _name_sources(trial).items())],
        wrong=[WrongRow(each.name, each.share, each.remark) for each in diagnosis.entries],
        verdicts=headline * bool(diagnosis.entries) + sentences,
        notes=[*diagnosis.notes, *robot.notes],
        maps=_make_maps(trial),
        allowed={LETTERS.get(part, part): value for part, value in trial.allowed.items()},
        listed=list_findings(trial.agreement.findings),
        sources=(),
        change=trial.source_answer,
        provenance=None,
    )

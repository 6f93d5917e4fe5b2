"""A trial of a robot's equations as lines for the terminal and as JSON."""

from __future__ import annotations

from collections.abc import Iterator

from crosscheck import __version__
from crosscheck.models.robot.robot import LEVELS
from crosscheck.report.records import document, plain
from crosscheck.report.words import counted, outcome
from crosscheck.trial.robots.explain import RobotDiagnosis
from crosscheck.trial.robots.judge import engines_differ
from crosscheck.trial.robots.trial import RobotTrial

SCHEMA_VERSION = 1
MOST_ENTRIES, MOST_SAID = 5, 12


def lines(trial: RobotTrial) -> Iterator[str]:
    """Lines on what the equations are, which entries differ, and what explains it."""
    found, level = trial.diagnosis, trial.diagnosis.level
    left_out = f"; not judged: {', '.join(trial.not_judged)}" if trial.not_judged else ""
    if not trial.parts:
        yield f"no part answered{left_out}"
    elif not found.entries:
        parts = ", ".join(trial.parts)
        yield f"agrees with {_levels(trial)}: {parts}, to {trial.largest:.1e}{left_out}"
    else:
        wrong = {entry.part for entry in found.entries}
        parts = ", ".join(part for part in trial.parts if part in wrong)
        by = f"by up to {trial.largest:.2g} of an entry's size"
        yield f"wrong: {parts} off from {level} {by}{left_out}"
    yield from _explained(found)
    if engines_differ(trial.agreement.findings):
        yield "the engines differ on this robot: `crosscheck cost` tells where"
    elif not found.entries:
        for finding in trial.agreement.disagreeing:
            yield f"{finding.verdict} {finding.quantity}: {outcome(finding)}"
    for part, why in trial.failures.items():
        if why.trace:
            yield f"{part} raised:"
            yield from why.trace.splitlines()
    for told in trial.robot.told:
        yield f"note: {told}"


def _levels(trial: RobotTrial) -> str:
    """The level that equations agree with, or all that are alike in their parts."""
    level = trial.diagnosis.level
    alike = [each.level for each in trial.distances if not each.entries]
    if trial.stated or len(alike) == 1:
        return f"{level} ({LEVELS[level]})"
    return f"{', '.join(alike)}, which are alike in these parts"


def _explained(found: RobotDiagnosis) -> Iterator[str]:
    for entry in found.entries[:MOST_ENTRIES]:
        yield f"  {entry.name}: {entry.share:.2g} of its size{entry.said and f'; {entry.said}'}"
    if len(found.entries) > MOST_ENTRIES:
        yield f"  and {len(found.entries) - MOST_ENTRIES} more"
    yield from found.notes[:MOST_SAID]
    if len(found.notes) > MOST_SAID:
        yield f"  and {counted(len(found.notes) - MOST_SAID, 'more sentence')}, all in --json"
    for words in found.explanations[:MOST_SAID]:
        yield f"yours are the equations of {found.level} with {words}"
    if len(found.explanations) > 1:
        yield "each of these alone makes the same equations"
    for link in found.links:
        yield f"all of it is in {link}: its mass, centre of mass and inertia together explain it"
    if found.entries and not (found.explanations or found.links or found.notes):
        yield "no single number, frame or place explains it"


def robot_trial_json(trial: RobotTrial) -> str:
    """JSON text of all that was found."""
    found = trial.diagnosis
    return document(
        {
            "schema_version": SCHEMA_VERSION,
            "robot": trial.robot.name,
            "program": f"geararm-crosscheck {__version__}",
            "equations": trial.name,
            "parts": trial.parts,
            "not_judged": trial.not_judged,
            "agrees": trial.agrees,
            "level": found.level,
            "levels": plain(trial.distances),
            "largest_difference": trial.largest,
            "entries": [
                {"entry": each.name, "part": each.part, "difference": each.share, "told": each.said}
                for each in found.entries
            ],
            "notes": [*found.notes, *trial.robot.told],
            "explanations": [{"with": words} for words in found.explanations],
            "links": found.links,
            "findings": [finding.to_dict() for finding in trial.agreement.findings],
        }
    )

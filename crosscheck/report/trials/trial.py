"""A trial in the terminal and as JSON."""

from __future__ import annotations

import io
from collections.abc import Iterator, Sequence
from contextlib import redirect_stdout
from typing import Any

from rich.console import Console
from rich.text import Text

from crosscheck.registry import RIGID_ARM, is_rigid_arm
from crosscheck.report.formatting import format_count, make_printable
from crosscheck.report.records import format_json, to_json_value
from crosscheck.report.terminal import print_agreement
from crosscheck.trial.changes.arms.dependence import IgnoredNumber
from crosscheck.trial.changes.arms.term_words import group_by_errors, guess
from crosscheck.trial.input.equations import SINGLE
from crosscheck.trial.input.source_lines import find_source
from crosscheck.trial.judge.entries import EntryMismatch, format_entry, format_wrong_entries
from crosscheck.trial.judge.unit_mistakes import DEGREES, UnitMistake
from crosscheck.trial.trial import Trial

SCHEMA_VERSION = 2


def print_trial(trial: Trial) -> None:
    """Print what was judged, the checks, the wrong entries, and why."""
    console = Console(soft_wrap=True, highlight=False)
    for line in describe_trial(trial):
        console.print(Text(make_printable(line)))
    print_agreement(trial.agreement)
    for verdict in describe_errors(trial):
        console.print(Text.assemble(("wrong ", "red"), make_printable(verdict)))
    for sentence in trial.source_answer.sentences if trial.source_answer else ():
        console.print(Text(make_printable(sentence)))
    for note in describe_notes(trial):
        console.print(Text.assemble(("note ", "yellow"), make_printable(note)))
    for part, trace in trial.traces.items():
        console.print(Text(f"{part} raised:"))
        for row in trace.splitlines():
            console.print(Text(make_printable(row)))


def format_trial(trial: Trial) -> str:
    """The text that print_trial prints."""
    text = io.StringIO()
    with redirect_stdout(text):
        print_trial(trial)
    return text.getvalue()


def describe_trial(trial: Trial) -> Iterator[str]:
    """Whose equations, in which coordinates, of which kind; what could not be judged."""
    problem = trial.problem
    is_only, kind = is_rigid_arm(problem.case.arm), f"geared, planets {problem.gearing}"
    if trial.level:
        kind = RIGID_ARM if is_only else f"rigid, level {trial.level}"
    yield f"{problem.name} on {problem.case.arm.name}: {kind}"
    for reading in trial.readings:
        yield f"right in {reading.words}{f': {reading.statement}' * bool(reading.statement)}"
    yield f"coordinates: {', '.join(problem.frame.names)}"
    for mismatch in trial.level_mismatches if is_only or len(trial.level_mismatches) > 1 else ():
        count = mismatch.entries
        differ = f"{count} entries of M differ" if count != 1 else "1 entry of M differs"
        largest = f", by up to {mismatch.largest:.3g}" if mismatch.entries else ""
        level = f"{mismatch.level} ({mismatch.description})"
        yield f"  against {f'the {RIGID_ARM}' if is_only else level}: {differ}{largest}"
    if trial.probes:
        other = format_count(len(trial.probes), "other arm")
        yield f"also checked on {other}, to catch errors that equal values here would hide"
    else:
        yield "checked on this arm alone: errors that its equal numbers and zeros hide are not seen"
    table = problem.equations.table
    if table is not None and table.precision:
        single = table.precision == SINGLE
        precision = "single precision" if single else "fewer digits than a double has"
        yield f"answers have {precision}, {table.precision:.2g} relative: the tolerances follow"
    for each in trial.unit_mistakes:
        yield describe_unit_mistake(each, problem.frame.names)
    if trial.missing:
        yield f"not supplied, so not judged: {', '.join(trial.missing)}"
    if problem.equations.unused:
        yield f"no part of equations, so not judged: {', '.join(problem.equations.unused)}"


def describe_unit_mistake(mistake: UnitMistake, names: Sequence[str]) -> str:
    """A line for the user on a part whose numbers seem to have another unit or order."""
    if mistake.factor is None:
        part = "M" if mistake.part == "mass_matrix" else mistake.part
        return f"{part} agrees once its numbers are read in another order: flattened the other way?"
    entries = format_wrong_entries(mistake.places, names).removeprefix("wrong: ")
    power = next(p for p in (1, -1, 2, -2) if mistake.factor in (1000.0**p, DEGREES**p))
    base = "1000" if mistake.factor == 1000.0**power else "180/pi"
    times = base if power == 1 else f"({base})^{power}"
    return f"{entries}: {times} times what the models say at every state: another unit?"


def describe_errors(trial: Trial) -> list[str]:
    """Errors, one line each, however many entries they appear in."""
    names = trial.problem.frame.names
    if trial.readings:
        places = [each.place for each in trial.wrong_entries]
        words = " or in ".join(reading.words for reading in trial.readings)
        listed = format_wrong_entries(places, names).removeprefix("wrong: ")
        return [f"in {', '.join(names)}, right in {words}: {listed}"]
    return list(_describe_entries(trial.wrong_entries, names))


def describe_notes(trial: Trial) -> Iterator[str]:
    """Remarks that are no errors on this arm: ignored numbers, and errors on other arms only."""
    if note := _describe_motors(trial):
        yield note
    if trial.point_masses:
        yield (
            f"Your equations have no {', '.join(trial.point_masses)}, and the file's are less than"
            " 1e-6 of mass x com^2: judged as point masses, with 0 in their place."
        )
    unfollowed = [each for each in trial.ignored_numbers if each.name not in trial.point_masses]
    if note := describe_unfollowed(unfollowed):
        yield note
    for line in _describe_entries(trial.hidden_entries, trial.problem.frame.names):
        yield f"Right on this arm. On others, whose numbers are unlike, this differs: {line}"


def _describe_motors(trial: Trial) -> str:
    """A note on joints without a motor, or of which a torque may be missing as they have none."""
    problem = trial.problem
    motors, joints = problem.motors, len(problem.case.arm.joints)
    if not motors:
        return "Your equations take no torque: judged as an arm without motors."
    numbers = ", ".join(str(joint + 1) for joint in motors)
    if len(motors) < joints:
        which = "joint" if len(motors) == 1 else "joints"
        return f"Judged as an arm with a motor at {which} {numbers} alone, as drive states."
    if problem.equations.drive is None and trial.idle_joints:
        idle = ", ".join(str(joint + 1) for joint in trial.idle_joints)
        which = "Joint" if len(trial.idle_joints) == 1 else "Joints"
        driven = [joint + 1 for joint in motors if joint not in trial.idle_joints]
        missing = f"{which} {idle}: no torque in your equations."
        return f"{missing} Has it no motor, state drive = {driven}."
    return ""


def _describe_entries(wrong: Sequence[EntryMismatch], names: Sequence[str]) -> Iterator[str]:
    groups = group_by_errors([each for each in wrong if not each.notes])
    explained = [group for group in groups if group[0].explanation]
    yield from (_describe_group(group, names) for group in explained)
    for note in dict.fromkeys(note for each in wrong for note in each.notes):
        places = [each.place for each in wrong if note in each.notes]
        yield f"{', '.join(format_entry(place, names) for place in places)}: {note}"
    yield from (_describe_group(group, names) for group in groups if group not in explained)


def _describe_group(group: Sequence[EntryMismatch], names: Sequence[str]) -> str:
    """Entries with the same error: what is wrong in the first one, and where else it is."""
    first, *others = group
    also = ", ".join(format_entry(each.place, names) for each in others)
    return describe_wrong_entry(first, names) + f"; also in {also}" * bool(others)


def describe_unfollowed(unfollowed: Sequence[IgnoredNumber]) -> str:
    """One note on all numbers of the arm's file that the equations do not follow; or ''.

    Of a number that is 0 in the file and in the equations there is nothing to say.
    """
    literal = [each for each in unfollowed if each.value and not each.goes_with]
    tied = [each for each in unfollowed if each.goes_with]
    sentences = []
    if literal:
        parts = list(dict.fromkeys(part for each in literal for part in each.parts))
        verb = "does" if len(parts) == 1 else "do"
        listed_numbers = ", ".join(f"{each.name} = {each.value:.6g}" for each in literal)
        it = "is it" if len(literal) == 1 else "are they"
        sentences.append(
            f"Your {_format_parts(parts)} {verb} not change with the file's {listed_numbers}:"
            f" {it} hard-coded?"
        )
    if tied:
        listed_ties = ", ".join(f"{t.name} from {' and '.join(t.goes_with)}" for t in tied)
        sentences.append(f"Your equations take {listed_ties}, which is right on this arm.")
    return " ".join((*sentences, "The trial went ahead with your values.")) if sentences else ""


def _format_parts(parts: Sequence[str]) -> str:
    words = ["M" if part == "mass_matrix" else part for part in parts]
    return " and ".join(filter(None, (", ".join(words[:-1]), words[-1])))


def describe_wrong_entry(wrong: EntryMismatch, names: Sequence[str]) -> str:
    """One wrong entry, and why, in one line."""
    return f"{format_entry(wrong.place, names)}: {explain_wrong_entry(wrong)}"


def format_trial_json(trial: Trial) -> str:
    """Readable JSON as in crosscheck/schema/trial.schema.json, ending in a newline."""
    problem, names = trial.problem, trial.problem.frame.names
    misread = [
        {
            "part": mistake.part,
            "kind": mistake.kind,
            "entries": [format_entry(place, names) for place in mistake.places],
            "factor": mistake.factor,
            "told": describe_unit_mistake(mistake, names),
        }
        for mistake in trial.unit_mistakes
    ]
    unfollowed = [
        {
            "number": each.name,
            "value": each.value,
            "parts": each.parts,
            "goes_with": dict(each.goes_with),
        }
        for each in trial.ignored_numbers
    ]
    return format_json(
        {
            "schema_version": SCHEMA_VERSION,
            "model": problem.name,
            "arm": problem.case.arm.name,
            "gearing": problem.gearing,
            "coordinates": names,
            "level": trial.level,
            "ladder": [
                {"level": r.level, "entries": r.entries, "largest": r.largest}
                for r in trial.level_mismatches
            ],
            "missing": trial.missing,
            "misread": misread,
            "wrong": _wrong_records(trial, trial.wrong_entries),
            "hidden": _wrong_records(trial, trial.hidden_entries),
            "unfollowed": unfollowed,
            "source_answer": to_json_value(trial.source_answer),
            "notes": list(describe_notes(trial)),
            "tracebacks": trial.traces,
            "agreement": trial.agreement.to_dict(),
        }
    )


def _wrong_records(trial: Trial, wrong: Sequence[EntryMismatch]) -> list[dict[str, Any]]:
    names, equations = trial.problem.frame.names, trial.problem.equations
    parts = {each.place.part for each in wrong}
    sources = {part: find_source(equations, part) for part in parts}
    places = {
        part: None if source is None else {"file": source.file, "line": source.first}
        for part, source in sources.items()
    }
    return [
        {
            **to_json_value(each.place),
            "entry": format_entry(each.place, names),
            "relative": each.relative,
            "told": describe_wrong_entry(each, names),
            "source": places[each.place.part],
            "difference": each.difference,
            "latex": each.latex,
            "shown_on": each.shown_on,
            "notes": each.notes,
            "explanation": to_json_value(each.explanation, errors="slips"),
        }
        for each in wrong
    ]


def explain_wrong_entry(wrong: EntryMismatch) -> str:
    """Notes on a wrong entry, else the guess at its error."""
    return ", ".join(wrong.notes) or guess(wrong)

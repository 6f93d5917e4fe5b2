"""The answer of a trial on an arm: what is wrong with each entry, and notes, in words."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from crosscheck.registry import LEVELS, RIGID_ARM, is_rigid_arm
from crosscheck.report.formatting import format_count
from crosscheck.report.trials.answer import (
    EntryError,
    TrialAnswer,
    TrialVerdict,
    UnfollowedNumber,
    describe_entry_notes,
    describe_faults,
    describe_wrong,
    list_deviations,
    list_wrong,
)
from crosscheck.trial.changes.arms.dependence import IgnoredNumber
from crosscheck.trial.changes.arms.term_words import group_by_errors, guess
from crosscheck.trial.input.equations import SINGLE
from crosscheck.trial.judge.entries import EntryMismatch, format_entry, format_wrong_entries
from crosscheck.trial.judge.unit_mistakes import DEGREES, UnitMistake
from crosscheck.trial.trial import Trial


def answer_arm_trial(trial: Trial) -> TrialAnswer:
    """The answer of a trial on an arm."""
    problem, names = trial.problem, trial.problem.frame.names
    shown = names, problem.equations, explain_wrong_entry
    wrong = tuple(list_wrong(trial.wrong_entries, *shown))
    answer = TrialAnswer(
        name=problem.name,
        mechanism=problem.case.arm.name,
        description=problem.case.arm.described,
        level=trial.level,
        coordinates=tuple(names),
        verdict=_describe_verdict(trial, wrong),
        change=trial.source_answer,
        causes=tuple(_describe_causes(trial)),
        wrong=wrong,
        hidden=tuple(list_wrong(trial.hidden_entries, *shown)),
        scope=tuple(_describe_scope(trial)),
        notes=tuple(describe_notes(trial)),
        levels=trial.distances,
        parts=tuple(list_deviations(trial.relative_errors, trial.allowed)),
        traces=trial.traces,
        agreement=trial.cross_check.agreement,
        unfollowed=tuple(
            UnfollowedNumber(each.name, each.value, each.parts, dict(each.goes_with))
            for each in trial.ignored_numbers
        ),
    )
    return answer.attribute_to_single_precision() if trial.is_single_precision else answer


def _describe_verdict(trial: Trial, wrong: Sequence[EntryError]) -> TrialVerdict:
    """What is wrong, or with what all agrees."""
    problem, level = trial.problem, trial.level
    if trial.readings:
        words = " or in ".join(
            f"{reading.words}{f' ({reading.statement})' * bool(reading.statement)}"
            for reading in trial.readings
        )
        names = ", ".join(problem.frame.names)
        return TrialVerdict(f"is right in {words}, and not in {names}", is_predicate=True)
    kind = description = f"geared equations, planets {problem.gearing}"
    if level and is_rigid_arm(problem.case.arm):
        kind = description = f"the {RIGID_ARM}"
    elif level:
        kind, description = level, f"{level} ({LEVELS[level]})"
    if wrong or trial.exit_code:
        fault = describe_wrong(wrong) if wrong else "not all checks agree"
        return TrialVerdict(f"{fault}; compared with {kind}")
    return TrialVerdict(f"agrees with {description}", is_predicate=True)


def _describe_causes(trial: Trial) -> Iterator[str]:
    """Lines on what equations owe to themselves, on wrong units, then on wrong entries."""
    names = trial.problem.frame.names
    yield from describe_faults(trial.self_checks)
    yield from (describe_unit_mistake(each, names) for each in trial.unit_mistakes)
    yield from describe_errors(trial)


def _describe_scope(trial: Trial) -> Iterator[str]:
    """Lines on what was judged, in which coordinates, and what could not be."""
    problem = trial.problem
    if trial.probes:
        others = format_count(len(trial.probes), "other arm")
        where = f"also on {others}, to catch errors that equal values here would hide"
    else:
        where = "on this arm alone: errors that its equal numbers and zeros hide are not seen"
    yield f"judged in {', '.join(problem.frame.names)}, {where}"
    table = problem.equations.table
    if table is not None and table.precision:
        single = table.precision == SINGLE
        precision = "single precision" if single else "fewer digits than a double has"
        yield f"answers have {precision}, {table.precision:.2g} relative: the tolerances follow"
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
    if trial.readings:  # in which nothing is wrong
        return []
    return list(_describe_entries(trial.wrong_entries, trial.problem.frame.names))


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
        yield f"Right on this arm. On others, whose numbers differ, this is wrong: {line}"


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
    yield from describe_entry_notes(wrong, names)
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


def explain_wrong_entry(wrong: EntryMismatch) -> str:
    """Notes on a wrong entry, else the guess at its error."""
    return wrong.remark or guess(wrong)

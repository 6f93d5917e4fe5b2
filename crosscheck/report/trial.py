"""A trial in the terminal and as JSON."""

from __future__ import annotations

import io
from collections.abc import Iterator, Sequence
from contextlib import redirect_stdout
from typing import Any

from rich.console import Console
from rich.text import Text

from crosscheck.report.records import document, plain
from crosscheck.report.terminal import print_agreement
from crosscheck.report.words import counted, printable
from crosscheck.trial.diagnose.dependence import Unfollowed
from crosscheck.trial.diagnose.explain import told_once
from crosscheck.trial.diagnose.words import guess
from crosscheck.trial.input.equations import SINGLE
from crosscheck.trial.judge.misread import DEGREES, Misread
from crosscheck.trial.judge.places import Wrong, listed, named
from crosscheck.trial.trial import Trial

SCHEMA_VERSION = 2


def print_trial(trial: Trial) -> None:
    """Print what was judged, the checks, the wrong entries, and why."""
    console = Console(soft_wrap=True, highlight=False)
    for said in summary(trial):
        console.print(Text(printable(said)))
    print_agreement(trial.agreement)
    for verdict in verdicts(trial):
        console.print(Text.assemble(("wrong ", "red"), printable(verdict)))
    for note in notes(trial):
        console.print(Text.assemble(("note ", "yellow"), printable(note)))
    for part, trace in trial.traces.items():
        console.print(Text(f"{part} raised:"))
        for row in trace.splitlines():
            console.print(Text(printable(row)))


def trial_text(trial: Trial) -> str:
    """The text that print_trial prints."""
    text = io.StringIO()
    with redirect_stdout(text):
        print_trial(trial)
    return text.getvalue()


def summary(trial: Trial) -> Iterator[str]:
    """Whose equations, in which coordinates, of which kind; what could not be judged."""
    problem = trial.problem
    kind = f"rigid, level {trial.level}" if trial.level else f"geared, planets {problem.gearing}"
    yield f"{problem.name} on {problem.case.arm.name}: {kind}"
    yield f"coordinates: {', '.join(problem.frame.names)}"
    for rung in trial.rungs if len(trial.rungs) > 1 else ():
        differ = f"{counted(rung.entries, 'entry').replace('entrys', 'entries')} of M differ"
        largest = f", by up to {rung.largest:.3g}" if rung.entries else ""
        yield f"  against {rung.level} ({rung.brings}): {differ}{largest}"
    if trial.probes:
        other = counted(len(trial.probes), "other arm")
        yield f"also checked on {other}, for errors that this one's equal numbers hide"
    else:
        yield "checked on this arm alone: errors that its equal numbers and zeros hide are not seen"
    table = problem.equations.table
    if table is not None and table.precision:
        single = table.precision == SINGLE
        known = "single precision" if single else "fewer digits than a double has"
        yield f"answers have {known}, {table.precision:.2g} relative: the tolerances follow"
    for each in trial.misread:
        yield misread_line(each, problem.frame.names)
    if trial.missing:
        yield f"not supplied, so not judged: {', '.join(trial.missing)}"
    if problem.equations.unused:
        yield f"no part of equations, so not judged: {', '.join(problem.equations.unused)}"


def misread_line(found: Misread, names: Sequence[str]) -> str:
    """A line for the user on a part whose numbers seem to have another unit or order."""
    if found.factor is None:
        part = "M" if found.part == "mass_matrix" else found.part
        return f"{part} agrees once its numbers are read in another order: flattened the other way?"
    entries = listed(found.places, names).removeprefix("wrong: ")
    power = next(p for p in (1, -1, 2, -2) if found.factor in (1000.0**p, DEGREES**p))
    base = "1000" if found.factor == 1000.0**power else "180/pi"
    times = base if power == 1 else f"({base})^{power}"
    return f"{entries}: {times} times what the models say at every state: another unit?"


def verdicts(trial: Trial) -> list[str]:
    """What is wrong, a line for each error, whatever number of entries it is in."""
    return list(_entry_lines(trial.wrong, trial.problem.frame.names))


def notes(trial: Trial) -> Iterator[str]:
    """What is no error on this arm: numbers that equations do not follow, errors on other arms."""
    if trial.problem.undriven:
        yield "Your equations take no torque: judged as an arm without motors."
    if trial.point_masses:
        yield (
            f"Your equations have no {', '.join(trial.point_masses)}, and the file's are less than"
            " 1e-6 of mass x com^2: judged as point masses, with 0 in their place."
        )
    unfollowed = [each for each in trial.unfollowed if each.name not in trial.point_masses]
    if unfollowed:
        yield unfollowed_line(unfollowed)
    for line in _entry_lines(trial.hidden, trial.problem.frame.names):
        yield f"Right on this arm. On others, whose numbers are unlike, this differs: {line}"


def _entry_lines(wrong: Sequence[Wrong], names: Sequence[str]) -> Iterator[str]:
    for note in dict.fromkeys(note for each in wrong for note in each.notes):
        places = [each.place for each in wrong if note in each.notes]
        yield f"{', '.join(named(place, names) for place in places)}: {note}"
    for group in told_once([each for each in wrong if not each.notes]):
        first, *others = group
        also = f"; also in {', '.join(named(w.place, names) for w in others)}" if others else ""
        yield wrong_line(first, names) + also


def unfollowed_line(unfollowed: Sequence[Unfollowed]) -> str:
    """One note on all numbers of the arm's file that the equations do not follow."""
    literal = [each for each in unfollowed if each.value and not each.goes_with]
    tied = [each for each in unfollowed if each.goes_with]
    absent = [each.name for each in unfollowed if not each.value and not each.goes_with]
    sentences = []
    if literal:
        parts = list(dict.fromkeys(part for each in literal for part in each.parts))
        verb = "does" if len(parts) == 1 else "do"
        listed_numbers = ", ".join(f"{each.name} = {each.value:.6g}" for each in literal)
        it = "is it" if len(literal) == 1 else "are they"
        sentences.append(
            f"Your {_in_words(parts)} {verb} not follow the file's {listed_numbers}:"
            f" {it} written in your code?"
        )
    if tied:
        listed_ties = ", ".join(f"{t.name} from {' and '.join(t.goes_with)}" for t in tied)
        sentences.append(f"Your equations take {listed_ties}, which is right on this arm.")
    if absent:
        sentences.append(f"Your equations have no {', '.join(absent)}, nor has this arm.")
    return " ".join((*sentences, "Judged with these numbers as they are."))


def _in_words(parts: Sequence[str]) -> str:
    words = ["M" if part == "mass_matrix" else part for part in parts]
    return " and ".join(filter(None, (", ".join(words[:-1]), words[-1])))


def wrong_line(wrong: Wrong, names: Sequence[str]) -> str:
    """One wrong entry, and why, in one line."""
    return f"{named(wrong.place, names)}: {why(wrong)}"


def trial_json(trial: Trial) -> str:
    """Readable JSON as in crosscheck/schema/trial.schema.json, ending in a newline."""
    problem, names = trial.problem, trial.problem.frame.names
    misread = [
        {
            "part": found.part,
            "kind": found.kind,
            "entries": [named(place, names) for place in found.places],
            "factor": found.factor,
            "told": misread_line(found, names),
        }
        for found in trial.misread
    ]
    unfollowed = [
        {
            "number": each.name,
            "value": each.value,
            "parts": each.parts,
            "goes_with": dict(each.goes_with),
        }
        for each in trial.unfollowed
    ]
    return document(
        {
            "schema_version": SCHEMA_VERSION,
            "model": problem.name,
            "arm": problem.case.arm.name,
            "gearing": problem.gearing,
            "coordinates": names,
            "level": trial.level,
            "ladder": [
                {"level": r.level, "entries": r.entries, "largest": r.largest} for r in trial.rungs
            ],
            "missing": trial.missing,
            "misread": misread,
            "wrong": _wrong_records(trial.wrong, names),
            "hidden": _wrong_records(trial.hidden, names),
            "unfollowed": unfollowed,
            "notes": list(notes(trial)),
            "tracebacks": trial.traces,
            "agreement": trial.agreement.to_dict(),
        }
    )


def _wrong_records(wrong: Sequence[Wrong], names: Sequence[str]) -> list[dict[str, Any]]:
    return [
        {
            **plain(each.place),
            "entry": named(each.place, names),
            "relative": each.relative,
            "told": wrong_line(each, names),
            "difference": each.difference,
            "latex": each.latex,
            "shown_on": each.shown_on,
            "notes": each.notes,
            "explanation": plain(each.explanation, errors="slips"),
        }
        for each in wrong
    ]


def why(wrong: Wrong) -> str:
    """Notes on a wrong entry, else the guess at its error."""
    return ", ".join(wrong.notes) or guess(wrong)

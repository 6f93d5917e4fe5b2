"""A trial in the terminal and as JSON."""

from __future__ import annotations

import io
from collections.abc import Iterator, Sequence
from contextlib import redirect_stdout
from typing import NamedTuple

from rich.console import Console
from rich.text import Text

from crosscheck.report.records import document, plain
from crosscheck.report.terminal import print_agreement
from crosscheck.report.words import counted, printable
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
        word = ("hidden ", "yellow") if verdict.hidden else ("wrong ", "red")
        console.print(Text.assemble(word, printable(verdict.text)))
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


class VerdictLine(NamedTuple):
    """A line on what is wrong; hidden: whether the numbers of the arm on trial hide it."""

    text: str
    hidden: bool = False


def verdicts(trial: Trial) -> Iterator[VerdictLine]:
    """What is wrong, a line for each error, whatever number of entries it is in."""
    names = trial.problem.frame.names
    for note in dict.fromkeys(note for wrong in trial.wrong for note in wrong.notes):
        places = [wrong.place for wrong in trial.wrong if note in wrong.notes]
        yield VerdictLine(f"{', '.join(named(place, names) for place in places)}: {note}")
    for group in told_once([wrong for wrong in trial.wrong if not wrong.notes]):
        first, *others = group
        also = f"; also in {', '.join(named(w.place, names) for w in others)}" if others else ""
        yield VerdictLine(wrong_line(trial, first) + also, bool(first.shown_on))


def wrong_line(trial: Trial, wrong: Wrong) -> str:
    """One wrong entry, and why, in one line."""
    return f"{named(wrong.place, trial.problem.frame.names)}: {why(wrong)}"


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
    wrong = [
        {
            **plain(each.place),
            "entry": named(each.place, names),
            "relative": each.relative,
            "told": wrong_line(trial, each),
            "difference": each.difference,
            "latex": each.latex,
            "shown_on": each.shown_on,
            "notes": each.notes,
            "explanation": plain(each.explanation, errors="slips"),
        }
        for each in trial.wrong
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
            "wrong": wrong,
            "tracebacks": trial.traces,
            "agreement": trial.agreement.to_dict(),
        }
    )


def why(wrong: Wrong) -> str:
    """Notes on a wrong entry, else the guess at its error."""
    shown = f" (not on this arm, but on {wrong.shown_on})" if wrong.shown_on else ""
    return (", ".join(wrong.notes) or guess(wrong)) + shown

"""A trial as one page, which draws and typesets: Matplotlib is for whoever asks for one."""

from __future__ import annotations

import io
from collections.abc import Iterator, Sequence

from matplotlib.figure import Figure

from crosscheck.models.arm.arm import describe_arm
from crosscheck.report.finding_groups import list_findings
from crosscheck.report.heat_map import PART_NAMES, make_trial_maps
from crosscheck.report.rendering import WrongRow, render_page
from crosscheck.report.trials.trial import (
    describe_errors,
    describe_notes,
    describe_trial,
    explain_wrong_entry,
)
from crosscheck.trial.changes.arms.term_words import describe_term_error
from crosscheck.trial.changes.arms.typeset_errors import Piece, typeset_error
from crosscheck.trial.input.source_lines import SourceLines, find_source
from crosscheck.trial.judge.entries import TermError, format_entry
from crosscheck.trial.trial import Trial

POINTS = 11
WRONG, RIGHT = "#b3261e", "#1a6e3f"


def render_trial_page(trial: Trial) -> str:
    """The page on a trial: HTML text, figures inlined."""
    names = trial.problem.frame.names
    return render_page(
        "trial",
        name=trial.problem.name,
        subject=trial.problem.case.arm.name,
        agreement=trial.agreement,
        traces=trial.traces,
        summary=list(describe_trial(trial)),
        wrong=[
            WrongRow(
                format_entry(w.place, names),
                w.relative,
                explain_wrong_entry(w),
                w.latex,
                w.explanation,
            )
            for w in trial.wrong_entries
        ],
        verdicts=describe_errors(trial),
        notes=list(describe_notes(trial)),
        maps=list(make_trial_maps(trial)),
        allowed={PART_NAMES.get(name, name): value for name, value in trial.allowed.items()},
        described=list(describe_arm(trial.problem.case.arm)),
        typeset=render_formula,
        pairs=_typeset_pairs,
        sources=() if trial.source_answer else _find_sources(trial),
        change=trial.source_answer,
        words=lambda errors: " and ".join(map(describe_term_error, errors)),
        listed=list_findings(trial.agreement.findings),
        provenance=trial.agreement.to_dict()["provenance"],
    )


def _typeset_pairs(errors: Sequence[TermError]) -> Iterator[tuple[str, str]]:
    """Yours and right of each error as SVG, what differs in colour."""
    for error in errors:
        typeset = typeset_error(error)
        if typeset is not None:
            yield render_pieces(typeset.yours, WRONG), render_pieces(typeset.right, RIGHT)


def _find_sources(trial: Trial) -> list[SourceLines]:
    """The user's functions that have a wrong entry."""
    parts = dict.fromkeys(each.place.part for each in trial.wrong_entries)
    found = (find_source(trial.problem.equations, part) for part in parts)
    return [source for source in found if source is not None]


def render_formula(latex: str) -> str:
    """A formula as SVG; '' for none, and for one that cannot be set."""
    return render_pieces((Piece(latex),), "black") if latex else ""


def render_pieces(pieces: Sequence[Piece], colour: str) -> str:
    """Pieces of a formula in a row as SVG, marked ones in colour; '' where one cannot be set."""
    figure = Figure(figsize=(0.1, 0.1))
    text, at = io.StringIO(), 0.0
    try:
        for piece in pieces:
            shown = figure.text(at, 0, f"${piece.latex}$", fontsize=POINTS)
            shown.set_color(colour if piece.is_marked else "black")
            at += shown.get_window_extent().width / figure.bbox.width
        figure.savefig(text, format="svg", bbox_inches="tight", pad_inches=0.02, transparent=True)
    except ValueError:  # what matplotlib's own TeX does not know
        return ""
    drawing = text.getvalue()
    return drawing[drawing.index("<svg") :]

"""Formulas of a trial's page as drawings: Matplotlib's own TeX, loaded for a page alone."""

from __future__ import annotations

import io
from collections.abc import Iterator, Sequence

from matplotlib.figure import Figure

from crosscheck.trial.changes.arms.term_words import describe_term_error
from crosscheck.trial.changes.arms.typeset_errors import Piece, typeset_error
from crosscheck.trial.judge.entries import TermError

POINTS = 11
WRONG, RIGHT = "#b3261e", "#1a6e3f"


def render_pairs(errors: Sequence[TermError]) -> Iterator[tuple[str, str]]:
    """Yours and right of each error as SVG, what differs in colour."""
    for error in errors:
        typeset = typeset_error(error)
        if typeset is not None:
            yield render_pieces(typeset.yours, WRONG), render_pieces(typeset.right, RIGHT)


def describe_errors(errors: Sequence[TermError]) -> str:
    """Errors of terms in words."""
    return " and ".join(map(describe_term_error, errors))


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

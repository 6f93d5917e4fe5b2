"""Formulas as drawings inside a page, which then needs no script and no font from elsewhere."""

from __future__ import annotations

import io

from matplotlib.figure import Figure

POINTS = 11


def typeset(latex: str) -> str:
    """A formula as SVG; '' for none, and for one that cannot be set."""
    if not latex:
        return ""
    figure = Figure(figsize=(0.1, 0.1))
    figure.text(0, 0, f"${latex}$", fontsize=POINTS)
    text = io.StringIO()
    try:
        figure.savefig(text, format="svg", bbox_inches="tight", pad_inches=0.02, transparent=True)
    except ValueError:  # what matplotlib's own TeX does not know
        return ""
    drawing = text.getvalue()
    return drawing[drawing.index("<svg") :]

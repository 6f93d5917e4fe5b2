"""TeX as a picture that needs no script."""

from __future__ import annotations

import matplotlib as mpl
from matplotlib.figure import Figure

from crosscheck.report.figures import to_svg


def formula_svg(text: str) -> str:
    """A TeX formula as an <svg> element, by matplotlib's own typesetter."""
    with mpl.rc_context({"mathtext.fontset": "cm"}):
        figure = Figure(figsize=(0.1, 0.1))
        drawn = figure.text(0, 0, f"${_mathtext(text)}$", fontsize=13)
        box = drawn.get_window_extent()
        figure.set_size_inches((box.width + 8) / figure.dpi, (box.height + 8) / figure.dpi)
        drawn.set_position((4 / (box.width + 8), 4 / (box.height + 8) - box.y0 / (box.height + 8)))
        return to_svg(figure)


def _mathtext(text: str) -> str:
    """Without the few commands that the typesetter does not know."""
    return text.replace(r"\left", "").replace(r"\right", "")

"""Formulas as TeX, and TeX as a picture that needs no script."""

from __future__ import annotations

import re

import matplotlib as mpl
import sympy as sp
from matplotlib.figure import Figure

from crosscheck.report.figures import to_svg


def tex(expression: sp.Expr) -> str:
    """TeX of an expression in the paper's symbols: M_s2 as M_{s2}, dtheta_1 as a dotted theta."""
    names = {symbol: _symbol(symbol.name) for symbol in expression.free_symbols}
    return str(sp.latex(expression, symbol_names=names))


def _symbol(name: str) -> str:
    stem, _, index = name.partition("_")
    number = re.search(r"\d+$", name)
    if not index and number:  # L2, d1: an index without a line
        stem, index = name[: number.start()], number.group()
    dotted = len(stem) > 1 and stem.startswith("d")
    base = stem[1:] if dotted else stem
    base = rf"\{base}" if base == "theta" else base
    base = rf"\dot{{{base}}}" if dotted else base
    return f"{base}_{{{index}}}" if index else base


def formula_svg(text: str) -> str:
    """A TeX formula as an <svg> element, by Matplotlib's own typesetter."""
    with mpl.rc_context({"mathtext.fontset": "cm"}):
        figure = Figure(figsize=(0.1, 0.1))
        # The typesetter does not know these two commands.
        known = text.replace(r"\left", "").replace(r"\right", "")
        drawn = figure.text(0, 0, f"${known}$", fontsize=13)
        box = drawn.get_window_extent()
        figure.set_size_inches((box.width + 8) / figure.dpi, (box.height + 8) / figure.dpi)
        drawn.set_position((4 / (box.width + 8), 4 / (box.height + 8) - box.y0 / (box.height + 8)))
        return to_svg(figure)

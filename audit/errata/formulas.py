"""Formulas as TeX."""

from __future__ import annotations

import re

import sympy as sp


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

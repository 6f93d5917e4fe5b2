"""SymPy without its simplifications, which take seconds and change no value."""

from __future__ import annotations

import sys
from typing import Any

SIMPLIFYING = (
    "simplify", "trigsimp", "exptrigsimp", "powsimp", "powdenest", "radsimp", "ratsimp", "combsimp",
    "gammasimp", "signsimp", "logcombine", "fu",
)  # fmt: skip
# Where a user's code, and the methods of expressions and matrices, look these functions up.
MODULES = ("sympy", "sympy.simplify", "sympy.simplify.simplify", "sympy.simplify.trigsimp")


def skip_simplification() -> None:
    """Let SymPy's simplifications return what they are given, for good, if SymPy is loaded."""
    for module in filter(None, map(sys.modules.get, MODULES)):
        for name in SIMPLIFYING:
            if callable(getattr(module, name, None)):
                setattr(module, name, _return_expression)


def _return_expression(expression: Any, *options: object, **more: object) -> Any:
    return expression

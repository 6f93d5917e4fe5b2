"""Functions of libraries that edits call often, without what takes long and changes no value."""

from __future__ import annotations

import sys
from collections.abc import Callable
from functools import lru_cache, partial, partialmethod
from numbers import Real
from typing import Any

import numpy as np

from crosscheck.trial.source.expressions import LambdifiedExpression

SIMPLIFYING = (
    "simplify", "trigsimp", "exptrigsimp", "powsimp", "powdenest", "radsimp", "ratsimp", "combsimp",
    "gammasimp", "signsimp", "logcombine", "fu",
)  # fmt: skip
# Where a user's code, and the methods of expressions and matrices, look these functions up.
MODULES = (
    "sympy", "sympy.simplify", "sympy.simplify.simplify", "sympy.simplify.trigsimp",
    "sympy.utilities", "sympy.utilities.lambdify",
)  # fmt: skip
LIBRARIES = (None, "numpy", "math", ["numpy"], ["math"])  # of lambdify, whose functions are alike
VECTOR = (3,)  # shape
MOST_DERIVATIVES = 100_000  # that are remembered
_cross_arrays = np.cross


def quicken_libraries() -> None:
    """Quicken NumPy's cross products, and SymPy's functions if it is loaded, for good.

    Simplifying takes seconds, and is left out; what lambdify returns is written when it is needed;
    numbers take the places of symbols in one pass; derivatives are remembered, for an edit changes
    those of a summand; np.cross takes as long as ten products.
    """
    vars(np)["cross"] = cross_vectors
    for module in filter(None, map(sys.modules.get, MODULES)):
        for name in SIMPLIFYING:
            if callable(getattr(module, name, None)):
                setattr(module, name, _return_expression)
        write = getattr(module, "lambdify", None)
        if callable(write):
            vars(module)["lambdify"] = partial(_lambdify, write)
    if sys.modules.get("sympy"):
        import sympy as sp

        for kind in (sp.Basic, sp.MatrixBase):
            kind.subs = partialmethod(_substitute, kind.subs)
        differentiate = sp.Expr.diff
        recall = lru_cache(MOST_DERIVATIVES)(differentiate)
        sp.Expr.diff = partialmethod(_differentiate, recall, differentiate)


def _differentiate(
    expression: Any,
    recall: Callable[..., Any],
    differentiate: Callable[..., Any],
    *by: Any,
    **more: Any,
) -> Any:
    """What SymPy's diff returns, of the same only once."""
    try:
        return recall(expression, *by, **more)
    except TypeError:  # of what has no hash, as a list
        return differentiate(expression, *by, **more)


def _substitute(expression: Any, substitute: Callable[..., Any], *pairs: Any, **more: Any) -> Any:
    """What SymPy's subs returns, of numbers for symbols by one replacement and not by one each."""
    import sympy as sp

    numbers = pairs[0] if len(pairs) == 1 and isinstance(pairs[0], dict) and not more else {}
    is_plain = all(
        isinstance(symbol, sp.Symbol) and isinstance(number, Real | sp.Number)
        for symbol, number in numbers.items()
    )
    if not numbers or not is_plain or expression.has(sp.Derivative, sp.Integral, sp.Subs):
        return substitute(expression, *pairs, **more)
    return expression.xreplace({symbol: sp.sympify(n) for symbol, n in numbers.items()})


def _return_expression(expression: Any, *options: object, **more: object) -> Any:
    return expression


def _lambdify(
    write: Callable[..., Callable[..., Any]],
    args: Any,
    expr: Any,
    modules: Any = None,
    **more: Any,
) -> Callable[..., Any]:
    """What SymPy's lambdify returns, of parameters that are called as there."""
    write_here = partial(write, args, expr, modules, **more)
    listed = args if isinstance(args, list | tuple) else [args]
    if modules not in LIBRARIES:
        return write_here()
    return LambdifiedExpression(write_here, listed, expr)


def cross_vectors(a: Any, b: Any, *options: Any, **more: Any) -> Any:
    """The bits of np.cross, of two vectors in a tenth of its time."""
    left, right = np.asarray(a), np.asarray(b)
    is_plain = left.shape == right.shape == VECTOR and left.dtype == right.dtype == float
    if options or more or not is_plain:
        return _cross_arrays(a, b, *options, **more)
    (x, y, z), (u, v, w) = left.tolist(), right.tolist()
    return np.array([y * w - z * v, z * u - x * w, x * v - y * u])

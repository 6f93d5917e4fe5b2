"""Functions of libraries that edits call often, without what takes long and changes no value."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
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
MOST_KEPT = 100_000  # results of a method that are remembered
_cross_arrays = np.cross


def quicken_libraries() -> None:
    """Quicken NumPy's cross products, and SymPy's functions if it is loaded, for good.

    Simplifying takes seconds, and is left out; what lambdify returns is written when it is needed;
    numbers take the places of symbols in one pass; np.cross takes as long as ten products. An edit
    changes a summand or two, so derivatives are remembered, and of sums what is made of summands.
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
            kind.subs = partialmethod(_substitute, kind.subs, lru_cache(MOST_KEPT)(kind.subs))
        for name, call in (("diff", _recall), ("expand", _recall_summands)):
            method = getattr(sp.Expr, name)
            setattr(sp.Expr, name, partialmethod(call, method, lru_cache(MOST_KEPT)(method)))


def _recall(
    expression: Any, method: Callable[..., Any], recall: Callable[..., Any], *by: Any, **more: Any
) -> Any:
    """What a method returns, of the same only once."""
    try:
        return recall(expression, *by, **more)
    except TypeError:  # of what has no hash, as a list
        return method(expression, *by, **more)


def _recall_summands(
    expression: Any, method: Callable[..., Any], recall: Callable[..., Any], *by: Any, **more: Any
) -> Any:
    """The same, of a sum the sum of what the method returns of its summands."""
    if not getattr(expression, "is_Add", False):
        return _recall(expression, method, recall, *by, **more)
    summands = (_recall(each, method, recall, *by, **more) for each in expression.args)
    return expression.func(*summands)


def _substitute(
    expression: Any,
    method: Callable[..., Any],
    recall: Callable[..., Any],
    *pairs: Any,
    **more: Any,
) -> Any:
    """What SymPy's subs returns, of numbers for symbols by one replacement and not by one each.

    Of a list of pairs it is the sum of what summands become, unless sums are replaced.
    """
    import sympy as sp

    if len(pairs) == 1 and isinstance(pairs[0], Iterator):
        pairs = ([*pairs[0]],)
    given = pairs[0] if len(pairs) == 1 else [pairs]
    is_list = isinstance(given, list | tuple) and not more
    if is_list and not any(isinstance(each[0], str | sp.Add) for each in given):
        kept = pairs if pairs[1:] else (tuple(given),)
        return _recall_summands(expression, method, recall, *kept)
    numbers = given if isinstance(given, dict) and not more else {}
    is_plain = all(
        isinstance(symbol, sp.Symbol) and isinstance(number, Real | sp.Number)
        for symbol, number in numbers.items()
    )
    if not numbers or not is_plain or expression.has(sp.Derivative, sp.Integral, sp.Subs):
        return method(expression, *pairs, **more)
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
    from crosscheck.trial.source.variations import Variation, compute_variation

    listed = args if isinstance(args, list | tuple) else [args]
    if modules not in LIBRARIES:
        return write(args, expr, modules, **more)
    values = Variation.list_unknown(expr, listed)
    written = expr
    if values:
        is_list = isinstance(expr, list | tuple)
        written = [each.xreplace(values) for each in expr] if is_list else expr.xreplace(values)
    functions = [{Variation.__name__: compute_variation}, "numpy"]
    write_here = partial(write, args, written, functions, **more)
    return LambdifiedExpression(write_here, listed, expr, values)


def cross_vectors(a: Any, b: Any, *options: Any, **more: Any) -> Any:
    """The bits of np.cross, of two vectors in a tenth of its time."""
    left, right = np.asarray(a), np.asarray(b)
    is_plain = left.shape == right.shape == VECTOR and left.dtype == right.dtype == float
    if options or more or not is_plain:
        return _cross_arrays(a, b, *options, **more)
    (x, y, z), (u, v, w) = left.tolist(), right.tolist()
    return np.array([y * w - z * v, z * u - x * w, x * v - y * u])

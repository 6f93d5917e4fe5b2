"""A user's sympy symbols beside the arm's: which symbol is which quantity."""

from __future__ import annotations

import difflib
from collections.abc import Collection, Mapping, Sequence
from fractions import Fraction
from numbers import Real
from typing import Any

import sympy as sp
from sympy.core.function import AppliedUndef

from analytic.symbols import parameter_values
from models.arm import Arm
from models.errors import InputError

NEAR, MOST_NAMED = 0.4, 4


def plain_symbols(x: Sequence[Any], v: Sequence[Any] = ()) -> dict[Any, sp.Symbol]:
    """A symbol for each coordinate and rate, whatever sympy.physics.mechanics calls them.

    x: Symbols or dynamicsymbols; v: these, or the time derivatives of x, which mean v anyway.
    Raises InputError.
    """
    found = {own: _plain(own, "x") for own in x}
    for own, rate in zip(x, v, strict=False):
        found[rate] = _plain(rate, "v")
        if isinstance(own, AppliedUndef):
            found[sp.Derivative(own, *own.args)] = found[rate]
    if len(set(found.values())) < len(x) + len(v):
        raise InputError("symbols", "", None, f"stand for two things: {_words(found)}")
    return found


def _plain(own: Any, what: str) -> sp.Symbol:
    if isinstance(own, sp.Symbol):
        return own
    if isinstance(own, AppliedUndef):
        return sp.Symbol(own.func.__name__, real=True)
    if isinstance(own, sp.Derivative) and isinstance(own.expr, AppliedUndef):
        return sp.Symbol(f"d{own.expr.func.__name__}", real=True)
    raise InputError("symbols", what, str(own), "must be a Symbol or a dynamicsymbol")


def in_arm_symbols(
    expression: sp.Matrix,
    own: Collection[Any],
    values: Mapping[Any, float | str],
    arm: Arm,
    where: str,
) -> sp.ImmutableMatrix:
    """An expression with each symbol that is not the user's own variable as one of the arm's.

    values: symbol, or its name, to a number or the name of a quantity of the arm; a symbol that is
    called like a quantity is this. Raises InputError naming a symbol that is nothing of this.
    """
    known = {symbol.name: symbol for symbol in parameter_values(arm)}
    undone = sorted(map(str, expression.atoms(AppliedUndef, sp.Derivative)))
    if undone:
        reason = "depend on time; coordinates and rates are x and v"
        raise InputError(where, ", ".join(undone), None, reason)
    unbound = sorted(expression.free_symbols - set(own), key=str)
    meant = {symbol: _meaning(symbol, values, known, where) for symbol in unbound}
    return sp.ImmutableMatrix(expression.xreplace(meant))


def _meaning(
    symbol: sp.Symbol, values: Mapping[Any, float | str], known: dict[str, sp.Symbol], where: str
) -> Any:
    value = values.get(symbol, values.get(symbol.name, symbol.name))
    if isinstance(value, str):
        if value in known:
            return known[value]
        close = difflib.get_close_matches(value, known, n=MOST_NAMED, cutoff=NEAR)
        called = "" if value == symbol.name else f", called {value},"
        near = f"near it: {', '.join(close)}" if close else f"there are {', '.join(known)}"
        reason = f"{called} is no quantity of the arm; give its value, or its name ({near})"
        raise InputError(where, symbol.name + called, None, reason.removeprefix(called).strip())
    if isinstance(value, Real | sp.Number) and sp.sympify(value).is_finite:
        return exact_number(float(value))
    raise InputError(where, symbol.name, value, "must be a number, or the name of a quantity")


def exact_number(value: float) -> sp.Rational:
    """The ratio that a floating-point number is."""
    return sp.Rational(*Fraction(value).as_integer_ratio())


def in_numbers(expression: sp.Matrix, arm: Arm) -> sp.ImmutableMatrix:
    """An expression in the arm's symbols with its numbers, rounded only when it is evaluated."""
    numbers = {
        symbol: sp.Float(float(value)) if value.denominator > 1 else sp.Integer(value)
        for symbol, value in parameter_values(arm).items()
    }
    return sp.ImmutableMatrix(expression.xreplace(numbers))


def _words(found: Mapping[Any, sp.Symbol]) -> str:
    return ", ".join(f"{own} -> {symbol}" for own, symbol in found.items())

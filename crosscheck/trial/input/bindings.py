"""A user's sympy symbols beside the arm's: which symbol is which quantity."""

from __future__ import annotations

import difflib
from collections.abc import Collection, Mapping, Sequence
from fractions import Fraction
from numbers import Real
from typing import Any

import sympy as sp
from sympy.core.function import AppliedUndef

from crosscheck.analytic.derivation.symbols import parameter_values
from crosscheck.models.arm.arm import Arm
from crosscheck.models.errors import InputError

NEAR, MOST_NAMED = 0.4, 4


def plain_symbols(
    x: Sequence[Any], v: Sequence[Any] = (), torque: Sequence[Any] = ()
) -> dict[Any, sp.Symbol]:
    """A symbol for each coordinate, rate and torque, whatever sympy.physics.mechanics calls them.

    x: Symbols or dynamicsymbols; v: these, or the time derivatives of x, which mean v anyway.
    Raises InputError.
    """
    if v and len(v) != len(x):
        raise InputError("symbols", "v", None, f"has {len(v)}, x has {len(x)}; must be as many")
    found = {own: _plain(own) for own in (*x, *v, *torque)}
    if len(set(found.values())) < len(x) + len(v) + len(torque):
        words = ", ".join(map(str, (*x, *v, *torque)))
        raise InputError("symbols", "", None, f"two of them are called the same: {words}")
    moving = [(own, rate) for own, rate in zip(x, v, strict=False) if own not in found.values()]
    return found | {own.diff(own.args[0]): found[rate] for own, rate in moving}


def _plain(own: Any) -> sp.Symbol:
    if isinstance(own, sp.Symbol):
        return own
    if isinstance(own, AppliedUndef):
        return sp.Symbol(own.func.__name__, real=True)
    if isinstance(own, sp.Derivative) and isinstance(own.expr, AppliedUndef):
        return sp.Symbol(f"d{own.expr.func.__name__}", real=True)
    raise InputError("symbols", str(own), None, "must be a Symbol or a dynamicsymbol")


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
        close = _close(value, known)
        near = f"near it: {', '.join(close)}" if close else f"there are {', '.join(known)}"
        reason = f"is no quantity of the arm; give its value, or its name ({near})"
        raise InputError(where, symbol.name, None if value == symbol.name else value, reason)
    if isinstance(value, Real | sp.Number) and sp.sympify(value).is_finite:
        return exact_number(float(value))
    raise InputError(where, symbol.name, value, "must be a number, or the name of a quantity")


def _close(name: str, known: Collection[str]) -> list[str]:
    """Quantities called alike: l_1 and L1 are, but for the way of writing."""
    alike = [own for own in known if _bare(own) == _bare(name)]
    return alike or difflib.get_close_matches(name, known, n=MOST_NAMED, cutoff=NEAR)


def _bare(name: str) -> str:
    return name.replace("_", "").lower()


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

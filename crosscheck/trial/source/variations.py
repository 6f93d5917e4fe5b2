"""What stands in a derivation for a change of an expression that is not known yet.

A variation is a function of the variables of a derivation, which SymPy differentiates as any other.
Its value is that of the difference which an edit makes, or of a derivative of that: which edit is
chosen when the equations are asked.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import lru_cache
from typing import Any, ClassVar, NamedTuple

import sympy as sp
from sympy.utilities.iterables import flatten

from crosscheck.trial.source.expressions import FUNCTIONS, evaluate

ANY = 0.37  # number of the first symbol that has no effect on the value of an expression
MOST_DERIVATIVES = 100_000  # derivatives of differences that are remembered


class Derivative(NamedTuple):
    """A derivative of a difference: its number, and the order by each variable of the code."""

    difference: int
    orders: tuple[int, ...]
    variables: tuple[sp.Expr, ...]


class Variation(sp.Function):
    """A derivative of an unknown difference, by its number, of the variables."""

    is_variation = True  # by which others know it without this module
    differences: ClassVar[Mapping[int, sp.Expr]] = {}  # by number, those of the chosen edit
    gaps: ClassVar[Mapping[sp.Symbol, float]] = {}  # numbers of the edit's text, by symbol
    derivatives: ClassVar[list[Derivative]] = []
    numbers: ClassVar[dict[tuple[int, tuple[int, ...]], int]] = {}  # of derivatives

    @classmethod
    def begin(cls, difference: int, variables: Sequence[sp.Expr]) -> Variation:
        """The difference itself, whose number is new."""
        derivative = Derivative(difference, (0,) * len(variables), tuple(variables))
        return cls(cls._number(derivative), *variables)

    @classmethod
    def _number(cls, derivative: Derivative) -> int:
        key = derivative.difference, derivative.orders
        if key not in cls.numbers:
            cls.numbers[key] = len(cls.derivatives)
            cls.derivatives.append(derivative)
        return cls.numbers[key]

    @classmethod
    def list_unknown(cls, expression: Any, arguments: Sequence[Any]) -> dict[sp.Symbol, sp.Expr]:
        """Symbols of an expression that are no arguments of its function, with a number for each.

        A right difference depends on fewer variables than its variation does: where M is a second
        derivative by the rates, these have cancelled, and any number of them gives the same.
        """
        listed = expression if isinstance(expression, list | tuple) else [expression]
        varied = [
            each for each in map(sp.sympify, listed) if hasattr(each, "has") and each.has(cls)
        ]
        if not varied:
            return {}
        given = (each.free_symbols for each in flatten(arguments))
        symbols = set[sp.Symbol]().union(*(each.free_symbols for each in varied))
        unknown = sorted(symbols.difference(*given), key=str)
        return {each: sp.Float(ANY + n) for n, each in enumerate(unknown)}

    def _eval_derivative(self, symbol: sp.Expr) -> sp.Expr:
        number, *variables = self.args
        derivative, summands = self.derivatives[int(number)], list[sp.Expr]()
        for place, variable in enumerate(variables):
            slope = sp.Integer(variable == symbol) if variable.is_Symbol else variable.diff(symbol)
            if slope:
                orders = [*derivative.orders]
                orders[place] += 1
                further = derivative._replace(orders=tuple(orders))
                summands.append(Variation(self._number(further), *variables) * slope)
        return sp.Add(*summands)

    def _eval_evalf(self, precision: int) -> sp.Expr | None:
        numbers = [each.evalf(precision) for each in self.args]
        if not all(each.is_number for each in numbers):
            return None
        return sp.Float(compute_variation(*map(float, numbers)))


def compute_variation(number: float, *values: Any) -> Any:
    """The value of a derivative at values of the variables, numbers or arrays of them."""
    derivative = Variation.derivatives[int(number)]
    difference = Variation.differences.get(derivative.difference)
    if difference is None:
        return 0.0
    if not derivative.variables and not Variation.gaps:
        return float(difference)
    slope, symbols = _differentiate(difference, derivative.variables, derivative.orders)
    return evaluate(slope, {**Variation.gaps, **dict(zip(symbols, values, strict=True))})


FUNCTIONS[Variation.__name__] = compute_variation


@lru_cache(MOST_DERIVATIVES)
def _differentiate(
    difference: sp.Expr, variables: tuple[sp.Expr, ...], orders: tuple[int, ...]
) -> tuple[sp.Expr, tuple[sp.Symbol, ...]]:
    """A derivative of a difference, in symbols that stand for the variables."""
    symbols = _list_symbols(variables)
    slope = _use_symbols(difference, variables)
    for symbol, order in zip(symbols, orders, strict=True):
        for _ in range(order):
            slope = slope.diff(symbol)
    return slope, symbols


@lru_cache
def _list_symbols(variables: tuple[sp.Expr, ...]) -> tuple[sp.Symbol, ...]:
    return tuple(sp.Dummy() for _ in variables)


@lru_cache(MOST_DERIVATIVES)
def _use_symbols(difference: sp.Expr, variables: tuple[sp.Expr, ...]) -> sp.Expr:
    """A difference in symbols: a rate before the coordinate of which it is one."""
    pairs = list(zip(variables, _list_symbols(variables), strict=True))
    rates = {each: symbol for each, symbol in pairs if isinstance(each, sp.Derivative)}
    return difference.xreplace(rates).xreplace(dict(pairs))

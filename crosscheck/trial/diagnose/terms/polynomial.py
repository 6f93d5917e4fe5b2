"""Sums of products of an arm's quantities, as fast as its derivation needs them.

They take the place of symbols or fractions in ``analytic.derivation.chain.Chain``, so that
Lagrange's equations come out as monomials, without sympy's simplifications. sympy's own rings have
no negative powers, and neither their elements nor its fields' multiply numpy's arrays.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np
import sympy as sp

Number = int | Fraction | float
Powers = tuple[tuple[str, int], ...]  # (symbol, power), by name; powers may be negative


def format_power(name: str, power: int) -> str:
    """A power as text, such as L1^2."""
    return name if power == 1 else f"{name}^{power}"


class Monomial(NamedTuple):
    """number * product of symbols to their powers."""

    number: Number
    powers: Powers

    def value(self, values: Mapping[str, Any]) -> Any:
        """The monomial's value with numbers (or arrays of numbers) for the symbols."""
        product: Any = float(self.number)
        for symbol, power in self.powers:
            product = product * values[symbol] ** power
        return product


@dataclass(frozen=True, eq=False)
class Polynomial:
    """A Laurent polynomial: a number for each product of symbols; without terms it is 0."""

    terms: Mapping[Powers, Number]

    @property
    def monomials(self) -> Iterator[Monomial]:
        """The polynomial's terms, one by one."""
        return (Monomial(number, powers) for powers, number in self.terms.items())

    def __bool__(self) -> bool:
        return bool(self.terms)

    def __add__(self, other: Any) -> Polynomial:
        if isinstance(other, np.ndarray):
            return NotImplemented
        return add_polynomials((self, as_polynomial(other)))

    def __mul__(self, other: Any) -> Polynomial:
        if isinstance(other, np.ndarray):
            return NotImplemented
        total: dict[Powers, Number] = {}
        factors = as_polynomial(other).terms.items()
        for left, a in self.terms.items():
            for right, b in factors:
                powers = _product(left, right)
                total[powers] = total.get(powers, 0) + a * b
        return Polynomial({powers: number for powers, number in total.items() if number})

    def __truediv__(self, other: Any) -> Polynomial:
        if isinstance(other, np.ndarray):
            return NotImplemented
        return self * as_polynomial(other) ** -1

    def __pow__(self, power: int) -> Polynomial:
        if power >= 0:
            result = as_polynomial(1)
            for _ in range(power):
                result = result * self
            return result
        ((powers, number),) = self.terms.items()  # of one term, or this is none
        inverse = number**power if isinstance(number, float) else Fraction(number) ** power
        return Polynomial({tuple((s, p * power) for s, p in powers): inverse})

    def __neg__(self) -> Polynomial:
        return self * -1

    def __sub__(self, other: Any) -> Polynomial:
        return self + -1 * as_polynomial(other)

    def __rsub__(self, other: Any) -> Polynomial:
        return as_polynomial(other) - self

    __radd__, __rmul__ = __add__, __mul__

    def drop_small_terms(self, nothing: float) -> Polynomial:
        """The polynomial without those terms whose number is a float of at most this size."""
        there = self.terms.items()
        return Polynomial({p: n for p, n in there if not isinstance(n, float) or abs(n) > nothing})

    def replace_symbol(self, name: str, other: Polynomial) -> Polynomial:
        """The polynomial with another in place of a symbol, except in denominators."""
        parts = []
        for powers, number in self.terms.items():
            power = dict(powers).get(name, 0)
            rest = powers if power <= 0 else tuple(p for p in powers if p[0] != name)
            part = Polynomial({rest: number})
            parts.append(part * other**power if power > 0 else part)
        return add_polynomials(parts)


def add_polynomials(parts: Iterable[Polynomial]) -> Polynomial:
    """Their sum, in one pass: sums of two copy all the terms so far."""
    total: dict[Powers, Number] = {}
    for part in parts:
        for powers, number in part.terms.items():
            total[powers] = total.get(powers, 0) + number
    return Polynomial({powers: number for powers, number in total.items() if number})


def symbol(name: str) -> Polynomial:
    """The polynomial that is the quantity of this name."""
    return Polynomial({((name, 1),): 1})


def as_polynomial(value: Any) -> Polynomial:
    """A number as a polynomial; a polynomial stays as it is."""
    if isinstance(value, Polynomial):
        return value
    value = value if isinstance(value, int | Fraction) else float(value)
    return Polynomial({(): value} if value else {})


def from_sympy(expression: sp.Expr) -> Polynomial | None:
    """The polynomial of a sympy expression; None where it is no sum of products."""
    total = as_polynomial(0)
    for part in sp.Add.make_args(sp.expand(expression)):
        product = as_polynomial(1)
        for factor in sp.Mul.make_args(part):
            base, power = factor.as_base_exp()
            if not power.is_Integer or not (base.is_Symbol or base.is_number):
                return None
            if base.is_Symbol:
                of_base = symbol(base.name)
            else:
                exact = base.is_Rational
                of_base = as_polynomial(
                    Fraction(int(base.p), int(base.q)) if exact else float(base)
                )
            product = product * of_base ** int(power)
        total = total + product
    return total


def _product(left: Powers, right: Powers) -> Powers:
    if not left or not right:
        return left or right
    powers = dict(left)
    for name, power in right:
        powers[name] = powers.get(name, 0) + power
    return tuple(sorted((name, power) for name, power in powers.items() if power))


AngleSum = tuple[int, ...]  # whole multiples of the joint angles of q, the first one positive


class TermKey(NamedTuple):
    """The factor after a coefficient: a signal times the cosine or sine of a joint angle sum.

    function ``cos`` of wave 0 is 1. signal: '' (none), an output torque ``T_1``, a mesh force of a
    planet ``F_sp1`` (``F_sp1_2``: planet 2), a rate of the user's ``phi_1'``, a damper's rate in
    contact ``D_sp1``, what springs do to an angle ``Q_sp1``.
    """

    wave: AngleSum
    function: str = "cos"
    signal: str = ""


class Product(NamedTuple):
    """A term of an entry: number * powers of symbols, before a key."""

    key: TermKey
    monomial: Monomial

    @property
    def symbols(self) -> tuple[str, ...]:
        """Names of the quantities that the product has."""
        return tuple(name for name, _ in self.monomial.powers)


EntryTerms = tuple[Product, ...]

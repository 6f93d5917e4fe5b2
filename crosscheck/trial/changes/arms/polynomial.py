"""Sums of products of an arm's quantities: what its derivation makes of letters.

They take the place of numbers in ``analytic.derivation.chain.Chain``, so that Lagrange's equations
come out as products of letters.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np

from crosscheck.analytic.derivation.chain import Chain
from crosscheck.analytic.derivation.stage import DirectStage, Stage
from crosscheck.models.arm.arm import Arm, Planetary
from crosscheck.models.arm.layout import Layout

Number = int | Fraction | float
Powers = tuple[tuple[str, int], ...]  # (letter, power), by name; powers may be negative


class Monomial(NamedTuple):
    """number * product of letters to their powers."""

    number: Number
    powers: Powers

    def value(self, values: Mapping[str, Any]) -> Any:
        """The monomial's value with numbers (or arrays of numbers) for the letters."""
        product: Any = float(self.number)
        for letter, power in self.powers:
            product = product * values[letter] ** power
        return product


@dataclass(frozen=True, eq=False)
class Polynomial:
    """A Laurent polynomial: a number for each product of letters; without terms it is 0."""

    terms: Mapping[Powers, Number]

    @property
    def monomials(self) -> Iterator[Monomial]:
        """The polynomial's terms, one by one."""
        return (Monomial(number, powers) for powers, number in self.terms.items())

    def value(self, values: Mapping[str, Any]) -> float:
        """The sum with numbers for the letters."""
        return float(sum(each.value(values) for each in self.monomials))

    def __bool__(self) -> bool:
        return bool(self.terms)

    def __add__(self, other: Any) -> Any:
        if isinstance(other, np.ndarray):
            return NotImplemented
        return add_polynomials((self, as_polynomial(other)))

    def __mul__(self, other: Any) -> Any:
        if isinstance(other, np.ndarray):
            return NotImplemented
        factors = as_polynomial(other).terms.items()
        return add_polynomials(
            Polynomial({_multiply_powers(left, right): a * b})
            for left, a in self.terms.items()
            for right, b in factors
        )

    def __truediv__(self, other: Any) -> Any:
        if isinstance(other, np.ndarray):
            return NotImplemented
        return self * as_polynomial(other) ** -1

    def __pow__(self, power: int) -> Polynomial:
        if power < 0:
            ((powers, number),) = self.terms.items()  # of one term, or this is none
            inverse = number**power if isinstance(number, float) else Fraction(number) ** power
            return Polynomial({tuple((s, p * power) for s, p in powers): inverse})
        result = as_polynomial(1)
        for _ in range(power):
            result = result * self
        return result

    def __neg__(self) -> Polynomial:
        return self * -1

    def __sub__(self, other: Any) -> Any:
        return self + -1 * as_polynomial(other)

    def __rsub__(self, other: Any) -> Any:
        return -self + other

    __radd__, __rmul__ = __add__, __mul__

    def replace_letter(self, name: str, other: Polynomial) -> Polynomial:
        """The polynomial with another in place of a letter, except in denominators."""
        parts = []
        for powers, number in self.terms.items():
            power = max(dict(powers).get(name, 0), 0)
            rest = tuple(each for each in powers if not power or each[0] != name)
            parts.append(Polynomial({rest: number}) * other**power)
        return add_polynomials(parts)


def add_polynomials(parts: Iterable[Polynomial]) -> Polynomial:
    """Their sum, in one pass: sums of two copy all the terms so far."""
    total: dict[Powers, Number] = {}
    for part in parts:
        for powers, number in part.terms.items():
            total[powers] = total.get(powers, 0) + number
    return Polynomial({powers: number for powers, number in total.items() if number})


def letter(name: str) -> Polynomial:
    """The polynomial that is the quantity of this name."""
    return Polynomial({((name, 1),): 1})


def as_polynomial(value: Any) -> Polynomial:
    """A number as a polynomial; a polynomial stays as it is."""
    if isinstance(value, Polynomial):
        return value
    value = value if isinstance(value, int | Fraction) else float(value)
    return Polynomial({(): value} if value else {})


def build_letter_chain(arm: Arm, layout: Layout) -> Chain:
    """The chain of an arm in letters, in any layout; free planets are counted, not a letter."""
    stages: list[Stage | DirectStage] = []
    for number, joint in enumerate(arm.joints, start=1):
        kind = Stage if isinstance(joint, Planetary) else DirectStage
        stage = kind(*(letter(f"{name}{number}") for name in kind._fields))
        if isinstance(stage, Stage) and layout.free:
            stage = stage._replace(N=joint.planet_count)
        stages.append(stage)
    return Chain(tuple(stages), letter("m_payload"), layout)


def _multiply_powers(left: Powers, right: Powers) -> Powers:
    powers = dict(left)
    for name, power in right:
        powers[name] = powers.get(name, 0) + power
    return tuple(sorted((name, power) for name, power in powers.items() if power))

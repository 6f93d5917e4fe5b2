"""What a claim is, when a cell of the experiment supports it, and the verdict over all cells."""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import combinations
from typing import NamedTuple

import numpy as np
from scipy.stats import spearmanr

from crosscheck.paper.claims.quantities import (
    Family,
    Known,
    NotSimulatedError,
    Quantity,
    Source,
)
from crosscheck.paper.undefined import UNDEFINED

LAWS = ("omega_t", "angle")
DEFAULT_ZETA = 0.05
READING, DAMPING = "reading of Table I", "damping"
CLEAR_RANK = 0.75  # of a rank correlation: with seven values chance alone rarely reaches it


Formula = Callable[[Known], float]


@dataclass(frozen=True)
class Cell:
    """One choice of phase law, reading of Table I and damping ratio, with its numbers."""

    phase: str
    reading: str
    zeta: float
    numbers: Known = field(default_factory=Known)


@dataclass(frozen=True)
class Limits:
    """The threshold of a claim: yes if low < value < high, None if the value is undefined."""

    low: float = -math.inf
    high: float = math.inf

    def __call__(self, value: float) -> bool | None:
        return bool(self.low < value < self.high) if math.isfinite(value) else None

    def __str__(self) -> str:
        if math.isinf(self.low):
            return f"< {self.high:g}"
        return f"> {self.low:g}" if math.isinf(self.high) else f"{self.low:g} to {self.high:g}"


def above(low: float) -> Limits:
    """Yes if the value is larger."""
    return Limits(low=low)


def below(high: float) -> Limits:
    """Yes if the value is smaller."""
    return Limits(high=high)


def about(value: float, share: float) -> Limits:
    """Yes within this share of a printed value."""
    return Limits(value * (1 - share), value * (1 + share))


@dataclass(frozen=True)
class Claim:
    """A statement of the paper, and the number that decides it.

    value: the formula over a cell's numbers, or one formula for each ``choice`` of ``free``, a
    parameter that the paper does not give (the first choice is the default). decide: when the value
    supports the statement. A value that is not finite neither does nor does not.
    """

    section: str
    figure: int | None
    statement: str
    quantity: str
    unit: str
    value: Formula | Mapping[str, Formula]
    decide: Limits
    free: str = ""

    @property
    def formulas(self) -> dict[str, Formula]:
        """Every choice of the free parameter, with its formula."""
        return {"": self.value} if callable(self.value) else dict(self.value)


class Answer(NamedTuple):
    """A claim in one cell under one choice of its free parameter; ``yes`` None: undefined."""

    phase: str
    reading: str
    zeta: float
    choice: str
    value: float
    yes: bool | None


class Verdict(NamedTuple):
    """holds, only with omega_t, does not hold, depends, undefined or not simulated.

    depends_on: the parameters that decide; undefined: how many answers are.
    """

    verdict: str
    depends_on: tuple[str, ...] = ()
    undefined: int = 0


def answers(claim: Claim, cells: Sequence[Cell]) -> list[Answer]:
    """The claim in every cell that has the experiments it needs."""
    found = []
    for cell in cells:
        for choice, formula in claim.formulas.items():
            try:
                with np.errstate(divide="ignore", invalid="ignore"):
                    value = float(formula(cell.numbers))
            except NotSimulatedError:
                continue
            where = (cell.phase, cell.reading, cell.zeta, choice)
            found.append(Answer(*where, value, claim.decide(value)))
    return found


def verdict(given: Sequence[Answer], free: str = "") -> Verdict:
    """The rule over all cells: what holds must hold in every cell of the law `angle`.

    Undefined cells are counted and have no say; if no cell of `angle` is defined, neither is the
    verdict.
    """
    defined = [answer for answer in given if answer.yes is not None]
    undefined = len(given) - len(defined)
    if not any(answer.phase == "angle" for answer in given):
        return Verdict("not simulated", (), undefined)
    angle = [answer for answer in defined if answer.phase == "angle"]
    if not angle:
        return Verdict(UNDEFINED, (), undefined)
    if all(answer.yes for answer in angle):
        return Verdict("holds", (), undefined)
    if any(answer.yes for answer in angle):
        return Verdict("depends", _deciding(angle, free), undefined)
    only = any(answer.yes for answer in defined)
    return Verdict("only with omega_t" if only else "does not hold", (), undefined)


def _deciding(given: Sequence[Answer], free: str) -> tuple[str, ...]:
    """Parameters whose change alone changes the answer; all that vary if none does so alone."""
    axes: dict[str, Callable[[Answer], str | float]] = {
        READING: operator.attrgetter("reading"),
        DAMPING: operator.attrgetter("zeta"),
        free: operator.attrgetter("choice"),
    }
    axes = {name: get for name, get in axes.items() if len(set(map(get, given))) > 1}
    alone = {
        name
        for one, other in combinations(given, 2)
        if one.yes != other.yes
        for name in _only_difference(axes, one, other)
    }
    return tuple(name for name in axes if name in (alone or axes))


def _only_difference(
    axes: Mapping[str, Callable[[Answer], str | float]], one: Answer, other: Answer
) -> list[str]:
    """The axis along which two answers differ, if it is one."""
    differing = [name for name, coordinate in axes.items() if coordinate(one) != coordinate(other)]
    return differing if len(differing) == 1 else []


def of(quantity: Quantity) -> Formula:
    """The number itself."""
    return lambda n: n[quantity]


def difference(one: Quantity, other: Quantity) -> Formula:
    """One number less another."""
    return lambda n: n[one] - n[other]


def size(formula: Formula) -> Formula:
    """Its magnitude."""
    return lambda n: abs(formula(n))


def over(one: Formula, other: Formula) -> Formula:
    """One formula over another."""
    return lambda n: one(n) / other(n)


def ratio(one: Quantity, other: Quantity) -> Formula:
    """One number over another."""
    return over(of(one), of(other))


def smallest(*quantities: Quantity) -> Formula:
    """The smallest of several numbers; not a number if one is not."""
    return lambda n: np.min([n[quantity] for quantity in quantities])


def largest(*quantities: Quantity) -> Formula:
    """The largest of several numbers; not a number if one is not."""
    return lambda n: np.max([n[quantity] for quantity in quantities])


def diverges(source: Source) -> Formula:
    """1 if the experiment's run diverged, 0 if it did not."""

    def formula(n: Known) -> float:
        if not n.simulated(source):
            raise NotSimulatedError(source)
        return float(n.diverged(source))

    return formula


def where(condition: Quantity, limits: Limits, formula: Formula) -> Formula:
    """The formula; not a number where a condition on another number fails or is undefined."""

    def gated(n: Known) -> float:
        value = formula(n)
        return value if limits(n[condition]) else math.nan

    return gated


def each(choices: Sequence[str], formula: Callable[[str], Formula]) -> dict[str, Formula]:
    """One formula for every choice of a parameter that the paper does not give."""
    return {choice: formula(choice) for choice in choices}


def along(family: Family, name: str, n: Known) -> tuple[np.ndarray, np.ndarray]:
    """(size [um], quantity) of the experiments of a family, ascending.

    One that diverged is there, with nan. Raises NotSimulatedError with fewer than three of them.
    """
    members = n.members(family)
    if len(members) < 3:
        raise NotSimulatedError(family)
    return (
        np.array([source.size_um for source in members]),
        np.array([n[source(name)] for source in members]),
    )


def rank(family: Family, name: str) -> Formula:
    """Rank correlation of a quantity with the parameter of a family of experiments.

    Not a number if one of them has no such number, or all have the same.
    """

    def formula(n: Known) -> float:
        return rank_correlation(*along(family, name, n))

    return formula


def rank_correlation(parameter: np.ndarray, values: np.ndarray) -> float:
    """Spearman's; not a number if a value is not, or all are the same."""
    if not np.isfinite(values).all() or np.ptp(values) == 0:
        return math.nan
    return float(spearmanr(parameter, values).statistic)


def least(family: Family, name: str) -> Formula:
    """Smallest value in a family of experiments; not a number if one is not."""
    return lambda n: along(family, name, n)[1].min()


def greatest(family: Family, name: str) -> Formula:
    """Largest value in a family of experiments; not a number if one is not."""
    return lambda n: along(family, name, n)[1].max()


def spread(family: Family, name: str) -> Formula:
    """Largest over smallest value in a family of experiments."""
    return over(greatest(family, name), least(family, name))

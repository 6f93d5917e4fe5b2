"""What a claim is, when a cell of the experiment supports it, and the verdict over all cells."""

from __future__ import annotations

import math
import operator
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import combinations
from typing import Any, NamedTuple

import numpy as np
from scipy.stats import spearmanr

from crosscheck.paper.undefined import UNDEFINED
from crosscheck.studies.study import Numbers

LAWS = ("omega_t", "angle")
DEFAULT_ZETA = 0.05
READING, DAMPING = "reading of Table I", "damping"
CLEAR_RANK = 0.75  # of a rank correlation: with seven values chance alone rarely reaches it


class NotSimulatedError(LookupError):
    """A cell lacks the experiment that a claim is about."""


class Known(dict[str, float]):
    """Numbers of a cell by ``experiment.quantity``; nan where a run has no such number or diverged.

    An experiment named after a size has its decimal point as ``_``. Numbers come as NumPy's, so
    that a division by zero is not finite and not an exception.

    Raises NotSimulatedError for an experiment that the cell does not have, KeyError for a quantity
    that no experiment measures.
    """

    def __getitem__(self, name: str) -> float:
        return np.float64(super().__getitem__(name))

    def __missing__(self, name: str) -> float:
        experiment = name.split(".")[0]
        if f"{experiment}.diverged_s" in self:
            return math.nan
        if self.simulated(experiment):
            raise KeyError(name)
        raise NotSimulatedError(name)

    def simulated(self, experiment: str) -> bool:
        """Whether the cell has it."""
        return any(known.startswith(f"{experiment}.") for known in self)

    def add(self, experiment: str, numbers: Numbers) -> None:
        """Take over an experiment's numbers."""
        for name, value in numbers.items():
            self[f"{experiment}.{name}"] = math.nan if value is None else value


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
    axes = {
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
    axes: Mapping[str, Callable[[Answer], Any]], one: Answer, other: Answer
) -> list[str]:
    """The axis along which two answers differ, if it is one."""
    differing = [name for name, coordinate in axes.items() if coordinate(one) != coordinate(other)]
    return differing if len(differing) == 1 else []


def of(name: str) -> Formula:
    """The number itself."""
    return lambda n: n[name]


def difference(one: str, other: str) -> Formula:
    """One number less another."""
    return lambda n: n[one] - n[other]


def size(formula: Formula) -> Formula:
    """Its magnitude."""
    return lambda n: abs(formula(n))


def over(one: Formula, other: Formula) -> Formula:
    """One formula over another."""
    return lambda n: one(n) / other(n)


def ratio(one: str, other: str) -> Formula:
    """One number over another."""
    return over(of(one), of(other))


def smallest(*names: str) -> Formula:
    """The smallest of several numbers; not a number if one is not."""
    return lambda n: np.min([n[name] for name in names])


def largest(*names: str) -> Formula:
    """The largest of several numbers; not a number if one is not."""
    return lambda n: np.max([n[name] for name in names])


def diverges(experiment: str) -> Formula:
    """1 if the experiment's run diverged, 0 if it did not."""

    def formula(n: Known) -> float:
        if not n.simulated(experiment):
            raise NotSimulatedError(experiment)
        return float(f"{experiment}.diverged_s" in n)

    return formula


def where(name: str, limits: Limits, formula: Formula) -> Formula:
    """The formula; not a number where a condition on another number fails or is undefined."""

    def gated(n: Known) -> float:
        value = formula(n)
        return value if limits(n[name]) else math.nan

    return gated


def each(choices: Sequence[str], formula: Callable[[str], Formula]) -> dict[str, Formula]:
    """One formula for every choice of a parameter that the paper does not give."""
    return {choice: formula(choice) for choice in choices}


def along(family: str, quantity: str, n: Known) -> tuple[np.ndarray, np.ndarray]:
    """(parameter, quantity) of the experiments family<parameter>, ascending.

    One that diverged is there, with nan. Raises NotSimulatedError with fewer than three of them.
    """
    matches = [re.match(rf"({family}([0-9_]+))\.", name) for name in n]
    members = {match[1]: float(match[2].replace("_", ".")) for match in matches if match}
    if len(members) < 3:
        raise NotSimulatedError(f"{family}*.{quantity}")
    ascending = sorted(members, key=members.__getitem__)
    return (
        np.array([members[name] for name in ascending]),
        np.array([n[f"{name}.{quantity}"] for name in ascending]),
    )


def rank(family: str, quantity: str) -> Formula:
    """Rank correlation of a quantity with the parameter of a family of experiments.

    Not a number if one of them has no such number, or all have the same.
    """

    def formula(n: Known) -> float:
        return rank_correlation(*along(family, quantity, n))

    return formula


def rank_correlation(parameter: np.ndarray, values: np.ndarray) -> float:
    """Spearman's; not a number if a value is not, or all are the same."""
    if not np.isfinite(values).all() or np.ptp(values) == 0:
        return math.nan
    return float(spearmanr(parameter, values).statistic)


def least(family: str, quantity: str) -> Formula:
    """Smallest value in a family of experiments; not a number if one is not."""
    return lambda n: along(family, quantity, n)[1].min()


def greatest(family: str, quantity: str) -> Formula:
    """Largest value in a family of experiments; not a number if one is not."""
    return lambda n: along(family, quantity, n)[1].max()


def spread(family: str, quantity: str) -> Formula:
    """Largest over smallest value in a family of experiments."""
    return over(greatest(family, quantity), least(family, quantity))

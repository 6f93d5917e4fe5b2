"""Shares of starts, with what so many starts can tell of the probability behind them."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cache
from typing import NamedTuple

from scipy.stats import binomtest

CONFIDENCE = 0.95


class Share(NamedTuple):
    """A share: how many of several starts, at least one, are a yes."""

    yes: int
    of: int

    def __str__(self) -> str:
        return f"{self.yes} of {self.of}"

    @property
    def value(self) -> float:
        """The share as a number from 0 to 1."""
        return self.yes / self.of

    @property
    def interval(self) -> tuple[float, float]:
        """Clopper and Pearson's 95 % interval of the probability."""
        return _interval(self.yes, self.of)


def share_of(answers: Iterable[bool | None]) -> Share | None:
    """The share of yes among the answers that are known; None if none is."""
    defined_answers = [answer for answer in answers if answer is not None]
    return Share(sum(defined_answers), len(defined_answers)) if defined_answers else None


@cache
def _interval(yes: int, of: int) -> tuple[float, float]:
    interval = binomtest(yes, of).proportion_ci(CONFIDENCE, "exact")
    return float(interval.low), float(interval.high)

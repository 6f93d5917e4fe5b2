"""Shares of starts, with what so many starts can tell of the probability behind them."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cache
from typing import NamedTuple

from scipy.stats import binomtest

CONFIDENCE = 0.95


class Share(NamedTuple):
    """How many of several starts, at least one."""

    yes: int
    of: int

    @property
    def value(self) -> float:
        """Between 0 and 1."""
        return self.yes / self.of

    @property
    def interval(self) -> tuple[float, float]:
        """Clopper and Pearson's 95 % interval of the probability."""
        return _interval(self.yes, self.of)


def share_of(answers: Iterable[bool | None]) -> Share | None:
    """How many of the answers that are known are yes; None without any."""
    known = [answer for answer in answers if answer is not None]
    return Share(sum(known), len(known)) if known else None


@cache
def _interval(yes: int, of: int) -> tuple[float, float]:
    found = binomtest(yes, of).proportion_ci(CONFIDENCE, "exact")
    return float(found.low), float(found.high)

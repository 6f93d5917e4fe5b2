"""Two samples of starts: could one distribution be behind both? What does the tooth error make?"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy.stats import fisher_exact, mannwhitneyu

from crosscheck.audit.claims.rule import FEW, Limits, State, state
from crosscheck.audit.measures.shares import Share
from crosscheck.audit.measures.third import LARGE, VISIBLE, Third

SIGNIFICANT = 0.05


class TwoTests(NamedTuple):
    """The p of Fisher's exact test of the shares and of Mann and Whitney's of the sizes.

    None where a sample has too few defined starts.
    """

    by_share: float | None
    by_size: float | None

    @property
    def least(self) -> float | None:
        """The smaller p of the two tests; None where one is missing."""
        if self.by_share is None or self.by_size is None:
            return None
        return min(self.by_share, self.by_size)


def two_tests(one: Third, other: Third) -> TwoTests:
    """The tests of two samples' third fluctuations."""
    if one.share is None or other.share is None:
        return TwoTests(None, None)
    return TwoTests(shares_p(one.share, other.share), sizes_p(one.sizes, other.sizes))


def shares_p(one: Share, other: Share) -> float:
    """Chance of shares at least as unlike if one probability is behind both (Fisher, exact)."""
    table = [[one.yes, one.of - one.yes], [other.yes, other.of - other.yes]]
    return float(fisher_exact(table).pvalue)


def sizes_p(one: Sequence[float] | np.ndarray, other: Sequence[float] | np.ndarray) -> float:
    """Chance of sizes at least as unlike if one distribution is behind both (Mann and Whitney)."""
    return float(mannwhitneyu(one, other).pvalue)


def least_p(one: int, other: int) -> float:
    """The smallest p that either test can give for two samples of such sizes."""
    ranks = mannwhitneyu(range(one), range(one, one + other), method="exact")
    return min(shares_p(Share(one, one), Share(0, other)), float(ranks.pvalue))


def not_told_apart(one: Share, of: int) -> tuple[int, int]:
    """The fewest and the most yes, of so many, that Fisher's test does not tell from a share."""
    alike = [yes for yes in range(of + 1) if not told_apart(shares_p(one, Share(yes, of)))]
    return min(alike), max(alike)


def told_apart(p: float, tests: float = 1.0) -> bool:
    """Whether a test tells two samples apart, if it is one of so many that could (Bonferroni)."""
    return p < SIGNIFICANT / tests


class RaisedByError(NamedTuple):
    """What the tooth error makes of starts that are not above a level without it.

    share: of these, those that are above it with the tooth error; None where more than a tenth of
    the starts are above it without: there the arm vibrates by itself, and the tooth error has
    nothing to make; or where too few are defined. p: Fisher's exact test of all starts with and
    without.
    """

    share: Share | None
    p: float

    @property
    def state(self) -> State:
        """Whether the error makes it; bistable counts as no if the test tells no difference."""
        found = state(self.share)
        return State.NO if found == State.BISTABLE and not told_apart(self.p) else found


def made_by_error(with_error: Third, without: Third, level: Limits = LARGE) -> RaisedByError:
    """What the tooth error makes, from start i with it compared with start i without it."""
    calm = np.isfinite(without.size) & np.isfinite(with_error.size)
    loud, there = (calm & level.yes(third.size) for third in (without, with_error))
    if calm.sum() < max(1.0, FEW * calm.size) or loud.sum() > FEW * calm.sum():
        return RaisedByError(None, 1.0)
    quiet, of = calm & ~loud, int(calm.sum())
    p = shares_p(Share(int(there.sum()), of), Share(int(loud.sum()), of))
    return RaisedByError(Share(int(there[quiet].sum()), int(quiet.sum())), p)


@dataclass(frozen=True, kw_only=True)
class WithAndWithout:
    """The third fluctuation with tooth error and without, from the same starts."""

    third: Third
    without: Third

    @cached_property
    def made(self) -> RaisedByError:
        """The share of starts that the tooth error makes severe, with its test."""
        return made_by_error(self.third, self.without)

    @cached_property
    def made_visible(self) -> RaisedByError:
        """The share of starts that the tooth error raises above EVIDENT, with its test."""
        return made_by_error(self.third, self.without, VISIBLE)

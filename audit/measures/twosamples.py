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
from crosscheck.audit.measures.third_fluctuation import LARGE, VISIBLE, ThirdFluctuation

SIGNIFICANT = 0.05


class PValues(NamedTuple):
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


def compare_samples(first: ThirdFluctuation, second: ThirdFluctuation) -> PValues:
    """The tests of two samples' third fluctuations."""
    if first.share is None or second.share is None:
        return PValues(None, None)
    return PValues(shares_p(first.share, second.share), sizes_p(first.sizes, second.sizes))


def shares_p(first: Share, second: Share) -> float:
    """Chance of shares at least as unlike if one probability is behind both (Fisher, exact)."""
    table = [[first.yes, first.of - first.yes], [second.yes, second.of - second.yes]]
    return float(fisher_exact(table).pvalue)


def sizes_p(first: Sequence[float] | np.ndarray, second: Sequence[float] | np.ndarray) -> float:
    """Chance of sizes at least as unlike if one distribution is behind both (Mann and Whitney)."""
    return float(mannwhitneyu(first, second).pvalue)


def least_p(first_size: int, second_size: int) -> float:
    """The smallest p that either test can give for two samples of such sizes."""
    ranks = mannwhitneyu(
        range(first_size), range(first_size, first_size + second_size), method="exact"
    )
    return min(shares_p(Share(first_size, first_size), Share(0, second_size)), float(ranks.pvalue))


def find_passing_range(share: Share, of: int) -> tuple[int, int]:
    """The fewest and the most yes, of so many, that Fisher's test does not tell from a share."""
    alike = [yes for yes in range(of + 1) if not is_significant(shares_p(share, Share(yes, of)))]
    return min(alike), max(alike)


def is_significant(p: float, tests: float = 1.0) -> bool:
    """Whether a test tells two samples apart, if it is one of so many that could (Bonferroni)."""
    return p < SIGNIFICANT / tests


class ToothErrorEffect(NamedTuple):
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
        share_state = state(self.share)
        return (
            State.NO
            if share_state == State.BISTABLE and not is_significant(self.p)
            else share_state
        )


def compute_error_effect(
    with_error: ThirdFluctuation, without: ThirdFluctuation, level: Limits = LARGE
) -> ToothErrorEffect:
    """What the tooth error makes, from start i with it compared with start i without it."""
    calm = np.isfinite(without.size) & np.isfinite(with_error.size)
    loud, there = (calm & level.contains(third.size) for third in (without, with_error))
    if calm.sum() < max(1.0, FEW * calm.size) or loud.sum() > FEW * calm.sum():
        return ToothErrorEffect(None, 1.0)
    quiet, of = calm & ~loud, int(calm.sum())
    p = shares_p(Share(int(there.sum()), of), Share(int(loud.sum()), of))
    return ToothErrorEffect(Share(int(there[quiet].sum()), int(quiet.sum())), p)


@dataclass(frozen=True, kw_only=True)
class ToothErrorComparison:
    """The third fluctuation with tooth error and without, from the same starts."""

    third: ThirdFluctuation
    without: ThirdFluctuation

    @cached_property
    def made(self) -> ToothErrorEffect:
        """The share of starts that the tooth error makes severe, with its test."""
        return compute_error_effect(self.third, self.without)

    @cached_property
    def made_visible(self) -> ToothErrorEffect:
        """The share of starts that the tooth error raises above EVIDENT, with its test."""
        return compute_error_effect(self.third, self.without, VISIBLE)

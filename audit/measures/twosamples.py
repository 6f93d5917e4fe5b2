"""Two samples of starts: could one distribution be behind both? What does the tooth error make?"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.stats import binomtest, fisher_exact, mannwhitneyu

from crosscheck.audit.claims.rule import FEW, Limits, State, state
from crosscheck.audit.measures.shares import Share
from crosscheck.audit.measures.third_fluctuation import LARGE, ThirdFluctuation

SIGNIFICANT = 0.05
EQUIVALENCE = 1 - 2 * SIGNIFICANT  # two one-sided tests at 5 % are an interval of 90 %


class PValues(NamedTuple):
    """The p of Fisher's exact test of the shares and of Mann and Whitney's of the sizes.

    None where a sample has too few defined starts.
    """

    by_share: float | None
    by_size: float | None


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


def adjust_by_holm(p_values: Sequence[float]) -> list[float]:
    """The p of tests that are one family, as Holm's procedure adjusts them, in their order.

    One below SIGNIFICANT stands with at most SIGNIFICANT error for the whole family.
    """
    order = np.argsort(p_values, kind="stable")
    adjusted = np.zeros(len(order))
    factors = np.arange(len(order), 0, -1)
    adjusted[order] = np.minimum(1.0, np.maximum.accumulate(factors * np.take(p_values, order)))
    return list(map(float, adjusted))


class ConfidenceInterval(NamedTuple):
    """An interval that holds a quantity with 90 %: within margins, equivalence at 5 %."""

    low: float
    high: float

    def is_within(self, low: float, high: float) -> bool | None:
        """Whether the quantity is shown to be within margins; None where neither is shown."""
        if low <= self.low and self.high <= high:
            return True
        return False if self.high < low or high < self.low else None


def find_ratio_interval(first: np.ndarray, second: np.ndarray) -> ConfidenceInterval | None:
    """The interval of the second median over the first, both positive and of one shape.

    Mann and Whitney's test inverted (Hodges and Lehmann); None where samples are too small.
    """
    ratios = np.sort(np.divide.outer(second, first).ravel())
    # How many of all ways to rank the samples give each value of U, by the recursion over sizes.
    ways = np.zeros((first.size + 1, ratios.size + 1))
    ways[0, 0] = 1.0
    for rank in range(first.size + second.size):
        for chosen in range(min(rank, first.size - 1), -1, -1):
            before = rank - chosen  # of the second sample, which the next of the first exceeds
            if before <= second.size:
                ways[chosen + 1, before:] += ways[chosen, : ratios.size + 1 - before]
    below = np.cumsum(ways[first.size]) / ways[first.size].sum()
    outer = int((below <= SIGNIFICANT).sum())  # ratios beyond either end
    return ConfidenceInterval(float(ratios[outer - 1]), float(ratios[-outer])) if outer else None


def find_difference_interval(first: Share, second: Share) -> ConfidenceInterval:
    """The interval of the second share less the first (Newcombe's, of two Wilson intervals)."""
    (p, low_1, high_1), (q, low_2, high_2) = map(_find_wilson_interval, (first, second))
    below, above = np.hypot(q - low_2, high_1 - p), np.hypot(high_2 - q, p - low_1)
    return ConfidenceInterval(float(q - p - below), float(q - p + above))


def _find_wilson_interval(share: Share) -> tuple[float, float, float]:
    """The share, and Wilson's interval of the probability behind it."""
    interval = binomtest(*share).proportion_ci(EQUIVALENCE, "wilson")
    return share.value, float(interval.low), float(interval.high)


def adjust_pairs(pairs: Sequence[PValues]) -> list[PValues]:
    """The p of both tests of pairs of samples as one family, in which undefined ones are none."""
    plain = [p for pair in pairs for p in pair]
    adjusted = iter(adjust_by_holm([p for p in plain if p is not None]))
    every = [None if p is None else next(adjusted) for p in plain]
    return [PValues(*pair) for pair in zip(every[::2], every[1::2], strict=True)]


def is_significant(p: float) -> bool:
    """Whether a p, adjusted if it is one of a family, tells two samples apart."""
    return p < SIGNIFICANT


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
    """What the tooth error makes, from start i with it compared with start i without it.

    Where fewer starts were run of one, because they agree, these stand beside all of the other.
    """
    starts = max(with_error.size.size, without.size.size)
    error_sizes, own_sizes = (np.resize(third.size, starts) for third in (with_error, without))
    calm = np.isfinite(own_sizes) & np.isfinite(error_sizes)
    loud, there = (calm & level.contains(sizes) for sizes in (own_sizes, error_sizes))
    if calm.sum() < max(1.0, FEW * calm.size) or loud.sum() > FEW * calm.sum():
        return ToothErrorEffect(None, 1.0)
    quiet = calm & ~loud
    with_share, without_share = (
        Share(int(chosen[:run].sum()), int(calm[:run].sum()))
        for chosen, run in ((there, with_error.size.size), (loud, without.size.size))
    )
    p = shares_p(with_share, without_share)
    return ToothErrorEffect(Share(int(there[quiet].sum()), int(quiet.sum())), p)

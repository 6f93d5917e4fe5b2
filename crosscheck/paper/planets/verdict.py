"""What decides hypothesis H7: thresholds and the functions that apply them.

H7: counting three planets as one changes the paper's third fluctuation. A decision about what is
undefined is None.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from scipy.stats import binomtest, fisher_exact, mannwhitneyu

from crosscheck.paper.figures.verdicts import ACCELERATION
from crosscheck.paper.phase.verdict import PRESENT_RAD_PER_S2
from crosscheck.paper.undefined import UNDEFINED, known, where_known

LARGE_RAD_PER_S2 = ACCELERATION  # a fluctuation of the paper's kind, as in its figures
CONFIDENCE = 0.95
SIGNIFICANT = 0.05  # of two samples that a test tells apart
# Relative difference of medians that is worth telling, if one is present at all: 0.2 in a first
# look, now 0.1 as the older comparison between engines had it.
WORTH, FIRST_WORTH = 0.1, 0.2
PREDICTED = 0.10  # relative error of the time at which planets part
MOST, FEW = 0.9, 0.1  # shares of starts that count as all, and as none


@dataclass(frozen=True)
class Share:
    """How many of several starts, with the 95 % interval of the probability behind it."""

    yes: int
    of: int
    low: float
    high: float

    @classmethod
    def counted(cls, yes: int, of: int) -> Share:
        """Clopper and Pearson's interval, from one start on."""
        interval = binomtest(yes, of).proportion_ci(CONFIDENCE, "exact")
        return cls(yes, of, float(interval.low), float(interval.high))

    @property
    def value(self) -> float:
        """Between 0 and 1."""
        return self.yes / self.of


@where_known
def is_large(amplitude_rad_per_s2: float) -> bool:
    """Whether a third fluctuation is one of the paper's kind."""
    return amplitude_rad_per_s2 > LARGE_RAD_PER_S2


def shares_p(one: Share, other: Share) -> float:
    """Probability of shares at least as unlike if both have one behind them (Fisher, exact)."""
    table = [[one.yes, one.of - one.yes], [other.yes, other.of - other.yes]]
    return float(fisher_exact(table).pvalue)


def sizes_p(one: Sequence[float], other: Sequence[float]) -> float:
    """The same of sizes by their ranks (Mann and Whitney); infinite ones are the largest."""
    return float(mannwhitneyu(one, other).pvalue)


def least_p(one: int, other: int) -> float:
    """The smallest p that either test can give for two samples of such sizes."""
    table = [[one, 0], [0, other]]
    ranks = mannwhitneyu(range(one), range(one, one + other), method="exact")
    return float(min(fisher_exact(table).pvalue, ranks.pvalue))


def not_told_apart(one: Share, of: int) -> tuple[int, int]:
    """The fewest and the most yes, of so many, that Fisher's exact test does not tell from one."""
    alike = [yes for yes in range(of + 1) if not told_apart(shares_p(one, Share.counted(yes, of)))]
    return min(alike), max(alike)


@where_known
def told_apart(p: float, tests: float = 1.0) -> bool:
    """Whether a test tells two samples apart, if it is one of so many that could."""
    return p < SIGNIFICANT / tests


@where_known
def one_distribution(by_share: float, by_size: float) -> bool:
    """Whether neither test (its p) tells two samples apart."""
    return min(by_share, by_size) >= SIGNIFICANT


class Effect(StrEnum):
    """What freeing the planets does to a third fluctuation."""

    WEAKER = "weaker"
    STRONGER = "stronger"
    NONE = "none seen"
    UNKNOWN = UNDEFINED


def effect(
    lumped: Sequence[float],
    free: Sequence[float],
    by_share: float,
    by_size: float,
    tests: int,
    worth: float = WORTH,
) -> Effect:
    """From the amplitudes [rad/s^2] of both samples and the p of both tests, two of so many.

    Told apart by the shares, or by sizes whose medians differ by more than worth (relative) where
    one counts as present. Unknown where most starts of both diverged.
    """
    before, after = float(np.median(lumped)), float(np.median(free))
    if not known(by_share, by_size) or before == after == math.inf:
        return Effect.UNKNOWN
    smaller, larger = sorted((before, after))
    matters = larger >= PRESENT_RAD_PER_S2 and larger > (1 + worth) * smaller
    if told_apart(by_share, tests):
        return Effect.WEAKER if _large(free) < _large(lumped) else Effect.STRONGER
    if matters and told_apart(by_size, tests):
        return Effect.WEAKER if after < before else Effect.STRONGER
    return Effect.NONE


def _large(amplitudes: Sequence[float]) -> float:
    """Share of the starts with a large one, diverged ones included."""
    return float(np.mean(np.array(amplitudes) > LARGE_RAD_PER_S2))


def parting_is_predicted(predicted_s: float | None, measured_s: float | None) -> bool:
    """Both never part, or both part at nearly the same time."""
    if predicted_s is None or measured_s is None:
        return predicted_s is measured_s
    return abs(predicted_s / measured_s - 1) <= PREDICTED


class Survival(StrEnum):
    """What becomes of a figure's feature once planets are free."""

    YES = "yes"
    NO = "no"
    APPEARS = "appears"
    BISTABLE = "bistable"
    BISTABLE_EITHER = "bistable either way"
    ABSENT = "absent either way"
    UNKNOWN = UNDEFINED


def survival(lumped: float | None, free: float | None) -> Survival:
    """From the shares of starts that show the feature."""
    if lumped is None or free is None:
        return Survival.UNKNOWN
    if FEW < free < MOST:
        return Survival.BISTABLE_EITHER if FEW < lumped < MOST else Survival.BISTABLE
    if free >= MOST:
        return Survival.YES if lumped > FEW else Survival.APPEARS
    return Survival.NO if lumped > FEW else Survival.ABSENT


def is_changed(lumped: Share | None, free: Share | None, tests: int) -> bool | None:
    """Whether Fisher's exact test, one of so many, tells the shares apart.

    None where one is undefined or where so few starts could not be told apart at all.
    """
    if lumped is None or free is None:
        return None
    least = shares_p(Share.counted(lumped.of, lumped.of), Share.counted(0, free.of))
    return told_apart(shares_p(lumped, free), tests) if told_apart(least, tests) else None


def h7_verdict(effects: Sequence[Effect]) -> str:
    """`holds` if freeing the planets changes the third fluctuation in any setting."""
    if any(one in (Effect.WEAKER, Effect.STRONGER) for one in effects):
        return "holds"
    return "not seen" if Effect.NONE in effects else UNDEFINED

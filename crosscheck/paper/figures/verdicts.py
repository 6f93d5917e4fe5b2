"""What decides whether a figure shows what the paper says of it; every threshold has a name.

A decision about a number that is undefined is None.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from scipy.stats import spearmanr

from crosscheck.paper.undefined import UNDEFINED, known, where_known, word

HOLDS, FAILS, CLOCK = "holds", "does not hold", "only with omega_t"

# Eq. 6 counts as accurate if it stays within this part of b of Eq. 5.
ACCURATE = 0.01
# Two printed expressions of one harmonic: rounding alone may differ.
SAME = 1e-12
# The mesh explains a deviation if at least this part is left once its inertia is rigidly there.
EXPLAINS = 0.5
# A third of the 300 rad/s^2 that the paper reads off its third fluctuation.
ACCELERATION = 100.0
# The least that the paper calls a fluctuation: for a line of a spectrum, which holds only part of
# one whose frequency wanders.
LINE = 10.0
# What moves the shoulder by that much: measured 0.11 rad/s^2 per N on its meshes.
FORCE_N = ACCELERATION / 0.11
READING = 0.25  # of a number that the paper reads off a plot
# Of the largest driving torque: below it nobody sees a ripple in a plot of the whole.
TORQUE = 0.01
# Spearman's rank correlation from which on a trend counts: among four, one pair of neighbours may
# be swapped (0.8).
TREND = 0.75
OVERSHOOT = 0.05  # Fig. 10: of the way
STRAY = 0.1  # Fig. 9: of the late force, within which it has converged
CONVERGED = 0.2  # Fig. 9: "rapidly" is within this part of the run
PROPORTIONAL = 1.5  # Fig. 15: the arm stops amplifying alike once errors are large
PROMINENT = 30.0  # Fig. 18: largest line over the median of all
ACCUMULATES = 2.0  # Fig. 15: last quarter against the first


def verdict(yes: bool | None) -> str:
    """The claims table's words for a statement that no phase law enters."""
    return word(yes, HOLDS, FAILS)


def by_law(yes: Mapping[str, bool | None]) -> str:
    """The claims table's words for {"omega_t": ..., "angle": ...}, at the figure's parameters."""
    if None in yes.values():
        return UNDEFINED
    if yes["angle"]:
        return HOLDS if yes["omega_t"] else "only with angle"
    return CLOCK if yes["omega_t"] else FAILS


@where_known
def near(value: float, stated: float, tolerance: float) -> bool:
    """Whether a value is the stated one within a relative tolerance."""
    return abs(value - stated) <= tolerance * abs(stated)


@where_known
def accurate(deviation_m: float, backlash_m: float) -> bool:
    """Fig. 4: Eq. 6 stays close to Eq. 5."""
    return deviation_m <= ACCURATE * backlash_m


@where_known
def same(difference: float, size: float) -> bool:
    """Fig. 5: two expressions differ by rounding alone."""
    return difference <= SAME * size


def converges(late_N: float, time_s: float | None, duration_s: float) -> bool | None:
    """Fig. 9: the force settles, at its late mean, early in the run."""
    if not known(late_N):
        return None
    return time_s is not None and time_s <= CONVERGED * duration_s


@where_known
def grows(values: Sequence[float]) -> bool:
    """Fig. 8: every value is larger than the one before."""
    return bool(np.all(np.diff(values) > 0))


@where_known
def explains(left: float, deviation: float) -> bool:
    """Figs. 6, 7: what is left of a deviation is still most of it."""
    return left >= EXPLAINS * deviation


@where_known
def fluctuates(acceleration_rad_per_s2: float) -> bool:
    """Fig. 14: a fluctuation of the paper's kind."""
    return acceleration_rad_per_s2 >= ACCELERATION


@where_known
def restrained(overshoot: float) -> bool:
    """Fig. 10: an overshoot, as a part of the way, that is not considerable."""
    return overshoot <= OVERSHOOT


@where_known
def in_range(value: float, low: float, high: float) -> bool:
    """Fig. 14: between two values read off a plot."""
    return (1 - READING) * low <= value <= (1 + READING) * high


@where_known
def stands_out(acceleration_rad_per_s2: float) -> bool:
    """Figs. 18, 20: a line of a fluctuation, not of what is left of an impact."""
    return acceleration_rad_per_s2 >= LINE


@where_known
def larger(one: float, other: float) -> bool:
    """Figs. 18, 20: a line of one joint over that of the other."""
    return one > other


@where_known
def visible(torque: float, largest: float) -> bool:
    """Fig. 11: a ripple of the torque that can be seen."""
    return torque >= TORQUE * largest


def rank_correlation(sizes: Sequence[float], values: Sequence[float]) -> float:
    """Spearman's; 0 if all values are equal."""
    if np.ptp(values) == 0:
        return 0.0
    return float(spearmanr(sizes, values).statistic)


@where_known
def rises(sizes: Sequence[float], values: Sequence[float]) -> bool:
    """Values grow with the sizes."""
    return rank_correlation(sizes, values) >= TREND


@where_known
def falls(sizes: Sequence[float], values: Sequence[float]) -> bool:
    """Values shrink as the sizes grow."""
    return rank_correlation(sizes, values) <= -TREND


@where_known
def fluctuation_falls(sizes: Sequence[float], forces_N: Sequence[float]) -> bool:
    """Fig. 17: there is a fluctuation of the mesh force, and it recedes as the sizes grow."""
    return max(forces_N) >= FORCE_N and rank_correlation(sizes, forces_N) <= -TREND


@where_known
def fluctuation_rises(sizes: Sequence[float], forces_N: Sequence[float]) -> bool:
    """Fig. 19: there is a fluctuation of the mesh force, and it grows with the sizes."""
    return max(forces_N) >= FORCE_N and rank_correlation(sizes, forces_N) >= TREND


def appears_at(sizes: Sequence[float], forces_N: Sequence[float]) -> float | None:
    """The smallest size at which the mesh force fluctuates; None if at none that is known."""
    return min((s for s, f in zip(sizes, forces_N, strict=True) if f >= FORCE_N), default=None)


@where_known
def proportional(spread: float) -> bool:
    """Fig. 15: largest over smallest ratio of an error to its cause."""
    return spread <= PROPORTIONAL


@where_known
def continuous(prominence: float) -> bool:
    """Fig. 18: the largest line of a spectrum hardly stands out of it."""
    return prominence < PROMINENT


@where_known
def accumulates(first_quarter: float, last_quarter: float) -> bool:
    """Fig. 15: an error that is larger at the end than at the beginning."""
    return last_quarter >= ACCUMULATES * first_quarter

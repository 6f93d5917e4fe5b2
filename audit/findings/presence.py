"""Under which laws of the mesh phase the tooth error makes a third fluctuation at all."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from enum import StrEnum
from typing import NamedTuple

import numpy as np
from scipy.stats import fisher_exact

from crosscheck.audit.claims.study_plan import ResultsByCondition
from crosscheck.audit.experiments.experiments import NO_ERROR, PD
from crosscheck.audit.judging.rule import FEW, Limits, State, state
from crosscheck.audit.judging.shares import Share
from crosscheck.audit.measures.third_fluctuation import LARGE, VISIBLE, ThirdFluctuation

SIGNIFICANT = 0.05
PHASES = ("omega_t", "angle")
LEVELS = {"visible": VISIBLE, "severe": LARGE}


def shares_p(first: Share, second: Share) -> float:
    """Chance of shares at least as unlike if one probability is behind both (Fisher, exact)."""
    table = [[share.yes, share.of - share.yes] for share in (first, second)]
    return float(fisher_exact(table).pvalue)


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
        told = state(self.share)
        return State.NO if told == State.BISTABLE and self.p >= SIGNIFICANT else told


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


class Presence(StrEnum):
    """The phase laws under which the tooth error makes a third fluctuation."""

    PRINTED = "only with omega_t"
    INTEGRATED = "only with angle"
    BOTH = "with both"
    NEITHER = "with neither"
    UNKNOWN = "undefined"


def find_presence(states: Mapping[str, Sequence[State]]) -> Presence:
    """The laws under which the fluctuation is present, from all settings' states by phase law.

    Present where one setting says yes or that the start decides; unknown if a law has no setting
    that says anything.
    """
    if any(set(law_states) <= {State.UNDEFINED} for law_states in states.values()):
        return Presence.UNKNOWN
    clock, angle = (bool({State.YES, State.BISTABLE} & set(states[phase])) for phase in PHASES)
    if clock == angle:
        return Presence.BOTH if clock else Presence.NEITHER
    return Presence.PRINTED if clock else Presence.INTEGRATED


def find_presence_by_level(settings: ResultsByCondition) -> dict[str, Presence]:
    """The laws under which the fluctuation exceeds each of LEVELS, from settings that claims use.

    Start i with the tooth error is compared with start i without it.
    """
    presence_by_level = {}
    for name, level in LEVELS.items():
        states: dict[str, list[State]] = {phase: [] for phase in PHASES}
        for condition, results in settings:
            third, without = (
                ThirdFluctuation.from_samples(results[each]) for each in (PD, NO_ERROR)
            )
            effect = compute_error_effect(third, without, level)
            states[condition.law.phase].append(effect.state)
        presence_by_level[name] = find_presence(states)
    return presence_by_level

"""A claim with its answers, its verdict, and how far that is from turning."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Literal, NamedTuple

import numpy as np

from crosscheck.audit.claims import rule
from crosscheck.audit.claims.rule import Answer, Claim, State, Verdict, VerdictKind
from crosscheck.audit.experiments.paper_conditions import MODELS, GearModel
from crosscheck.audit.measures.shares import Share

CLOSE = 0.25  # of a limit: one as arbitrary might as well have been drawn there


class TurningLimits(NamedTuple):
    """The limits nearest to a claim's own, downwards and upwards, at which its verdict turns.

    None where no other limit turns it. Of two-sided limits each is changed by itself.
    """

    low: tuple[float | None, float | None]
    high: tuple[float | None, float | None]


@dataclass(frozen=True)
class ClaimJudgement:
    """A claim and its answers in all settings."""

    claim: Claim
    answers: tuple[Answer, ...]

    @cached_property
    def verdict(self) -> Verdict:
        """The verdict over all settings of all models of the gears."""
        return rule.verdict(self.answers, self.claim.free)

    @cached_property
    def by_model(self) -> dict[GearModel, Verdict]:
        """The verdict over the settings of each model of the gears; empty for a static claim."""
        if self.claim.static:
            return {}
        answers_by_model = {
            model: [a for a in self.answers if a.place.model == model] for model in MODELS
        }
        return {
            model: rule.verdict(answers, self.claim.free)
            for model, answers in answers_by_model.items()
        }

    def half_grid_verdict(self, left_out: int) -> Verdict:
        """The verdict without every second damping ratio, from the first (0) or second (1)."""
        zetas = sorted({a.place.zeta for a in self.answers if a.place.zeta is not None})
        out = set(zetas[left_out::2])
        kept = [answer for answer in self.answers if answer.place.zeta not in out]
        return rule.verdict(kept, self.claim.free)

    @cached_property
    def is_grid_sensitive(self) -> bool:
        """Whether either half of the damping ratios gives a verdict of another kind."""
        if self.claim.static:
            return False
        return any(self.half_grid_verdict(half).kind != self.verdict.kind for half in (0, 1))

    @cached_property
    def is_start_sensitive(self) -> bool:
        """Whether one more start of one setting, whatever it does, could turn the verdict."""
        if self.claim.static:
            return False
        states = [answer.state for answer in self.answers]
        return any(
            rule.kind_of([*states[:at], new_state, *states[at + 1 :]]) != self.verdict.kind
            for at, answer in enumerate(self.answers)
            for new_state in _reachable_states(answer) - {answer.state}
        )

    @cached_property
    def turning(self) -> TurningLimits:
        """The nearest limits at which the verdict would turn."""
        return TurningLimits(low=self._turning_limits("low"), high=self._turning_limits("high"))

    @cached_property
    def is_limit_sensitive(self) -> bool:
        """Whether limits at most CLOSE of their size away from the claim's own turn the verdict."""
        return any(
            at is not None and abs(at - limit) <= CLOSE * abs(limit)
            for limit, pair in zip(
                (self.claim.limits.low, self.claim.limits.high), self.turning, strict=True
            )
            for at in pair
        )

    def _turning_limits(self, end: Literal["low", "high"]) -> tuple[float | None, float | None]:
        """The nearest places below and above one end of the limits where the verdict turns."""
        limit: float = getattr(self.claim.limits, end)
        if math.isinf(limit):
            return None, None
        places = sorted({at for a in self.answers for at in self._turning_places(a, end)})

        def find_turning(candidates: Sequence[float], towards: float) -> float | None:
            for at in candidates:
                beyond: dict[str, Any] = {end: math.nextafter(at, towards)}
                moved_limits = replace(self.claim.limits, **beyond)
                states = [rule.state(a.share_at(moved_limits)) for a in self.answers]
                if rule.kind_of(states) != self.verdict.kind:
                    return at
            return None

        below, beyond = (
            [at for at in reversed(places) if at < limit],
            [at for at in places if at > limit],
        )
        return find_turning(below, -math.inf), find_turning(beyond, math.inf)

    def _turning_places(self, answer: Answer, end: str) -> Iterator[float]:
        """Values of single starts that, as that end of the limits, change the setting's state."""
        values, limits = np.array(answer.values), self.claim.limits
        inside = values[values < limits.high][::-1] if end == "low" else values[values > limits.low]
        if values.size:
            most_no, least_yes = rule.state_thresholds(values.size)
            for count in (most_no + 1, least_yes):
                if 1 <= count <= inside.size:
                    yield float(inside[count - 1])


def _reachable_states(answer: Answer) -> set[State]:
    """The states that the setting could have after one more start."""
    share = answer.share
    if share is None:
        return set()
    return {rule.state(Share(share.yes + yes, share.of + 1)) for yes in (0, 1)}


@dataclass(frozen=True)
class VariantVerdict:
    """The verdict on a claim from one of VARIANTS, beside that from the model next to it."""

    model: GearModel
    kind: VerdictKind
    base_kind: VerdictKind

    @property
    def is_different(self) -> bool:
        """Whether the variant's verdict is of another kind than that model's."""
        return self.kind != self.base_kind

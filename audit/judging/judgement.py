"""A claim with its answers, its verdict, and how far that is from turning."""

from __future__ import annotations

import math
from collections.abc import Hashable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Literal, NamedTuple

import numpy as np

from crosscheck.audit.judging import rule
from crosscheck.audit.judging.rule import Answer, Claim, State, Verdict
from crosscheck.audit.judging.shares import Share

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
        """The verdict over all settings."""
        return rule.verdict(self.answers, self.claim.free)

    def half_grid_verdict(self, name: str, left_out: int) -> Verdict:
        """The verdict without every second value of a condition, from the first (0) or second."""
        out = set(self._grids[name][left_out::2])
        kept = [answer for answer in self.answers if answer.place.value_of(name) not in out]
        return rule.verdict(kept, self.claim.free)

    @cached_property
    def _grids(self) -> dict[str, list[float]]:
        """The values of all conditions that are numbers, ascending."""
        values_by_name: dict[str, set[Hashable]] = {}
        for answer in self.answers:
            for name, value in answer.place.conditions:
                values_by_name.setdefault(name, set()).add(value)
        return {
            name: sorted(float(value) for value in values if isinstance(value, int | float))
            for name, values in values_by_name.items()
            if all(isinstance(value, int | float) for value in values)
        }

    @cached_property
    def is_grid_sensitive(self) -> bool:
        """Whether either half of a condition's numbers gives a verdict of another kind."""
        if self.claim.static:
            return False
        return any(
            self.half_grid_verdict(name, half).kind != self.verdict.kind
            for name in self._grids
            for half in (0, 1)
        )

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

"""A claim with its answers, its verdict, and whether that is near to turning."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from crosscheck.audit.judging import rule
from crosscheck.audit.judging.rule import Answer, Claim, Verdict

CLOSE = 0.25  # of a limit: one as arbitrary might as well have been drawn there


@dataclass(frozen=True)
class ClaimJudgement:
    """A claim and its answers in all settings."""

    claim: Claim
    answers: tuple[Answer, ...]

    @cached_property
    def verdict(self) -> Verdict:
        """The verdict over all settings."""
        return rule.verdict(self.answers, self.claim.free)

    @cached_property
    def is_limit_sensitive(self) -> bool:
        """Whether limits at most CLOSE of their size away from the claim's own turn the verdict.

        Of two-sided limits each is changed by itself.
        """
        return any(
            self._kind_with(end, at) != self.verdict.kind
            for end in ("low", "high")
            for at in {at for answer in self.answers for at in self._turning_places(answer, end)}
        )

    def _kind_with(self, end: str, limit: float) -> rule.VerdictKind:
        """The verdict's kind with another limit."""
        changed: dict[str, Any] = {end: limit}
        moved_limits = replace(self.claim.limits, **changed)
        return rule.kind_of([rule.state(answer.share_at(moved_limits)) for answer in self.answers])

    def _turning_places(self, answer: Answer, end: str) -> Iterator[float]:
        """Limits near the claim's own, just beyond those that change the setting's state."""
        limits = self.claim.limits
        limit, values = getattr(limits, end), np.array(answer.values)
        if math.isinf(limit) or not values.size:
            return
        inside = values[values < limits.high][::-1] if end == "low" else values[values > limits.low]
        most_no, least_yes = rule.state_thresholds(values.size)
        for count in (most_no + 1, least_yes):
            if 1 <= count <= inside.size:
                at = float(inside[count - 1])
                if 0 < abs(at - limit) <= CLOSE * abs(limit):
                    yield math.nextafter(at, math.copysign(math.inf, at - limit))

"""How much of the paper's study is run."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from crosscheck.audit.experiments.variant import Variant

STARTS = 32


@dataclass(frozen=True)
class Scale:
    """How much is run. longest_s: limit of mesh simulations.

    What a run is then too short for is undefined, in words and records. most_starts: of a sample;
    first_seed: of every sample's starts, whose seeds follow one another.
    """

    longest_s: float = math.inf
    most_starts: int = STARTS
    first_seed: int = 1

    @property
    def seeds(self) -> tuple[int, ...]:
        """The seeds of a sample's starts."""
        return tuple(range(self.first_seed, self.first_seed + self.most_starts))

    def limit_duration(self, duration_s: float) -> float:
        """A duration [s], cut to longest_s."""
        return min(duration_s, self.longest_s)

    def limit_starts(self, count: int) -> int:
        """A number of starts, cut to most_starts."""
        return min(count, self.most_starts)

    def cut(self, variant: Variant) -> Variant:
        """The variant with its run cut to longest_s."""
        if math.isinf(self.longest_s):
            return variant
        duration_s = variant.case().scenario.duration_s
        return replace(variant, duration_s=self.limit_duration(duration_s))


FULL = Scale()

"""The paper's third fluctuation over many starts: how often it is severe.

One definition for all chapters: the numbers of ``experiments.pd``, the claims' quantity and
threshold.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from crosscheck.audit.judging.rule import (
    PARTS,
    Answer,
    Limits,
    Place,
    State,
    quantiles_of,
    state,
)
from crosscheck.audit.judging.sample import Sample
from crosscheck.audit.judging.shares import Share
from crosscheck.audit.measures.thresholds import SEVERE

# As 3.2-11 has it, whose reason stands in statements.toml.
LARGE = Limits(low=SEVERE)
Quantiles = tuple[float | None, ...]
NONE: Quantiles = (None,) * len(PARTS)


def quantiles(values: np.ndarray) -> Quantiles:
    """The quantiles PARTS of what is defined, each the value of a start; NONE without any."""
    return quantiles_of(values[np.isfinite(values)]) or NONE


@dataclass(frozen=True)
class ThirdFluctuation:
    """The size [rad/s^2] of every start that was run, (starts,), nan where undefined."""

    size: np.ndarray

    @classmethod
    def from_samples(cls, *samples: Sample) -> ThirdFluctuation:
        """The third fluctuations of all starts of several samples."""
        return cls(np.concatenate([sample["third"][: sample.run] for sample in samples]))

    @cached_property
    def sizes(self) -> np.ndarray:
        """The sizes [rad/s^2] that are defined."""
        return self.size[np.isfinite(self.size)]

    @cached_property
    def share(self) -> Share | None:
        """The share of the defined starts above SEVERE; None if too few are defined."""
        return self.answer(Place()).share

    def answer(self, place: Place) -> Answer:
        """The answer at a place to the claim that the fluctuation is severe."""
        sizes = tuple(map(float, np.sort(self.sizes)))
        return Answer(place, sizes, self.size.size, LARGE)

    @property
    def state(self) -> State:
        """Whether the third fluctuation is severe, or the start decides."""
        return state(self.share)

    @property
    def quantiles(self) -> Quantiles:
        """The quantiles of the size [rad/s^2]."""
        return quantiles(self.size)

    @property
    def severe_count(self) -> int:
        """How many starts are above SEVERE."""
        return int(LARGE.contains(self.size).sum())

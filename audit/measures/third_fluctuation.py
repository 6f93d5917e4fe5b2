"""The paper's third fluctuation over many starts: how often it is severe, and each branch alone.

One definition for all chapters: the numbers of ``experiments.pd``, the claims' quantity and
threshold.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from crosscheck.audit.claims.rule import (
    PARTS,
    Answer,
    Place,
    State,
    limits_above,
    quantiles_of,
    state,
)
from crosscheck.audit.experiments.samples import Sample
from crosscheck.audit.measures.shares import Share
from crosscheck.audit.measures.thresholds import EVIDENT, SEVERE

LARGE = limits_above(
    SEVERE, "four times the rigid arm's own largest acceleration, a third of the 300"
)
VISIBLE = limits_above(EVIDENT, "the smallest that Section 3.2 calls a fluctuation")
Quantiles = tuple[float | None, ...]
NONE: Quantiles = (None,) * len(PARTS)


def quantiles(values: np.ndarray) -> Quantiles:
    """The quantiles PARTS of what is defined, each the value of a start; NONE without any."""
    return quantiles_of(values[np.isfinite(values)]) or NONE


class Branch(NamedTuple):
    """The starts on one side of SEVERE, and the medians of these alone; None without any."""

    starts: int
    size: float | None
    onset_s: float | None
    frequency_Hz: float | None


@dataclass(frozen=True)
class ThirdFluctuation:
    """The third fluctuation of every start that was run, (starts,), nan where undefined.

    size [rad/s^2]; onset_s; frequency_Hz; planet_spread_m: how far planets of a stage part;
    diverged: how many runs did, whose numbers are undefined.
    """

    size: np.ndarray
    onset_s: np.ndarray
    frequency_Hz: np.ndarray
    planet_spread_m: np.ndarray
    diverged: int

    @classmethod
    def from_samples(cls, *samples: Sample) -> ThirdFluctuation:
        """The third fluctuations of all starts of several samples."""
        return cls(
            size=_join_samples(samples, "third"),
            onset_s=_join_samples(samples, "third_onset_s"),
            frequency_Hz=_join_samples(samples, "frequency_Hz"),
            planet_spread_m=_join_samples(samples, "planets_apart_m"),
            diverged=sum(int(sample.diverged[: sample.run].sum()) for sample in samples),
        )

    @cached_property
    def sizes(self) -> np.ndarray:
        """The sizes [rad/s^2] that are defined."""
        return self.size[np.isfinite(self.size)]

    @cached_property
    def share(self) -> Share | None:
        """The share of the defined starts above SEVERE; None if too few are defined."""
        return self.answer(Place(None, "", None, "")).share

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

    def select_branch(self, severe: bool) -> np.ndarray:
        """Which starts are severe, or which defined ones are not, (starts,)."""
        chosen = LARGE.contains(self.size)
        return chosen if severe else np.isfinite(self.size) & ~chosen

    def branch(self, severe: bool) -> Branch:
        """The severe starts, or the others, and the medians of these alone."""
        chosen = self.select_branch(severe)
        numbers = (self.size, self.onset_s, self.frequency_Hz)
        medians = [quantiles(values[chosen])[1] for values in numbers]
        return Branch(int(chosen.sum()), *medians)


def _join_samples(samples: Sequence[Sample], name: str) -> np.ndarray:
    return np.concatenate([sample[name][: sample.run] for sample in samples])

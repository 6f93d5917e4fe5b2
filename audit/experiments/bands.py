"""Between which values the runs from many starts lie, for drawings."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from crosscheck.audit.experiments.starts import Perturbed
from crosscheck.audit.measures.course import Course
from crosscheck.models.errors import Diverged
from crosscheck.signals import envelope

SHOULDER = ("theta_ddot", "torque", "x_sp", "F_sp")


class Band(NamedTuple):
    """Lowest and highest value of all starts in every bin, each (bins,)."""

    low: list[float]
    high: list[float]


class Between(NamedTuple):
    """time (bins,) [s]; by the quantity's name in a Course, of the shoulder; starts: how many.

    Starts that diverged are not among them.
    """

    time: list[float]
    bands: dict[str, Band]
    starts: int


@dataclass(frozen=True)
class Bands(Perturbed[Between]):
    """Of its starts' runs, so many bins over all of each."""

    bins: int

    def answer(self) -> Between:
        found = [self._of(run) for run in self._runs(self.seeds) if not isinstance(run, Diverged)]
        if not found:
            return Between([], {name: Band([], []) for name in SHOULDER}, 0)
        bands = {}
        for name in SHOULDER:
            low, high = np.array([one[name] for one in found]).transpose(1, 0, 2)
            bands[name] = Band(low.min(axis=0).tolist(), high.max(axis=0).tolist())
        return Between(found[0]["time"][0].tolist(), bands, len(found))

    def _of(self, run: Course) -> dict[str, np.ndarray]:
        """By quantity (2, bins): lowest and highest values of a run; of the time the middles."""
        binned = {n: envelope(run.time, shoulder(run, n), self.bins) for n in SHOULDER}
        times = {"time": np.array([binned["torque"][0]])}
        return times | {name: np.array(found[1:]) for name, found in binned.items()}


def shoulder(run: Course, name: str) -> np.ndarray:
    """A quantity of the shoulder, (times,)."""
    values = getattr(run, name)
    return values[:, 0] if values.ndim > 1 else values

"""Between which values the runs from many starts lie, for drawings."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from crosscheck.audit.experiments.ensembles import EnsembleQuestion
from crosscheck.audit.measures.run_signals import RunSignals
from crosscheck.models.errors import Diverged
from crosscheck.signals import envelope

SHOULDER = ("theta_ddot", "torque", "x_sp", "F_sp")


class Band(NamedTuple):
    """The lowest and highest value of all starts in every bin, each (bins,)."""

    low: list[float]
    high: list[float]


class ShoulderBands(NamedTuple):
    """Bands of the shoulder's runs. time (bins,) [s]; bands: by name in a Course; starts: how many.

    Starts that diverged are not among them.
    """

    time: list[float]
    bands: dict[str, Band]
    starts: int


@dataclass(frozen=True)
class BandsQuestion(EnsembleQuestion[ShoulderBands]):
    """A question: bands in which the runs from these starts lie, so many bins over each run."""

    bins: int

    def answer(self) -> ShoulderBands:
        times, lows, highs = list[np.ndarray](), [], []
        for run in self._runs(self.seeds):
            if not isinstance(run, Diverged):
                binned = [envelope(run.time, shoulder_signal(run, n), self.bins) for n in SHOULDER]
                times.append(binned[SHOULDER.index("torque")][0])
                lows.append([low for _, low, _ in binned])
                highs.append([high for _, _, high in binned])
        if not times:
            return ShoulderBands([], {name: Band([], []) for name in SHOULDER}, 0)
        low, high = np.min(lows, axis=0).tolist(), np.max(highs, axis=0).tolist()
        bands = dict(zip(SHOULDER, map(Band, low, high), strict=True))
        return ShoulderBands(times[0].tolist(), bands, len(times))


def shoulder_signal(run: RunSignals, name: str) -> np.ndarray:
    """A quantity of the shoulder, (times,)."""
    values = getattr(run, name)
    return values[:, 0] if values.ndim > 1 else values

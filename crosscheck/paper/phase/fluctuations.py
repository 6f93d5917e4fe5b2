"""What runs tell of their third fluctuation, alone and over several starts."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr

from crosscheck.paper.phase.rigid import rigid_motion
from crosscheck.paper.phase.verdict import Vibration
from crosscheck.paper.rigid import RIGID_STEP_S
from crosscheck.studies.study import Comparison, Numbers, Study, Variant
from models.errors import Diverged


@dataclass(frozen=True)
class Fluctuation:
    """A run's third fluctuation, see the measures; None for what is undefined or not asked.

    planet_spread_m: how far planets of a stage part; rounding_m: added at the teeth in every step;
    diverged_s: when the run diverged.
    """

    onset_s: float | None = None
    frequency_Hz: float | None = None
    amplitude_rad_per_s2: float | None = None
    planet_spread_m: float | None = None
    rounding_m: float | None = None
    diverged_s: float | None = None

    @classmethod
    def of(cls, numbers: Numbers) -> Fluctuation:
        """From what a measure gave. Raises TypeError for a number of another name."""
        return cls(**numbers)


def measured(
    study: Study, variants: Sequence[Variant], measure: Comparison, what: str
) -> list[Fluctuation]:
    """Of every variant's run."""
    return [Fluctuation.of(numbers) for numbers in study.measures(variants, measure, what)]


def one_start(
    variant: Variant, numbers: Callable[[tuple[xr.Dataset, ...]], Numbers]
) -> Fluctuation:
    """Of a run that no variant states; numbers: beside the rigid arm in this one's experiment."""
    try:
        return Fluctuation.of(numbers((rigid_motion(variant.case(), RIGID_STEP_S, 1),)))
    except Diverged as error:
        return Fluctuation(diverged_s=error.time_s)


@dataclass(frozen=True)
class Spread:
    """One quantity over several starts; all None if it is undefined in one of them."""

    median: float | None = None
    smallest: float | None = None
    largest: float | None = None

    @classmethod
    def of(cls, values: Sequence[float | None]) -> Spread:
        """Of every start's value: one that diverged, or ends before, has no onset."""
        known = [value for value in values if value is not None]
        if len(known) < len(values):
            return cls()
        return cls(float(np.median(known)), min(known), max(known))


@dataclass(frozen=True)
class Fluctuations:
    """The third fluctuation over several starts, each quantity as in ``Fluctuation``."""

    onset_s: Spread
    frequency_Hz: Spread
    amplitude_rad_per_s2: Spread
    planet_spread_m: Spread
    rounding_m: Spread

    @classmethod
    def of(cls, runs: Sequence[Fluctuation]) -> Fluctuations:
        """One run for every start."""
        return cls(
            onset_s=Spread.of([run.onset_s for run in runs]),
            frequency_Hz=Spread.of([run.frequency_Hz for run in runs]),
            amplitude_rad_per_s2=Spread.of([run.amplitude_rad_per_s2 for run in runs]),
            planet_spread_m=Spread.of([run.planet_spread_m for run in runs]),
            rounding_m=Spread.of([run.rounding_m for run in runs]),
        )

    @property
    def vibration(self) -> tuple[Spread, Spread, Spread]:
        """In the order of ``Vibration``."""
        return self.onset_s, self.frequency_Hz, self.amplitude_rad_per_s2

    @property
    def medians(self) -> Vibration:
        """What models are compared by."""
        return Vibration(*(spread.median for spread in self.vibration))

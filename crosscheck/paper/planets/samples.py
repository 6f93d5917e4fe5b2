"""The third fluctuation over many starts: a sample for every setting."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from pydantic import JsonValue

from crosscheck.paper.numbers import defined
from crosscheck.paper.phase.cells import DURATION_S, LABELLED, READINGS
from crosscheck.paper.phase.experiments import ANALYTIC, Setting
from crosscheck.paper.phase.fluctuations import Fluctuation, measured
from crosscheck.paper.phase.planets import FLUCTUATION_AND_SPREAD
from crosscheck.paper.planets.verdict import Share, is_large
from crosscheck.paper.record import JsonObject
from crosscheck.paper.scale import Scale
from crosscheck.studies.study import Study, Variant
from crosscheck.studies.variant import Planets

RECORD_EVERY = 10  # 10 kHz, in every model: a record costs Exudyn as much as three steps
PARTS = (0.1, 0.5, 0.9)


@dataclass(frozen=True)
class Cell:
    """A setting: arm's file, phase law, damping ratio and ring rate."""

    law: str
    setting: Setting
    arm: str = LABELLED

    @property
    def reading(self) -> str:
        """Of Table I."""
        return READINGS[self.arm]

    def starts(
        self, planets: Planets, starts: Sequence[int], model: str = ANALYTIC
    ) -> list[Variant]:
        """A run for every start."""
        one = Variant(
            arm=self.arm,
            phase=self.law,
            ring_rate=self.setting.ring_rate,
            zeta=self.setting.zeta,
            model=model,
            duration_s=DURATION_S,
            record_every=RECORD_EVERY,
            planets=planets,
        )
        return [replace(one, seed=seed) for seed in starts]


@dataclass(frozen=True)
class Request:
    """A sample to be made: cell, planets lumped or free, starts by their seeds, and the model."""

    cell: Cell
    planets: Planets
    seeds: tuple[int, ...]
    model: str = ANALYTIC

    def variants(self, scale: Scale) -> list[Variant]:
        """Its runs."""
        found = self.cell.starts(self.planets, self.seeds, self.model)
        return [scale.cut(one) for one in found]


@dataclass(frozen=True)
class Quantiles:
    """0.1, 0.5 and 0.9 of a quantity over the starts; None where undefined."""

    low: float | None = None
    median: float | None = None
    high: float | None = None

    @classmethod
    def of(cls, values: Sequence[float]) -> Quantiles:
        """Undefined if one of the values is nan; an infinite quantile has no number."""
        if not values or any(map(math.isnan, values)):
            return cls()
        found = np.quantile(values, PARTS, method="inverted_cdf")
        return cls(*(defined(value) for value in found))


@dataclass(frozen=True)
class Sample:
    """The third fluctuation of every start."""

    runs: tuple[Fluctuation, ...]

    @cached_property
    def amplitudes(self) -> tuple[float, ...]:
        """[rad/s^2]; infinite where a run diverged, nan where it ends before."""
        return tuple(_amplitude(run) for run in self.runs)

    @property
    def defined(self) -> bool:
        """Whether every start has an amplitude, if an infinite one."""
        return not any(map(math.isnan, self.amplitudes))

    @cached_property
    def share(self) -> Share | None:
        """Of starts with a large fluctuation; None if undefined in one."""
        if not self.defined:
            return None
        large = [value == math.inf or is_large(value) for value in self.amplitudes]
        return Share.counted(sum(map(bool, large)), len(large))

    @property
    def of_two_minds(self) -> bool:
        """Whether it depends on the start if the fluctuation is large."""
        return self.share is not None and 0 < self.share.yes < self.share.of

    @property
    def amplitude(self) -> Quantiles:
        """Of the amplitude [rad/s^2]."""
        return Quantiles.of(self.amplitudes)

    @property
    def spread(self) -> Quantiles:
        """Of how far planets of a stage part at most [m]."""
        found = (run.planet_spread_m for run in self.runs)
        return Quantiles.of([math.nan if value is None else value for value in found])

    @property
    def onset(self) -> Quantiles:
        """Of the onset [s] of the large ones."""
        return Quantiles.of([run.onset_s for run in self._large if run.onset_s is not None])

    @property
    def frequency(self) -> Quantiles:
        """Of the frequency [Hz] of the large ones."""
        found = (run.frequency_Hz for run in self._large)
        return Quantiles.of([value for value in found if value is not None])

    @property
    def _large(self) -> list[Fluctuation]:
        return [run for run in self.runs if is_large(run.amplitude_rad_per_s2)]

    def to_dict(self) -> JsonObject:
        """For JSON."""
        share = self.share
        return {
            "starts": len(self.runs),
            "large": None if share is None else share.yes,
            "share": None if share is None else share.value,
            "share_low": None if share is None else share.low,
            "share_high": None if share is None else share.high,
            "amplitude_rad_per_s2": _listed(self.amplitude),
            "planet_spread_m": _listed(self.spread),
            "onset_s": _listed(self.onset),
            "frequency_Hz": _listed(self.frequency),
        }


def _amplitude(run: Fluctuation) -> float:
    if run.diverged_s is not None:
        return math.inf
    return math.nan if run.amplitude_rad_per_s2 is None else run.amplitude_rad_per_s2


def _listed(quantiles: Quantiles) -> list[JsonValue]:
    return [quantiles.low, quantiles.median, quantiles.high]


def samples(
    study: Study, requests: Sequence[Request], scale: Scale, what: str
) -> Mapping[Request, Sample]:
    """Every sample; runs that several of them need are made once."""
    variants = [one for request in requests for one in request.variants(scale)]
    runs = iter(measured(study, variants, FLUCTUATION_AND_SPREAD, what))
    return {
        request: Sample(tuple(next(runs) for _ in range(len(request.seeds))))
        for request in requests
    }

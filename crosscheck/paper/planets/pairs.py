"""Two samples of the third fluctuation, and whether one distribution could be behind both."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

from crosscheck.paper.numbers import defined
from crosscheck.paper.phase.experiments import ENGINE, SETTINGS, Setting
from crosscheck.paper.planets.samples import Cell, Request, Sample, samples
from crosscheck.paper.planets.verdict import (
    SIGNIFICANT,
    WORTH,
    Effect,
    effect,
    least_p,
    one_distribution,
    shares_p,
    sizes_p,
)
from crosscheck.paper.record import JsonObject, Record
from crosscheck.paper.scale import Scale
from crosscheck.studies.study import Study

ENGINE_STARTS: Mapping[Setting, int] = dict(zip(SETTINGS, (16, 8), strict=True))
STARTS = 24  # of the analytic model where it is compared


@dataclass(frozen=True)
class TwoTests:
    """p of both tests on two samples; nan where a start is undefined."""

    by_share: float
    by_size: float

    @classmethod
    def of(cls, one: Sample, other: Sample) -> TwoTests:
        """Fisher's exact test of the shares, Mann and Whitney's of the amplitudes."""
        if one.share is None or other.share is None:
            return cls(math.nan, math.nan)
        return cls(shares_p(one.share, other.share), sizes_p(one.amplitudes, other.amplitudes))

    def to_dict(self) -> JsonObject:
        """For JSON."""
        return {"p_of_shares": defined(self.by_share), "p_of_sizes": defined(self.by_size)}


@dataclass(frozen=True)
class Freed(Record):
    """A cell with lumped and with free planets; family: how many tests share the 5 %."""

    cell: Cell
    lumped: Sample
    free: Sample
    family: int

    @property
    def id(self) -> str:
        cell, (zeta, ring) = self.cell, self.cell.setting
        return f"planets/{cell.arm}/{cell.law}/{ring}/{zeta:g}"

    @cached_property
    def tests(self) -> TwoTests:
        """Whether the samples differ."""
        return TwoTests.of(self.lumped, self.free)

    @property
    def effect(self) -> Effect:
        """What freeing the planets does."""
        return self.effect_at(WORTH)

    def effect_at(self, worth: float) -> Effect:
        """The same if medians must differ by so much (relative) to be worth telling."""
        amplitudes, tests = (self.lumped.amplitudes, self.free.amplitudes), self.tests
        return effect(*amplitudes, tests.by_share, tests.by_size, self.family, worth)

    def to_dict(self) -> JsonObject:
        cell = self.cell
        return {
            "id": self.id,
            "arm": cell.arm,
            "phase": cell.law,
            **cell.setting._asdict(),
            "lumped": self.lumped.to_dict(),
            "free": self.free.to_dict(),
            **self.tests.to_dict(),
            "effect": self.effect,
        }


@dataclass(frozen=True)
class TwoModels(Record):
    """One setting under `omega_t`: the analytic model, planets free and lumped, and Exudyn's."""

    setting: Setting
    lumped: Sample
    analytic: Sample
    engine: Sample

    @property
    def id(self) -> str:
        return f"engine/{self.setting.ring_rate}/{self.setting.zeta:g}"

    @cached_property
    def tests(self) -> TwoTests:
        """Whether the models with free planets differ."""
        return TwoTests.of(self.analytic, self.engine)

    @property
    def same(self) -> bool | None:
        """Whether no test tells them apart; None where so few starts never could be."""
        if not self.could_differ:
            return None
        return one_distribution(self.tests.by_share, self.tests.by_size)

    @property
    def could_differ(self) -> bool:
        """Whether a test could tell samples of these sizes apart at all."""
        return least_p(len(self.analytic.runs), len(self.engine.runs)) < SIGNIFICANT

    @property
    def shown(self) -> bool | None:
        """Whether Exudyn has a large fluctuation in any start."""
        return None if self.engine.share is None else self.engine.share.yes > 0

    def to_dict(self) -> JsonObject:
        return {
            "id": self.id,
            **self.setting._asdict(),
            "analytic": self.analytic.to_dict(),
            "engine": self.engine.to_dict(),
            "lumped": self.lumped.to_dict(),
            **self.tests.to_dict(),
            "same": self.same,
        }


def two_models(study: Study, scale: Scale) -> list[TwoModels]:
    """Both settings of the third fluctuation."""
    wanted = [_requests(setting, scale) for setting in SETTINGS]
    requests = [request for three in wanted for request in three]
    found = samples(study, requests, scale, "planets: two models")
    return [
        TwoModels(setting, *(found[request] for request in three))
        for setting, three in zip(SETTINGS, wanted, strict=True)
    ]


def _requests(setting: Setting, scale: Scale) -> list[Request]:
    """Of the analytic model with lumped planets, with free ones, and of Exudyn."""
    cell, seeds = Cell("omega_t", setting), tuple(range(1, scale.starts(STARTS) + 1))
    own = [Request(cell, "lumped", seeds), Request(cell, "free", seeds)]
    return [*own, Request(cell, "free", seeds[: ENGINE_STARTS[setting]], ENGINE)]

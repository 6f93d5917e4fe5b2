"""Evidence 3: the same vibration in an independent engine, whose planets all move by themselves."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product
from typing import NamedTuple

import numpy as np

from crosscheck.audit.experiments.cells import PRINTED, REPAIRED_RATE, Cell
from crosscheck.audit.experiments.experiments import PD, SHORT_S, question
from crosscheck.audit.experiments.pool import Sample
from crosscheck.audit.experiments.starts import TransientPd
from crosscheck.audit.measures import shares, third, thresholds, twosamples
from crosscheck.audit.measures.undefined import all_of, quotient
from crosscheck.audit.page.material import Material
from crosscheck.audit.phase.runs import integrated

ENGINE = "exudyn:tree"
# Exudyn's starts: one costs some four seconds. At the third setting nearly all are severe.
COMPARED = {Cell(PRINTED, 0.005): 16, Cell(REPAIRED_RATE, 0.02): 16, Cell(PRINTED, 0.003): 8}
UNDER_ANGLE = (Cell(PRINTED, 0.005), Cell(REPAIRED_RATE, 0.02))
STARTS_UNDER_ANGLE = 2  # the analytic model's 32 do not differ there
WITHIN = {"onset": 0.05, "frequency": 0.03, "size": 0.10}  # of medians within a branch
NUMBERS = {"onset": "onset_s", "frequency": "frequency_Hz", "size": "size"}  # of a Third
FEWEST = 3  # starts of a branch whose median means something


class Apart(NamedTuple):
    """The medians of both models in one branch, and how far apart they are (relative).

    scatter: from the quantile 0.1 to 0.9 of the analytic starts alone, over their median; within:
    the limit; met: None where a branch has too few starts in one of the models.
    """

    severe: bool
    number: str
    analytic: float | None
    engine: float | None
    difference: float
    scatter: float
    within: float
    met: bool | None

    @property
    def branch(self) -> str:
        """The branch in words."""
        return "severe" if self.severe else "small"


@dataclass(frozen=True)
class TwoModels:
    """The analytic model and the engine in one setting, planets free."""

    cell: Cell
    analytic: third.Third
    engine: third.Third

    @cached_property
    def tests(self) -> twosamples.TwoTests:
        """The tests of whether the models differ."""
        return twosamples.two_tests(self.analytic, self.engine)

    @property
    def could_differ(self) -> bool:
        """Whether a test could tell samples of these sizes apart at all."""
        return (
            twosamples.least_p(self.analytic.size.size, self.engine.size.size)
            < twosamples.SIGNIFICANT
        )

    @property
    def same(self) -> bool | None:
        """Whether no test tells the models apart; None where so few starts never could be."""
        least = self.tests.least
        return None if least is None or not self.could_differ else least >= twosamples.SIGNIFICANT

    @property
    def parted(self) -> tuple[shares.Share, shares.Share]:
        """Shares of starts whose planets part, in both models: the size of rounding decides."""
        analytic, engine = (
            shares.Share(int((model.apart_m > third.APART_M).sum()), model.apart_m.size)
            for model in (self.analytic, self.engine)
        )
        return analytic, engine

    @property
    def parted_size_p(self) -> float | None:
        """The p of Mann and Whitney's test of sizes where planets part; None if few do."""
        one, other = (
            model.size[(model.apart_m > third.APART_M) & np.isfinite(model.size)]
            for model in (self.analytic, self.engine)
        )
        return twosamples.sizes_p(one, other) if min(one.size, other.size) >= FEWEST else None

    @property
    def would_pass(self) -> tuple[int, int] | None:
        """The fewest and the most severe starts of the engine that its share's test would pass."""
        if self.analytic.share is None or self.engine.share is None:
            return None
        return twosamples.not_told_apart(self.analytic.share, self.engine.share.of)

    @property
    def apart(self) -> list[Apart]:
        """The comparison of both models branch by branch, number by number."""
        found = []
        for severe, (name, within) in product((False, True), WITHIN.items()):
            one, other = self.analytic.branch(severe), self.engine.branch(severe)
            here, there = getattr(one, NUMBERS[name]), getattr(other, NUMBERS[name])
            difference = quotient(there, here) - 1
            enough = min(one.starts, other.starts) >= FEWEST
            met = abs(difference) <= within if enough else None
            values = getattr(self.analytic, NUMBERS[name])[self.analytic.of_branch(severe)]
            low, middle, high = third.quantiles(values)
            scatter = quotient(high, middle) - quotient(low, middle)
            found.append(Apart(severe, name, here, there, difference, scatter, within, met))
        return found


@dataclass(frozen=True)
class Engines:
    """The comparisons at every setting; under_angle: those with the phase as an integral."""

    compared: Sequence[TwoModels]
    under_angle: Sequence[TwoModels]

    @property
    def same(self) -> bool | None:
        """Whether no test tells the models apart anywhere."""
        return all_of(one.same for one in self.compared)

    @property
    def supports(self) -> bool | None:
        """Whether the engine, as the analytic model, has severe starts under `omega_t` alone."""
        quiet = [
            None if not one.engine.sizes.size else bool(one.engine.sizes.max() <= thresholds.SEVERE)
            for one in self.under_angle
        ]
        severe = [one.engine.branch(severe=True).starts for one in self.compared]
        known = any(one.engine.sizes.size for one in self.compared)
        shown = any(severe) if known else None
        return all_of([self.same, shown, *quiet])


def engines(material: Material) -> Engines:
    """Samples of many starts of both models, the analytic one's those of the claims.

    Of the engine a question for every start, so that tasks stay short.
    """
    study, scale = material.study, material.scale
    under_angle = dict.fromkeys(map(integrated, UNDER_ANGLE), STARTS_UNDER_ANGLE)
    counts = COMPARED | under_angle
    analytic = material.samples([(cell, PD) for cell in counts], "phase: analytic starts")
    asked = {}
    for cell, count in counts.items():
        run = replace(question(PD, cell, ()).variant, model=ENGINE, duration_s=SHORT_S)
        for seed in scale.seeds[: scale.starts(count)]:
            asked[cell, seed] = TransientPd(scale.cut(run), (seed,))
    engine = {key: Sample.of(one) for key, one in study.answered(asked, "phase: Exudyn").items()}
    both = {}
    for cell in counts:
        other = (one for (own, _), one in engine.items() if own == cell)
        thirds = third.Third.of(analytic[cell, PD]), third.Third.of(*other)
        both[cell] = TwoModels(cell, *thirds)
    return Engines([both[cell] for cell in COMPARED], [both[cell] for cell in under_angle])

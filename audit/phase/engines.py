"""Evidence 3: the same vibration in an independent engine, whose planets all move by themselves."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product
from typing import NamedTuple

import numpy as np

from crosscheck.audit.experiments.ensembles import TransientPdQuestion
from crosscheck.audit.experiments.experiments import PD, SHORT_S, build_question
from crosscheck.audit.experiments.paper_conditions import PRINTED, REPAIRED_RATE, Condition
from crosscheck.audit.experiments.samples import Sample
from crosscheck.audit.measures import shares, third_fluctuation, thresholds, twosamples
from crosscheck.audit.measures.undefined import combine_answers, quotient
from crosscheck.audit.page.context import AuditContext
from crosscheck.audit.phase.runs import use_integral_phase

ENGINE = "exudyn:tree"
# Exudyn's starts: one costs some four seconds. At the third setting nearly all are severe.
COMPARED = {
    Condition(PRINTED, 0.005): 16,
    Condition(REPAIRED_RATE, 0.02): 16,
    Condition(PRINTED, 0.003): 8,
}
UNDER_ANGLE = (Condition(PRINTED, 0.005), Condition(REPAIRED_RATE, 0.02))
STARTS_UNDER_ANGLE = 2  # the analytic model's 32 do not differ there
WITHIN = {"onset": 0.05, "frequency": 0.03, "size": 0.10}  # of medians within a branch
NUMBERS = {"onset": "onset_s", "frequency": "frequency_Hz", "size": "size"}  # of a Third
FEWEST = 3  # starts of a branch whose median means something


class BranchComparison(NamedTuple):
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
class ModelComparison:
    """The analytic model and the engine in one setting, planets free."""

    cell: Condition
    analytic: third_fluctuation.ThirdFluctuation
    engine: third_fluctuation.ThirdFluctuation

    @cached_property
    def tests(self) -> twosamples.PValues:
        """The tests of whether the models differ."""
        return twosamples.compare_samples(self.analytic, self.engine)

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
            shares.Share(
                int((model.planet_spread_m > third_fluctuation.PARTING_SPREAD_M).sum()),
                model.planet_spread_m.size,
            )
            for model in (self.analytic, self.engine)
        )
        return analytic, engine

    @property
    def parted_size_p(self) -> float | None:
        """The p of Mann and Whitney's test of sizes where planets part; None if few do."""
        analytic_sizes, engine_sizes = (
            model.size[
                (model.planet_spread_m > third_fluctuation.PARTING_SPREAD_M)
                & np.isfinite(model.size)
            ]
            for model in (self.analytic, self.engine)
        )
        return (
            twosamples.sizes_p(analytic_sizes, engine_sizes)
            if min(analytic_sizes.size, engine_sizes.size) >= FEWEST
            else None
        )

    @property
    def would_pass(self) -> tuple[int, int] | None:
        """The fewest and the most severe starts of the engine that its share's test would pass."""
        if self.analytic.share is None or self.engine.share is None:
            return None
        return twosamples.find_passing_range(self.analytic.share, self.engine.share.of)

    @property
    def branches(self) -> list[BranchComparison]:
        """The comparison of both models branch by branch, number by number."""
        comparisons = []
        for severe, (name, within) in product((False, True), WITHIN.items()):
            analytic_branch, engine_branch = (
                self.analytic.branch(severe),
                self.engine.branch(severe),
            )
            here, there = (
                getattr(analytic_branch, NUMBERS[name]),
                getattr(engine_branch, NUMBERS[name]),
            )
            difference = quotient(there, here) - 1
            enough = min(analytic_branch.starts, engine_branch.starts) >= FEWEST
            met = abs(difference) <= within if enough else None
            values = getattr(self.analytic, NUMBERS[name])[self.analytic.select_branch(severe)]
            low, middle, high = third_fluctuation.quantiles(values)
            scatter = quotient(high, middle) - quotient(low, middle)
            comparisons.append(
                BranchComparison(severe, name, here, there, difference, scatter, within, met)
            )
        return comparisons


@dataclass(frozen=True)
class EngineEvidence:
    """The comparisons at every setting; under_angle: those with the phase as an integral."""

    compared: Sequence[ModelComparison]
    under_angle: Sequence[ModelComparison]

    @property
    def same(self) -> bool | None:
        """Whether no test tells the models apart anywhere."""
        return combine_answers(comparison.same for comparison in self.compared)

    @property
    def supports(self) -> bool | None:
        """Whether the engine, as the analytic model, has severe starts under `omega_t` alone."""
        quiet = [
            None
            if not comparison.engine.sizes.size
            else bool(comparison.engine.sizes.max() <= thresholds.SEVERE)
            for comparison in self.under_angle
        ]
        severe = [comparison.engine.branch(severe=True).starts for comparison in self.compared]
        has_results = any(comparison.engine.sizes.size for comparison in self.compared)
        shown = any(severe) if has_results else None
        return combine_answers([self.same, shown, *quiet])


def compare_engines(context: AuditContext) -> EngineEvidence:
    """Samples of many starts of both models, the analytic one's those of the claims.

    Of the engine a question for every start, so that tasks stay short.
    """
    study, scale = context.study, context.scale
    under_angle = dict.fromkeys(map(use_integral_phase, UNDER_ANGLE), STARTS_UNDER_ANGLE)
    counts = COMPARED | under_angle
    analytic = context.samples([(cell, PD) for cell in counts], "phase: analytic starts")
    questions = {}
    for cell, count in counts.items():
        run = replace(build_question(PD, cell, ()).variant, model=ENGINE, duration_s=SHORT_S)
        for seed in scale.seeds[: scale.limit_starts(count)]:
            questions[cell, seed] = TransientPdQuestion(scale.cut(run), (seed,))
    engine = {
        key: Sample.from_numbers(sample)
        for key, sample in study.answer_by_key(questions, "phase: Exudyn").items()
    }
    both = {}
    for cell in counts:
        other = (
            sample for (engine_condition, _), sample in engine.items() if engine_condition == cell
        )
        thirds = (
            third_fluctuation.ThirdFluctuation.from_samples(analytic[cell, PD]),
            third_fluctuation.ThirdFluctuation.from_samples(*other),
        )
        both[cell] = ModelComparison(cell, *thirds)
    return EngineEvidence([both[cell] for cell in COMPARED], [both[cell] for cell in under_angle])

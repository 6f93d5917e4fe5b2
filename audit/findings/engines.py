"""The third fluctuation in an independent engine, whose planets all move by themselves."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import NamedTuple

from crosscheck.audit.claims.rule import State
from crosscheck.audit.experiments.ensembles import TransientPdQuestion
from crosscheck.audit.experiments.experiments import PD, SHORT_S, build_question
from crosscheck.audit.experiments.motion import DECISIVE, use_integral_phase
from crosscheck.audit.experiments.paper_conditions import Condition
from crosscheck.audit.experiments.samples import Sample
from crosscheck.audit.measures import third_fluctuation, thresholds, twosamples
from crosscheck.audit.measures.undefined import JsonObject, combine_answers, quotient
from crosscheck.audit.page.context import AuditContext
from crosscheck.models.interface import Model
from crosscheck.registry import build
from crosscheck.studies.members.starts import perturb_start

ENGINE = "exudyn:tree"
STARTS = 16  # of Exudyn's: one costs some four seconds
STARTS_UNDER_ANGLE = 2  # the analytic model's 32 do not differ there
# Margins of sameness: of medians within a branch, relative, stated before the runs; of shares,
# chosen when counts of Exudyn's runs were known.
WITHIN = {"onset": 0.05, "frequency": 0.03, "size": 0.10}
WITHIN_SHARES = 0.25
APART_M = 1e-9  # both models' meshes start by up to so much elsewhere, far above either's rounding
NUMBERS = {"onset": "onset_s", "frequency": "frequency_Hz", "size": "size"}  # of a Third
FEWEST = 3  # starts of a branch whose median means something


class BranchComparison(NamedTuple):
    """The medians of both models in one branch, and how far apart they are (relative).

    interval: of the ratio of the medians; within: the margin; met: whether the interval is inside,
    None where it shows neither or a branch has too few starts in one of the models.
    """

    severe: bool
    number: str
    analytic: float | None
    engine: float | None
    difference: float
    interval: twosamples.ConfidenceInterval | None
    within: float
    met: bool | None


@dataclass(frozen=True)
class ModelComparison:
    """The analytic model and the engine in one setting, planets free."""

    cell: Condition
    analytic: third_fluctuation.ThirdFluctuation
    engine: third_fluctuation.ThirdFluctuation

    @property
    def share_interval(self) -> twosamples.ConfidenceInterval | None:
        """The interval of the engine's share of severe starts less the analytic one's."""
        if self.analytic.share is None or self.engine.share is None:
            return None
        return twosamples.find_difference_interval(self.analytic.share, self.engine.share)

    @property
    def same(self) -> bool | None:
        """Whether shares and medians are the same within their margins; None if not shown."""
        shares_alike = self.share_interval and self.share_interval.is_within(
            -WITHIN_SHARES, WITHIN_SHARES
        )
        met = [branch.met for branch in self.branches if branch.interval is not None]
        return combine_answers([shares_alike, *met])

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
            values, engine_values = (
                getattr(model, NUMBERS[name])[model.select_branch(severe)]
                for model in (self.analytic, self.engine)
            )
            interval = None
            if min(values.size, engine_values.size) >= FEWEST:
                interval = twosamples.find_ratio_interval(values, engine_values)
            met = None if interval is None else interval.is_within(1 - within, 1 + within)
            comparisons.append(
                BranchComparison(severe, name, here, there, difference, interval, within, met)
            )
        return comparisons

    def to_dict(self) -> JsonObject:
        """The comparison as a JSON object."""
        return {
            "id": f"finding/engine/{self.cell.id}",
            "severe": [str(self.analytic.share), str(self.engine.share)],
            "median_rad_per_s2": [self.analytic.quantiles[1], self.engine.quantiles[1]],
            "same": self.same,
        }


@dataclass(frozen=True)
class EngineEvidence:
    """The comparisons at every setting; under_angle: those with the phase as an integral."""

    compared: Sequence[ModelComparison]
    under_angle: Sequence[ModelComparison]

    @property
    def same(self) -> bool | None:
        """Whether the models are the same within the margins everywhere; None if not shown."""
        return combine_answers(comparison.same for comparison in self.compared)

    @property
    def supports(self) -> bool | None:
        """Whether the engine by itself has severe starts under `omega_t`, and none under `angle`.

        H1 is about presence; whether both models are the same is told beside it.
        """
        quiet = [
            None
            if not comparison.engine.sizes.size
            else bool(comparison.engine.sizes.max() <= thresholds.SEVERE)
            for comparison in self.under_angle
        ]
        states = [comparison.engine.state for comparison in self.compared]
        known = [state for state in states if state != State.UNDEFINED]
        shown = any(state in (State.YES, State.BISTABLE) for state in known) if known else None
        return combine_answers([shown, *quiet])

    def to_dicts(self) -> list[JsonObject]:
        """The comparisons as JSON objects, with the tests' p, of one family, adjusted by Holm."""
        tests = [twosamples.compare_samples(x.analytic, x.engine) for x in self.compared]
        adjusted = [p._asdict() for p in twosamples.adjust_pairs(tests)]
        compared = [
            x.to_dict() | {"p": dict(p)} for x, p in zip(self.compared, adjusted, strict=True)
        ]
        return [*compared, *(x.to_dict() for x in self.under_angle)]


@dataclass(frozen=True)
class PartedStartsQuestion(TransientPdQuestion):
    """A question: numbers of ``transient`` from starts that differ by up to APART_M.

    Planets part only as fast as rounding lets them, and engines round unlike: gear angles have
    coarser last digits than displacements. From here on both have the same to begin with.
    """

    def models(self, seeds: Sequence[int]) -> Sequence[Model]:
        case = self.case()
        return [build(self.variant.model, *perturb_start(case, seed, APART_M)) for seed in seeds]


def compare_engines(context: AuditContext) -> EngineEvidence:
    """Samples of many starts of both models, the same ones.

    Of the engine a question for every start, so that tasks stay short.
    """
    study, scale = context.study, context.scale
    under_angle = dict.fromkeys(map(use_integral_phase, DECISIVE), STARTS_UNDER_ANGLE)
    counts = dict.fromkeys(DECISIVE, STARTS) | under_angle
    variants = {
        cell: scale.cut(replace(build_question(PD, cell, ()).variant, duration_s=SHORT_S))
        for cell in counts
    }
    analytic = study.answer_by_key(
        {cell: PartedStartsQuestion(variant, scale.seeds) for cell, variant in variants.items()},
        "second engine: analytic starts",
    )
    engine = study.answer_by_key(
        {
            (cell, seed): PartedStartsQuestion(replace(variants[cell], model=ENGINE), (seed,))
            for cell, count in counts.items()
            for seed in scale.seeds[: scale.limit_starts(count)]
        },
        "second engine: Exudyn",
    )
    both = {}
    for cell in counts:
        samples = [numbers for (engine_condition, _), numbers in engine.items()
                   if engine_condition == cell]  # fmt: skip
        thirds = (
            third_fluctuation.ThirdFluctuation.from_samples(*map(Sample.from_numbers, each))
            for each in ([analytic[cell]], samples)
        )
        both[cell] = ModelComparison(cell, *thirds)
    return EngineEvidence([both[cell] for cell in DECISIVE], [both[cell] for cell in under_angle])

"""What decides H7: counting three planets as one changes the paper's third fluctuation.

And which statements about Figs. 11 to 14 and 16 to 20 rest on planets that are lumped.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import cached_property

import numpy as np

from crosscheck.audit.claims.catalogue import CLAIMS
from crosscheck.audit.claims.quantities import ConditionResults
from crosscheck.audit.claims.rule import Answer, Claim, Place, State, evaluate_claim
from crosscheck.audit.claims.study_plan import ResultsByCondition, plan_of
from crosscheck.audit.experiments.experiments import (
    BACKLASH,
    CONSTANT_STIFFNESS,
    DEFAULT_B_UM,
    DEFAULT_E_UM,
    ERROR,
    NO_BACKLASH,
    NO_ERROR,
    PD,
)
from crosscheck.audit.experiments.paper_conditions import LAWS, Condition, Law
from crosscheck.audit.experiments.variant import Planets
from crosscheck.audit.measures.third_fluctuation import ThirdFluctuation
from crosscheck.audit.measures.thresholds import EVIDENT
from crosscheck.audit.measures.twosamples import (
    PValues,
    adjust_by_holm,
    adjust_pairs,
    compare_samples,
    is_significant,
    shares_p,
)
from crosscheck.audit.page.context import AuditContext

FIGURES = (*range(11, 15), *range(16, 21))  # of the PD run
ZETAS = (0.005, 0.02)


class PlanetsEffect(StrEnum):
    """The effect of freeing the planets on a third fluctuation."""

    WEAKER = "weaker"
    STRONGER = "stronger"
    NONE = "none seen"
    UNKNOWN = "undefined"


def judge_effect(lumped: ThirdFluctuation, free: ThirdFluctuation, p: PValues) -> PlanetsEffect:
    """The effect of freeing the planets, from both samples and the adjusted p of both tests.

    The samples are distinguished by the shares of severe starts;
    or by sizes, where a tenth of the larger ones count as a fluctuation at all: the sample whose
    starts are mostly the smaller is the weaker one.
    """
    if p.by_share is None or p.by_size is None or lumped.share is None or free.share is None:
        return PlanetsEffect.UNKNOWN
    high = max(quantiles[-1] or 0.0 for quantiles in (lumped.quantiles, free.quantiles))
    if is_significant(p.by_share):
        weaker = free.share.value < lumped.share.value
    elif high > EVIDENT and is_significant(p.by_size):
        weaker = bool(np.sign(free.sizes[:, None] - lumped.sizes).sum() < 0)
    else:
        return PlanetsEffect.NONE
    return PlanetsEffect.WEAKER if weaker else PlanetsEffect.STRONGER


class Survival(StrEnum):
    """What becomes of a statement about a figure once planets are free."""

    YES = "true either way"
    NO = "false either way"
    LOST = "true only with lumped planets"
    APPEARS = "true only with free planets"
    BISTABLE = "the start decides"
    UNKNOWN = "undefined"


def judge_survival(lumped: State, free: State) -> Survival:
    """What becomes of a statement, from what a setting says of it with either kind of planets."""
    if State.UNDEFINED in (lumped, free):
        return Survival.UNKNOWN
    if State.BISTABLE in (lumped, free):
        return Survival.BISTABLE
    if lumped == free:
        return Survival.YES if free == State.YES else Survival.NO
    return Survival.APPEARS if free == State.YES else Survival.LOST


def judge_h7(effects: Sequence[PlanetsEffect]) -> str:
    """`holds` if freeing the planets changes the third fluctuation in any setting."""
    if any(effect in (PlanetsEffect.WEAKER, PlanetsEffect.STRONGER) for effect in effects):
        return "holds"
    return "not seen" if PlanetsEffect.NONE in effects else "undefined"


@dataclass(frozen=True)
class PlanetsComparison:
    """Third fluctuations in a setting, planets lumped and free.

    tests: of whether the samples differ; of both tests in all settings, which are one family.
    """

    cell: Condition
    lumped: ThirdFluctuation
    free: ThirdFluctuation
    tests: PValues

    @cached_property
    def effect(self) -> PlanetsEffect:
        """The effect of freeing the planets."""
        return judge_effect(self.lumped, self.free, self.tests)


def compare_planets(context: AuditContext) -> list[PlanetsComparison]:
    """Every setting of the claims with lumped and free planets, from the same starts."""
    plan = plan_of(context.scale)
    cells = plan.claim_conditions()
    alike = {cell: replace(cell, planets="lumped") for cell in cells}
    requests = [
        (compared_condition, PD) for cell in cells for compared_condition in (cell, alike[cell])
    ]
    samples = context.samples(requests, "planets: free and alike")
    thirds = [
        (
            ThirdFluctuation.from_samples(samples[alike[cell], PD]),
            ThirdFluctuation.from_samples(samples[cell, PD]),
        )
        for cell in cells
    ]
    tests = adjust_pairs([compare_samples(*pair) for pair in thirds])
    return [
        PlanetsComparison(cell, *pair, p)
        for cell, pair, p in zip(cells, thirds, tests, strict=True)
    ]


def count_effects(records: Sequence[PlanetsComparison]) -> dict[Law, Counter[PlanetsEffect]]:
    """How often each effect is seen, by law."""
    return {law: Counter(r.effect for r in records if r.cell.law == law) for law in LAWS}


@dataclass(frozen=True)
class ClaimComparison:
    """A claim in a setting with lumped and with free planets.

    p: of Fisher's exact test of the shares, one family over all answers; None where one has none.
    """

    claim: Claim
    place: Place
    lumped: Answer
    free: Answer
    p: float | None

    @property
    def survives(self) -> Survival:
        """What becomes of the claim once planets are free."""
        return judge_survival(self.lumped.state, self.free.state)

    @property
    def changed(self) -> bool | None:
        """Whether the shares differ significantly; None where one is undefined."""
        return None if self.p is None else is_significant(self.p)


def compare_claims(context: AuditContext) -> list[ClaimComparison]:
    """Every claim about these figures, at a small and at a larger damping under all laws."""
    plan = plan_of(context.scale)
    sources = [PD, NO_BACKLASH, NO_ERROR, CONSTANT_STIFFNESS]  # of the claims' under PD control
    sources += [BACKLASH(size) for size in plan.backlashes]
    sources += [ERROR(size) for size in plan.errors]
    cells = [Condition(law, zeta) for law in LAWS for zeta in ZETAS]
    results: dict[Planets, ResultsByCondition] = {}
    for planets in ("lumped", "free"):
        conditions = {cell: replace(cell, planets=planets) for cell in cells}
        requests = [(item, source) for item in conditions.values() for source in sources]
        sampled = context.samples(requests, "planets: the figures' statements")
        results[planets] = []
        for cell, item in conditions.items():
            each = ConditionResults({source: sampled[item, source] for source in sources})
            each[BACKLASH(DEFAULT_B_UM)] = each[ERROR(DEFAULT_E_UM)] = each[PD]
            results[planets].append((cell, each))
    comparisons = []
    for claim in CLAIMS:
        if claim.figure in FIGURES:  # none of its answers where it is about other experiments
            alike = {item.place: item for item in evaluate_claim(claim, results["lumped"])}
            free = evaluate_claim(claim, results["free"])
            comparisons += [(claim, item.place, alike[item.place], item) for item in free]
    plain = [
        shares_p(one.share, other.share) if one.share and other.share else None
        for *_, one, other in comparisons
    ]
    adjusted = iter(adjust_by_holm([p for p in plain if p is not None]))
    return [
        ClaimComparison(*each, None if p is None else next(adjusted))
        for each, p in zip(comparisons, plain, strict=True)
    ]

"""What decides H7: counting three planets as one changes the paper's third fluctuation."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import cached_property

import numpy as np

from crosscheck.audit.claims.rule import State
from crosscheck.audit.claims.settings import plan_of
from crosscheck.audit.experiments.cells import LAWS, Cell, Law
from crosscheck.audit.experiments.experiments import PD
from crosscheck.audit.measures.shares import Share
from crosscheck.audit.measures.third import Third
from crosscheck.audit.measures.thresholds import EVIDENT
from crosscheck.audit.measures.twosamples import TwoTests, shares_p, told_apart, two_tests
from crosscheck.audit.page.material import Material

PREDICTED = 0.10  # relative error of the time at which planets part
TESTS = 2  # of every setting: of the shares and of the sizes


class PlanetsEffect(StrEnum):
    """What freeing the planets does to a third fluctuation."""

    WEAKER = "weaker"
    STRONGER = "stronger"
    NONE = "none seen"
    UNKNOWN = "undefined"


def effect(lumped: Third, free: Third, p: TwoTests, family: int) -> PlanetsEffect:
    """From both samples and the p of both tests on them, two of so many.

    Told apart by the shares of severe starts; or by sizes, where a tenth of the larger ones count
    as a fluctuation at all: the sample whose starts are mostly the smaller is the weaker one.
    """
    if p.by_share is None or p.by_size is None or lumped.share is None or free.share is None:
        return PlanetsEffect.UNKNOWN
    high = max(quantiles[-1] or 0.0 for quantiles in (lumped.quantiles, free.quantiles))
    if told_apart(p.by_share, family):
        weaker = free.share.value < lumped.share.value
    elif high > EVIDENT and told_apart(p.by_size, family):
        weaker = bool(np.sign(free.sizes[:, None] - lumped.sizes).sum() < 0)
    else:
        return PlanetsEffect.NONE
    return PlanetsEffect.WEAKER if weaker else PlanetsEffect.STRONGER


def parting_is_predicted(predicted_s: float | None, measured_s: float | None) -> bool:
    """Both never part, or both part at nearly the same time."""
    if predicted_s is None or measured_s is None:
        return predicted_s is measured_s
    return abs(predicted_s / measured_s - 1) <= PREDICTED


class Survival(StrEnum):
    """What becomes of a statement about a figure once planets are free."""

    YES = "true either way"
    NO = "false either way"
    LOST = "true only with lumped planets"
    APPEARS = "true only with free planets"
    BISTABLE = "the start decides"
    UNKNOWN = "undefined"


def survival(lumped: State, free: State) -> Survival:
    """From what a setting says of the statement."""
    if State.UNDEFINED in (lumped, free):
        return Survival.UNKNOWN
    if State.BISTABLE in (lumped, free):
        return Survival.BISTABLE
    if lumped == free:
        return Survival.YES if free == State.YES else Survival.NO
    return Survival.APPEARS if free == State.YES else Survival.LOST


def is_changed(lumped: Share | None, free: Share | None, family: int) -> bool | None:
    """Whether Fisher's exact test, one of so many, tells the shares apart.

    None where one is undefined or where so few starts could not be told apart at all.
    """
    if lumped is None or free is None:
        return None
    least = shares_p(Share(lumped.of, lumped.of), Share(0, free.of))
    return told_apart(shares_p(lumped, free), family) if told_apart(least, family) else None


def h7_verdict(effects: Sequence[PlanetsEffect]) -> str:
    """`holds` if freeing the planets changes the third fluctuation in any setting."""
    if any(one in (PlanetsEffect.WEAKER, PlanetsEffect.STRONGER) for one in effects):
        return "holds"
    return "not seen" if PlanetsEffect.NONE in effects else "undefined"


@dataclass(frozen=True)
class Freed:
    """A cell with lumped and with free ones; family: tests that share the 5 %."""

    cell: Cell
    lumped: Third
    free: Third
    family: int

    @cached_property
    def tests(self) -> TwoTests:
        """Whether the samples differ."""
        return two_tests(self.lumped, self.free)

    @cached_property
    def effect(self) -> PlanetsEffect:
        """What freeing the planets does."""
        return effect(self.lumped, self.free, self.tests, self.family)


def freed(material: Material) -> list[Freed]:
    """Every setting of the claims, all starts; the same starts either way."""
    plan = plan_of(material.scale)
    cells = plan.settings()
    alike = {cell: replace(cell, planets="lumped") for cell in cells}
    wanted = [(one, PD) for cell in cells for one in (cell, alike[cell])]
    found = material.samples(wanted, "planets: free and alike")
    return [
        Freed(cell, Third.of(found[alike[cell], PD]), Third.of(found[cell, PD]), TESTS * len(cells))
        for cell in cells
    ]


def effects_by_law(records: Sequence[Freed]) -> dict[Law, Counter[PlanetsEffect]]:
    """How often each effect is seen."""
    return {law: Counter(r.effect for r in records if r.cell.law == law) for law in LAWS}

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
from crosscheck.audit.claims.quantities import Known
from crosscheck.audit.claims.rule import Answer, Claim, Place, State, answers
from crosscheck.audit.claims.settings import Settings, plan_of
from crosscheck.audit.experiments.cells import LAWS, Cell, Law
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
from crosscheck.audit.experiments.variant import Planets
from crosscheck.audit.measures.shares import Share
from crosscheck.audit.measures.third import Third
from crosscheck.audit.measures.thresholds import EVIDENT
from crosscheck.audit.measures.twosamples import TwoTests, shares_p, told_apart, two_tests
from crosscheck.audit.page.material import Material

TESTS = 2  # of every setting: of the shares and of the sizes
FIGURES = (*range(11, 15), *range(16, 21))  # of the PD run
ZETAS = (0.005, 0.02)


class PlanetsEffect(StrEnum):
    """The effect of freeing the planets on a third fluctuation."""

    WEAKER = "weaker"
    STRONGER = "stronger"
    NONE = "none seen"
    UNKNOWN = "undefined"


def effect(lumped: Third, free: Third, p: TwoTests, family: int) -> PlanetsEffect:
    """The effect of freeing the planets, from both samples and the p of both tests on them.

    family: tests that share the 5 %. The samples are told apart by the shares of severe starts; or
    by sizes, where a tenth of the larger ones count as a fluctuation at all: the sample whose
    starts are mostly the smaller is the weaker one.
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


class Survival(StrEnum):
    """What becomes of a statement about a figure once planets are free."""

    YES = "true either way"
    NO = "false either way"
    LOST = "true only with lumped planets"
    APPEARS = "true only with free planets"
    BISTABLE = "the start decides"
    UNKNOWN = "undefined"


def survival(lumped: State, free: State) -> Survival:
    """What becomes of a statement, from what a setting says of it with either kind of planets."""
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
    """Third fluctuations in a setting, planets lumped and free; family: tests sharing the 5 %."""

    cell: Cell
    lumped: Third
    free: Third
    family: int

    @cached_property
    def tests(self) -> TwoTests:
        """The tests of whether the samples differ."""
        return two_tests(self.lumped, self.free)

    @cached_property
    def effect(self) -> PlanetsEffect:
        """The effect of freeing the planets."""
        return effect(self.lumped, self.free, self.tests, self.family)


def freed(material: Material) -> list[Freed]:
    """Every setting of the claims with lumped and free planets, from the same starts."""
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
    """How often each effect is seen, by law."""
    return {law: Counter(r.effect for r in records if r.cell.law == law) for law in LAWS}


@dataclass(frozen=True)
class Feature:
    """A claim in a setting with lumped and with free planets; family: tests that share the 5 %."""

    claim: Claim
    place: Place
    lumped: Answer
    free: Answer
    family: int

    @property
    def survives(self) -> Survival:
        """What becomes of the claim once planets are free."""
        return survival(self.lumped.state, self.free.state)

    @property
    def changed(self) -> bool | None:
        """Whether the shares differ significantly; None where they could not be."""
        return is_changed(self.lumped.share, self.free.share, self.family)


def features(material: Material) -> list[Feature]:
    """Every claim about these figures, at a small and at a larger damping under all laws."""
    plan = plan_of(material.scale)
    sources = [PD, NO_BACKLASH, NO_ERROR, CONSTANT_STIFFNESS]  # of the claims' under PD control
    sources += [BACKLASH(size) for size in plan.backlashes]
    sources += [ERROR(size) for size in plan.errors]
    cells = [Cell(law, zeta) for law in LAWS for zeta in ZETAS]
    known: dict[Planets, Settings] = {}
    for planets in ("lumped", "free"):
        own = {cell: replace(cell, planets=planets) for cell in cells}
        wanted = [(one, source) for one in own.values() for source in sources]
        sampled = material.samples(wanted, "planets: the figures' statements")
        known[planets] = []
        for cell, one in own.items():
            each = Known({source: sampled[one, source] for source in sources})
            each[BACKLASH(DEFAULT_B_UM)] = each[ERROR(DEFAULT_E_UM)] = each[PD]
            known[planets].append((cell, each))
    found = []
    for claim in CLAIMS:
        if claim.figure in FIGURES:  # none of its answers where it is about other experiments
            alike = {one.place: one for one in answers(claim, known["lumped"])}
            free = answers(claim, known["free"])
            found += [(claim, one.place, alike[one.place], one) for one in free]
    return [Feature(*each, len(found)) for each in found]

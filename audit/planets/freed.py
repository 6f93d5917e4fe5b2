"""The third fluctuation with lumped and with free planets, setting by setting."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

from crosscheck.audit.claims.settings import plan_of
from crosscheck.audit.experiments.cells import LAWS, Cell, Law
from crosscheck.audit.experiments.experiments import PD
from crosscheck.audit.measures.third import Third
from crosscheck.audit.measures.twosamples import TwoTests, two_tests
from crosscheck.audit.page.material import Material
from crosscheck.audit.planets.verdict import PlanetsEffect, effect

TESTS = 2  # of every setting: of the shares and of the sizes


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

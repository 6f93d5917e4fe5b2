"""The three findings that the page begins with, as numbers."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np

from audit.claims.rule import State
from audit.experiments.cells import INTEGRAL, LAWS, Cell, Law
from audit.experiments.experiments import CONSTANT, PD
from audit.experiments.pool import Sample
from audit.experiments.variant import Planets
from audit.figures.runs import LOW_ZETA, ZETA
from audit.measures.numbers import defined, quotient
from audit.measures.shares import Share
from audit.measures.third import Third, said
from audit.page.material import Material
from audit.page.record import JsonObject
from audit.page.said import Said
from crosscheck.registry import RIGID_LEVELS

PLANETS: tuple[Planets, ...] = ("free", "lumped")
STATED_RAD = (0.02, 0.01)  # Section 3.1: deviation of both joints from the rigid arm


@dataclass(frozen=True)
class Strip:
    """The third fluctuation of every start in one setting."""

    cell: Cell
    third: Third

    def to_dict(self) -> JsonObject:
        """For JSON."""
        return {
            "id": f"finding/third/{self.cell.id}",
            "starts": self.third.size.size,
            "undefined": self.third.size.size - self.third.sizes.size,
            "severe": int(self.third.of_branch(severe=True).sum()),
            "quantiles": list(map(defined, self.third.quantiles)),
        }


@dataclass(frozen=True)
class Thirds:
    """Under every law, planets free and held alike, at one damping."""

    zeta: float
    strips: tuple[Strip, ...]

    def share(self, law: Law, planets: Planets) -> Share | None:
        """Of severe starts."""
        strips = {(strip.cell.law, strip.cell.planets): strip for strip in self.strips}
        return strips[law, planets].third.share

    @property
    def needs_clock(self) -> bool:
        """Whether some starts are severe with the clock, and in no setting without it."""
        severe = (State.YES, State.BISTABLE)
        return {s.cell.law.phase for s in self.strips if s.third.state in severe} == {"omega_t"}

    def said(self) -> list[Said]:
        """What the claims ask, too."""
        return [one for strip in self.strips for one in said("findings", strip.cell, strip.third)]


def third_finding(material: Material, zeta: float = LOW_ZETA) -> Thirds:
    """From all starts."""
    cells = [Cell(law, zeta, planets=planets) for law, planets in product(LAWS, PLANETS)]
    found = material.samples([(cell, PD) for cell in cells], "the third fluctuation")
    return Thirds(zeta, tuple(Strip(cell, Third.of(found[cell, PD])) for cell in cells))


@dataclass(frozen=True)
class Step:
    """A rigid arm, and how far the detailed one leaves it: median of the starts, both joints."""

    level: str
    deviation_rad: tuple[float, float]

    def to_dict(self) -> JsonObject:
        """For JSON."""
        return {
            "id": f"finding/ladder/{self.level}",
            "deviation_rad": list(map(defined, self.deviation_rad)),
        }


@dataclass(frozen=True)
class Ladder:
    """The rigid arms in the order of what they have of the gears."""

    zeta: float
    steps: tuple[Step, ...]

    @property
    def papers(self) -> Step:
        """The one whose deviation of theta_2 is nearest to the paper's, by its factor."""
        return min(self.steps, key=lambda step: abs(np.log(step.deviation_rad[1] / STATED_RAD[1])))

    @property
    def left_to_meshes(self) -> tuple[float, float]:
        """Shares of that one's deviations that are left once all inertia is there."""
        last, own = self.steps[-1].deviation_rad, self.papers.deviation_rad
        return quotient(last[0], own[0]), quotient(last[1], own[1])


def ladder_finding(material: Material) -> Ladder:
    """Under constant torque and the law without a clock."""
    cell = Cell(INTEGRAL, ZETA)
    sample = material.samples([(cell, CONSTANT)], "the rigid ladder")[cell, CONSTANT]
    steps = [
        Step(level, (_median(sample, 1, level), _median(sample, 2, level)))
        for level in RIGID_LEVELS
    ]
    return Ladder(ZETA, tuple(steps))


def _median(sample: Sample, joint: int, level: str) -> float:
    values = sample[f"deviation_{joint}_{level}_rad"]
    known = values[np.isfinite(values)]
    return float(np.median(known)) if known.size else np.nan

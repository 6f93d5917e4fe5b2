"""What the first screen shows of H1 and H7: the clock test, and the third fluctuation's starts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from crosscheck.paper.cells import LAWS, Cell
from crosscheck.paper.material import Material
from crosscheck.paper.phase.clock import Clocks, clocks
from crosscheck.paper.sampling.experiments import PD
from crosscheck.paper.third import Third
from crosscheck.studies.variant import Planets

ZETA = 0.005  # of Figs. 11-14 and 16-20: where the start decides
PLANETS: tuple[Planets, Planets] = ("free", "lumped")


@dataclass(frozen=True)
class Strip:
    """The third fluctuation of every start in one cell."""

    cell: Cell
    third: Third


@dataclass(frozen=True)
class Headline:
    """The clock test, and strips: the three laws with planets free, then with planets alike."""

    clocks: Clocks
    strips: Sequence[Strip]


def headline(material: Material, zeta: float = ZETA) -> Headline:
    """What has been run already is read."""
    cells = [Cell(law, zeta, planets=planets) for planets in PLANETS for law in LAWS]
    found = material.samples([(cell, PD) for cell in cells], "phase: headline")
    strips = [Strip(cell, Third.of(found[cell, PD])) for cell in cells]
    return Headline(clocks(material.study, material.scale), strips)

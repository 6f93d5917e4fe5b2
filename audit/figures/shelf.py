"""What the figures are drawn from: runs from one start, bands of all starts, samples.

Every choice that the paper leaves open is made here.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import TypeVar

import xarray as xr

from crosscheck.audit.claims.quantities import Known, NotSimulatedError
from crosscheck.audit.claims.settings import Plan, plan_of, planted_of, statics_of
from crosscheck.audit.experiments.bands import Bands, Between
from crosscheck.audit.experiments.cells import LABELLED, LAWS, Cell, Law
from crosscheck.audit.experiments.experiments import (
    DEFAULTS,
    PD,
    PLANTED,
    STATIC,
    Family,
    Source,
    question,
)
from crosscheck.audit.experiments.pool import Sample
from crosscheck.audit.experiments.variant import Variant
from crosscheck.audit.measures.course import Course, course_of
from crosscheck.audit.measures.reading import first_planets
from crosscheck.audit.measures.rigid import rigid_model
from crosscheck.audit.page.material import Material

# The paper gives no damping. At the smaller value its third fluctuation shows under its own law.
ZETA, LOW_ZETA = 0.02, 0.005
SMOOTH_RECORD = 20  # 0.2 ms: for angles and speeds, which have nothing at mesh frequencies
FULL_RECORD = 2  # 20 µs: eleven records of a period of the fastest mesh mode
BAND_BINS = 900  # over a whole run
WITHOUT_SETTING = {STATIC: statics_of, PLANTED: planted_of}
Name = TypeVar("Name", bound=Hashable)


@dataclass
class Shelf:
    """The page's material as figures need it; each run is read once. whole: with verdicts.

    Verdicts need every setting of the claims: a figure alone is shown without.
    """

    material: Material
    whole: bool = True
    held: dict[Variant, xr.Dataset] = field(default_factory=dict)
    read: dict[Variant, Course] = field(default_factory=dict)
    asked: dict[float, dict[Law, Known]] = field(default_factory=dict)

    @property
    def seed(self) -> int:
        """The seed of the start that is drawn."""
        return self.material.scale.first_seed

    @property
    def plan(self) -> Plan:
        """The plan, which says what sizes are swept."""
        return plan_of(self.material.scale)

    def runs(self, named: Mapping[Name, Variant], number: int) -> dict[Name, xr.Dataset]:
        """The variants' runs, cut to the scale, for a figure. Raises Diverged."""
        wanted = {name: self.material.scale.cut(variant) for name, variant in named.items()}
        missing = [variant for variant in wanted.values() if variant not in self.held]
        self.held |= self.material.study.runs(missing, f"figure {number}", first_planets)
        return {name: self.held[cut] for name, cut in wanted.items()}

    def courses(self, named: Mapping[Name, Variant], number: int) -> dict[Name, Course]:
        """The variants' runs as measures read them, for a figure. Raises Diverged."""
        for name, run in self.runs(named, number).items():
            if named[name] not in self.read:
                self.read[named[name]] = course_of(run)
        return {name: self.read[variant] for name, variant in named.items()}

    def laws(self, number: int, source: Source, zeta: float) -> dict[Law, Course]:
        """The courses of an experiment from the drawn start, by law."""
        variants = {law: drawn(source, Cell(law, zeta), self.seed) for law in LAWS}
        return self.courses(variants, number)

    def sweep(self, number: int, family: Family, zeta: float) -> dict[Law, dict[float, Course]]:
        """The courses of a family's members from the drawn start under every law, by size [um]."""
        found = self.courses(self.members(family, zeta), number)
        return {
            law: {size: one for (own, size), one in found.items() if own == law} for law in LAWS
        }

    def members(self, family: Family, zeta: float) -> dict[tuple[Law, float], Variant]:
        """A family's variants from the drawn start, by law and size [um]."""
        members = self.known(zeta)[LAWS[0]].members(family)
        return {
            (law, one.size_um or 0.0): drawn(one, Cell(law, zeta), self.seed)
            for law in LAWS
            for one in members
        }

    def known(self, zeta: float) -> dict[Law, Known]:
        """The samples of every experiment at a damping ratio, labelled reading, by law."""
        if zeta not in self.asked:
            if self.whole:
                own = [(c, known) for c, known in self.material.settings if c.arm == LABELLED]
                self.asked[zeta] = {cell.law: known for cell, known in own if cell.zeta == zeta}
            else:
                self.asked[zeta] = on_demand(self.material, zeta)
        return self.asked[zeta]

    def bands(self, zeta: float, number: int) -> dict[Law, Between]:
        """The bands in which the whole PD run's starts lie, by law."""
        scale = self.material.scale
        variants = [scale.cut(drawn(PD, Cell(law, zeta), None)) for law in LAWS]
        questions = [Bands(variant, scale.seeds, BAND_BINS) for variant in variants]
        found = self.material.study.answers(questions, f"figure {number}, all starts")
        return dict(zip(LAWS, found, strict=True))


def drawn(source: Source, cell: Cell, seed: int | None, record_every: int = FULL_RECORD) -> Variant:
    """The variant of an experiment as the claims' samples have it, from one of their starts."""
    variant = question(PD if source in DEFAULTS else source, cell, ()).variant
    return replace(variant, seed=seed, record_every=record_every)


def rigid_run(scenario: str, level: str) -> Variant:
    """The variant of a rigid arm at a level, recorded on the grid of the smooth runs."""
    return Variant(scenario, model=rigid_model(level), record_every=SMOOTH_RECORD)


class OnDemand(Known):
    """Samples of a setting that are run when asked for. Raises NotSimulatedError if unplanned."""

    def __init__(self, planned: tuple[Source, ...], fetch: Callable[[Source], None]) -> None:
        super().__init__()
        self.planned = planned
        self.fetch = fetch

    def __iter__(self) -> Iterator[Source]:
        return iter(self.planned)

    def __missing__(self, source: Source) -> Sample:
        if source not in self.planned:
            raise NotSimulatedError(source)
        self.fetch(source)
        return self[source]


def on_demand(material: Material, zeta: float) -> dict[Law, Known]:
    """Samples of the labelled reading, by law; what one law is asked is run for all."""
    plan = plan_of(material.scale)
    known: dict[Law, Known] = {}

    def fetch(source: Source) -> None:
        if source in WITHOUT_SETTING:
            (sample,) = WITHOUT_SETTING[source](material.study, [LABELLED])
            for one in known.values():
                one[source] = sample
            return
        same = PD if source in DEFAULTS else source
        found = material.samples([(Cell(law, zeta), same) for law in LAWS], str(source))
        for law, one in known.items():
            one[source] = found[Cell(law, zeta), same]

    for law in LAWS:
        static = (STATIC, PLANTED) if plan.variants else (STATIC,)
        known[law] = OnDemand((*static, *DEFAULTS, *plan.sources(Cell(law, zeta))), fetch)
    return known

"""What the figures are drawn from: runs from one start, bands of all starts, samples."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np
import xarray as xr

from crosscheck.audit.claims.quantities import Known, NotSimulatedError
from crosscheck.audit.claims.settings import Plan, plan_of, planted_of, statics_of
from crosscheck.audit.experiments.bands import Bands, Between
from crosscheck.audit.experiments.cells import LABELLED, LAWS, Cell, Law
from crosscheck.audit.experiments.experiments import (
    BACKLASH,
    DEFAULT_B_UM,
    DEFAULT_E_UM,
    ERROR,
    PD,
    PLANTED,
    STATIC,
    Family,
    Source,
)
from crosscheck.audit.experiments.pool import Sample
from crosscheck.audit.experiments.variant import Variant
from crosscheck.audit.figures.runs import FULL_RECORD, drawn
from crosscheck.audit.measures.course import Course, course_of
from crosscheck.audit.measures.reading import first_planets
from crosscheck.audit.page.material import Material

BAND_BINS = 900  # over a whole run
DEFAULTS = (BACKLASH(DEFAULT_B_UM), ERROR(DEFAULT_E_UM))  # other names of the default run
WITHOUT_SETTING = {STATIC: statics_of, PLANTED: planted_of}
Fetch = Callable[[Source], None]


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
        """Of the start that is drawn."""
        return self.material.scale.first_seed

    @property
    def plan(self) -> Plan:
        """Which sizes are swept."""
        return plan_of(self.material.scale)

    def runs(self, variants: Iterable[Variant], number: int) -> dict[Variant, xr.Dataset]:
        """The variants' runs, cut to the scale, for a figure. Raises Diverged."""
        wanted = {variant: self.material.scale.cut(variant) for variant in variants}
        missing = [variant for variant in wanted.values() if variant not in self.held]
        self.held |= self.material.study.runs(missing, f"figure {number}", first_planets)
        return {variant: self.held[cut] for variant, cut in wanted.items()}

    def courses(self, variants: Iterable[Variant], number: int) -> dict[Variant, Course]:
        """The same as measures read them."""
        found = self.runs(variants, number)
        self.read |= {v: course_of(run) for v, run in found.items() if v not in self.read}
        return {variant: self.read[variant] for variant in found}

    def laws(
        self, number: int, source: Source, zeta: float, record_every: int = FULL_RECORD
    ) -> dict[Law, Course]:
        """An experiment from the drawn start under every law."""
        variants = {law: drawn(source, Cell(law, zeta), self.seed, record_every) for law in LAWS}
        found = self.courses(variants.values(), number)
        return {law: found[variant] for law, variant in variants.items()}

    def sweep(self, number: int, family: Family, zeta: float) -> dict[Law, dict[float, Course]]:
        """The members of a family from the drawn start under every law, by size [um]."""
        variants = self.members(family, zeta)
        found = self.courses(variants.values(), number)
        return {
            law: {size: found[one] for (own, size), one in variants.items() if own == law}
            for law in LAWS
        }

    def members(self, family: Family, zeta: float) -> dict[tuple[Law, float], Variant]:
        """A family's variants from the drawn start, by law and size [um]."""
        sizes = [member.size_um or 0.0 for member in self.known(zeta)[LAWS[0]].members(family)]
        return {
            (law, size): drawn(family(size), Cell(law, zeta), self.seed)
            for law in LAWS
            for size in sizes
        }

    def known(self, zeta: float) -> dict[Law, Known]:
        """Every experiment at a damping from all starts, labelled reading, by law."""
        if zeta not in self.asked:
            if self.whole:
                own = [(c, known) for c, known in self.material.settings if c.arm == LABELLED]
                self.asked[zeta] = {cell.law: known for cell, known in own if cell.zeta == zeta}
            else:
                self.asked[zeta] = on_demand(self.material, zeta)
        return self.asked[zeta]

    def bands(self, zeta: float, number: int) -> dict[Law, Between]:
        """Between which values the whole PD run's starts lie, under every law."""
        scale = self.material.scale
        variants = [scale.cut(drawn(PD, Cell(law, zeta), None)) for law in LAWS]
        questions = [Bands(variant, scale.seeds, BAND_BINS) for variant in variants]
        found = self.material.study.answers(questions, f"figure {number}, all starts")
        return dict(zip(LAWS, found, strict=True))


def by_size(
    known: Mapping[Law, Known], family: Family, name: str
) -> dict[Law, dict[float, np.ndarray]]:
    """A number of a family's members from all starts, by law and size [um]."""
    return {
        law: {member.size_um or 0.0: one[member][name] for member in one.members(family)}
        for law, one in known.items()
    }


class OnDemand(Known):
    """What is planned in a setting. Raises NotSimulatedError for what is not."""

    def __init__(self, planned: Iterable[Source], fetch: Fetch) -> None:
        super().__init__()
        self.planned = tuple(planned)
        self.fetch = fetch

    def __iter__(self) -> Iterator[Source]:
        return iter(self.planned)

    def __missing__(self, source: Source) -> Sample:
        if source not in self.planned:
            raise NotSimulatedError(source)
        self.fetch(source)
        return self[source]


def on_demand(material: Material, zeta: float) -> dict[Law, Known]:
    """Labelled reading, by law; what one law is asked is run for all."""
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
        known[law] = OnDemand(_planned(plan, Cell(law, zeta)), fetch)
    return known


def _planned(plan: Plan, cell: Cell) -> Iterator[Source]:
    yield STATIC
    if plan.variants:
        yield PLANTED
    yield from DEFAULTS
    yield from plan.sources(cell)

"""The experiments of a figure that is shown alone: each is run once it is asked for."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator

from crosscheck.audit.claims.quantities import Known, NotSimulatedError
from crosscheck.audit.claims.settings import Plan, plan_of, planted_of, statics_of
from crosscheck.audit.experiments.cells import LABELLED, LAWS, Cell, Law
from crosscheck.audit.experiments.experiments import (
    BACKLASH,
    DEFAULT_B_UM,
    DEFAULT_E_UM,
    ERROR,
    PD,
    PLANTED,
    STATIC,
    Source,
)
from crosscheck.audit.experiments.pool import Sample
from crosscheck.audit.page.material import Material

DEFAULTS = (BACKLASH(DEFAULT_B_UM), ERROR(DEFAULT_E_UM))  # other names of the default run
WITHOUT_SETTING = {STATIC: statics_of, PLANTED: planted_of}
Fetch = Callable[[Source], None]


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

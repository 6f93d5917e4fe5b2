"""Which statements about Figs. 11 to 14 and 16 to 20 rest on planets that are lumped."""

from __future__ import annotations

from dataclasses import dataclass, replace

from crosscheck.audit.claims.catalogue import CLAIMS
from crosscheck.audit.claims.quantities import Known
from crosscheck.audit.claims.rule import Answer, Claim, Place, answers
from crosscheck.audit.claims.settings import Settings, plan_of
from crosscheck.audit.experiments.cells import LAWS, Cell
from crosscheck.audit.experiments.experiments import (
    BACKLASH,
    CONSTANT_STIFFNESS,
    DEFAULT_B_UM,
    DEFAULT_E_UM,
    ERROR,
    NO_BACKLASH,
    NO_ERROR,
    PD,
    Source,
)
from crosscheck.audit.page.material import Material
from crosscheck.audit.planets.verdict import Survival, is_changed, survival

FIGURES = (*range(11, 15), *range(16, 21))  # of the PD run
ZETAS = (0.005, 0.02)


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
        """What becomes of it."""
        return survival(self.lumped.state, self.free.state)

    @property
    def changed(self) -> bool | None:
        """Whether the shares differ significantly; None where they could not be."""
        return is_changed(self.lumped.share, self.free.share, self.family)


def features(material: Material) -> list[Feature]:
    """Every statement about these figures, at a small and at a larger damping under all laws."""
    lumped, free = (_known(material, planets) for planets in ("lumped", "free"))
    found = []
    for claim in CLAIMS:
        if claim.figure in FIGURES:  # none of its answers where it is about other experiments
            alike = {one.place: one for one in answers(claim, lumped)}
            found += [(claim, one.place, alike[one.place], one) for one in answers(claim, free)]
    return [Feature(*each, len(found)) for each in found]


def _known(material: Material, planets: str) -> Settings:
    """The experiments that the figures rest on, in the few settings."""
    cells = [Cell(law, zeta) for law in LAWS for zeta in ZETAS]
    own = {cell: cell if planets == "free" else replace(cell, planets="lumped") for cell in cells}
    wanted = [(one, source) for one in own.values() for source in sources(material)]
    found = material.samples(wanted, "planets: the figures' statements")
    known = {
        cell: Known({source: found[one, source] for source in sources(material)})
        for cell, one in own.items()
    }
    for each in known.values():
        each[BACKLASH(DEFAULT_B_UM)] = each[ERROR(DEFAULT_E_UM)] = each[PD]
    return list(known.items())


def sources(material: Material) -> list[Source]:
    """Of the claims' experiments those under PD control."""
    plan = plan_of(material.scale)
    plain = [PD, NO_BACKLASH, NO_ERROR, CONSTANT_STIFFNESS]
    over_b = [BACKLASH(size) for size in plan.backlashes]
    return [*plain, *over_b, *(ERROR(size) for size in plan.errors)]

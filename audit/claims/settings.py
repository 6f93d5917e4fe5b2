"""Which experiments are made in which settings."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from crosscheck.audit.claims.quantities import Known
from crosscheck.audit.errata.planted import Planted, shown
from crosscheck.audit.experiments.cells import (
    AS_MODELLED,
    LABELLED,
    LAWS,
    READINGS,
    VARIANTS,
    ZETAS,
    Cell,
    GearModel,
)
from crosscheck.audit.experiments.experiments import (
    BACK,
    BACK_EVEN,
    BACKLASH,
    BACKLASH_NO_ERROR,
    CHAOTIC_UM,
    CONSTANT,
    CONSTANT_NO_ERROR,
    CONSTANT_PRELOADED,
    CONSTANT_SQUARE,
    CONSTANT_STIFFNESS,
    DEFAULT_B_UM,
    DEFAULT_E_UM,
    ERROR,
    NEIGHBOURS,
    NO_BACKLASH,
    NO_ERROR,
    PD,
    PLANTED,
    PRELOADED,
    SQUARE,
    STATIC,
    TURNING,
    TWO_PLANETS,
    TWO_SOFTER,
    WIDE,
    WIDE_M,
    Source,
)
from crosscheck.audit.experiments.pool import Sample, samples
from crosscheck.audit.experiments.scale import Scale
from crosscheck.audit.experiments.study import Study
from crosscheck.audit.experiments.variant import Numbers
from crosscheck.audit.statics.statics import Statics

VARIED = (PD, NO_ERROR)  # the experiments that are made of VARIANTS


@dataclass(frozen=True)
class Plan:
    """zetas: of all experiments but those of ``shaken``; sizes in um.

    shaken: of back and forth, the square wave, two planets, 3 s with b = 3000 um, links that turn
    back, preloaded constant torque, neighbouring motions, and neither backlash nor tooth error;
    variants: whether VARIANTS, other planets, other waves and planted errors are asked too. The
    second reading of Table I sweeps b and E at every second zeta. back: of Fig. 15, to which the
    claims add 1000 and 3000 um.
    """

    readings: tuple[str, ...] = tuple(READINGS)
    zetas: tuple[float, ...] = ZETAS
    shaken: tuple[float, ...] = (0.005, 0.02, 0.05)
    backlashes: tuple[float, ...] = (5.0, 10.0, 25.0, 500.0, 1000.0, 3000.0)
    errors: tuple[float, ...] = (0.8, 1.6, 3.2, 6.3)
    back: tuple[float, ...] = (0.0, 50.0, 100.0, 500.0)
    variants: bool = True

    def settings(self) -> list[Cell]:
        """Of the claims: planets free, all laws."""
        return [Cell(law, zeta, arm) for law, arm, zeta in product(LAWS, self.readings, self.zetas)]

    def as_modelled(self) -> list[Cell]:
        """Of the claims: the paper's own model."""
        return self.of(AS_MODELLED)

    def of(self, model: GearModel) -> list[Cell]:
        """All settings of a model of the gears."""
        return [Cell(model.law, z, arm, model.planets) for arm in self.readings for z in self.zetas]

    def variations(self) -> dict[GearModel, list[Cell]]:
        """Of the claims that need no more than the PD run: further models of the gears."""
        return {model: self.of(model) for model in VARIANTS} if self.variants else {}

    def sources(self, cell: Cell) -> Iterator[Source]:
        """What is simulated in a setting of the claims."""
        yield from (PD, CONSTANT, NO_BACKLASH, NO_ERROR, CONSTANT_STIFFNESS, CONSTANT_NO_ERROR)
        yield PRELOADED
        if cell.arm == self.readings[0] or cell.zeta in self.zetas[::2]:
            yield from (BACKLASH(size_um) for size_um in self.backlashes)
            yield from (ERROR(size_um) for size_um in self.errors)
        if cell.zeta in self.shaken:
            yield from (TWO_PLANETS, TWO_SOFTER) if self.variants else ()
            for size_um in (*self.back, CHAOTIC_UM, 1e6 * WIDE_M):
                yield from (BACK(size_um), BACK_EVEN(size_um))
            yield from (WIDE, TURNING, CONSTANT_PRELOADED, NEIGHBOURS, BACKLASH_NO_ERROR(0.0))
            yield from (SQUARE, CONSTANT_SQUARE) if self.variants else ()


FULL = Plan()
QUICK = Plan(
    readings=(LABELLED,),
    zetas=(0.005, 0.02),
    shaken=(0.02,),
    backlashes=(5.0, 500.0),
    errors=(1.6, 6.3),
    back=(0.0, 50.0, 500.0),
    variants=False,
)
Settings = list[tuple[Cell, Known]]


def plan_of(scale: Scale) -> Plan:
    """The full or the quick one."""
    return QUICK if scale.quick else FULL


def settings(study: Study, scale: Scale) -> Settings:
    """Every setting of the claims with planets free, with its experiments."""
    return _of_cells(study, scale, plan_of(scale).settings(), "claims")


def as_modelled(study: Study, scale: Scale) -> Settings:
    """Every setting of the paper's own model with its experiments."""
    return _of_cells(study, scale, plan_of(scale).as_modelled(), "claims, as modelled")


def _of_cells(study: Study, scale: Scale, cells: Sequence[Cell], what: str) -> Settings:
    plan = plan_of(scale)
    wanted = [(cell, source) for cell in cells for source in plan.sources(cell)]
    found = samples(study, scale, wanted, what)
    asked = {STATIC: statics_of, PLANTED: planted_of} if plan.variants else {STATIC: statics_of}
    static = {source: ask(study, plan.readings) for source, ask in asked.items()}
    place = {arm: number for number, arm in enumerate(plan.readings)}
    made = {
        cell: Known({source: by_arm[place[cell.arm]] for source, by_arm in static.items()})
        for cell in cells
    }
    for (cell, source), sample in found.items():
        made[cell][source] = sample
    for known in made.values():  # the default run is a member of both sweeps
        known[BACKLASH(DEFAULT_B_UM)] = known[ERROR(DEFAULT_E_UM)] = known[PD]
    return list(made.items())


def variations(study: Study, scale: Scale) -> dict[GearModel, Settings]:
    """The settings of VARIANTS with what is asked there."""
    asked = plan_of(scale).variations()
    wanted = [(cell, source) for cells in asked.values() for cell in cells for source in VARIED]
    found = samples(study, scale, wanted, "claims, variants")
    return {
        model: [(cell, Known({source: found[cell, source] for source in VARIED})) for cell in cells]
        for model, cells in asked.items()
    }


def statics_of(study: Study, arms: Sequence[str]) -> list[Sample]:
    """What follows from the data of each arm alone."""
    return [_of(n) for n in study.answers([Statics(arm) for arm in arms], "claims: statics")]


def planted_of(study: Study, arms: Sequence[str]) -> list[Sample]:
    """What an agreement of each arm shows of slips that were planted."""
    found = study.answers([Planted(arm) for arm in arms], "claims: planted slips")
    return [_of({"planted_shown": shown(plants)}) for plants in found]


def _of(numbers: Numbers) -> Sample:
    """One value each."""
    return Sample({name: np.array([value], float) for name, value in numbers.items()}, _NO_RUN)


_NO_RUN = np.zeros(1, dtype=bool)

"""Which experiments are made in which settings."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from crosscheck.audit.claims.quantities import Known
from crosscheck.audit.errata.planted import Planted, shown
from crosscheck.audit.experiments import cells
from crosscheck.audit.experiments import experiments as run
from crosscheck.audit.experiments.cells import Cell, GearModel
from crosscheck.audit.experiments.pool import Sample, samples
from crosscheck.audit.experiments.scale import Scale
from crosscheck.audit.experiments.study import Study
from crosscheck.audit.experiments.variant import Numbers
from crosscheck.audit.statics.statics import Statics

VARIED = (run.PD, run.NO_ERROR)  # the experiments that are made of VARIANTS


@dataclass(frozen=True)
class Plan:
    """What is simulated where. zetas: of all experiments but those of ``shaken``; sizes in um.

    shaken: of back and forth, the square wave, two planets, 3 s with b = 3000 um, links that turn
    back, preloaded constant torque, neighbouring motions, and neither backlash nor tooth error;
    variants: whether VARIANTS, other planets, other waves and planted errors are asked too. The
    second reading of Table I sweeps b and E at every second zeta. back: of Fig. 15, to which the
    claims add 1000 and 3000 um.
    """

    readings: tuple[str, ...] = tuple(cells.READINGS)
    zetas: tuple[float, ...] = cells.ZETAS
    shaken: tuple[float, ...] = (0.005, 0.02, 0.05)
    backlashes: tuple[float, ...] = (5.0, 10.0, 25.0, 500.0, 1000.0, 3000.0)
    errors: tuple[float, ...] = (0.8, 1.6, 3.2, 6.3)
    back: tuple[float, ...] = (0.0, 50.0, 100.0, 500.0)
    variants: bool = True

    def settings(self) -> list[Cell]:
        """The settings of the claims: planets free, all laws."""
        every = product(cells.LAWS, self.readings, self.zetas)
        return [Cell(law, zeta, arm) for law, arm, zeta in every]

    def of(self, model: GearModel) -> list[Cell]:
        """The settings of a model of the gears, at every reading and damping ratio."""
        return [Cell(model.law, z, arm, model.planets) for arm in self.readings for z in self.zetas]

    def sources(self, cell: Cell) -> Iterator[run.Source]:
        """The experiments that are simulated in a setting of the claims."""
        yield from (run.PD, run.CONSTANT, run.NO_BACKLASH, run.NO_ERROR, run.CONSTANT_STIFFNESS)
        yield from (run.CONSTANT_NO_ERROR, run.PRELOADED)
        if cell.arm == self.readings[0] or cell.zeta in self.zetas[::2]:
            yield from (run.BACKLASH(size_um) for size_um in self.backlashes)
            yield from (run.ERROR(size_um) for size_um in self.errors)
        if cell.zeta in self.shaken:
            yield from (run.TWO_PLANETS, run.TWO_SOFTER) if self.variants else ()
            for size_um in (*self.back, run.CHAOTIC_UM, 1e6 * run.WIDE_M):
                yield from (run.BACK(size_um), run.BACK_EVEN(size_um))
            yield from (run.WIDE, run.TURNING, run.CONSTANT_PRELOADED, run.NEIGHBOURS)
            yield run.BACKLASH_NO_ERROR(0.0)
            yield from (run.SQUARE, run.CONSTANT_SQUARE) if self.variants else ()


FULL = Plan()
QUICK = Plan(
    readings=(cells.LABELLED,),
    zetas=(0.005, 0.02),
    shaken=(0.02,),
    backlashes=(5.0, 500.0),
    errors=(1.6, 6.3),
    back=(0.0, 50.0, 500.0),
    variants=False,
)
Settings = list[tuple[Cell, Known]]


def plan_of(scale: Scale) -> Plan:
    """The full or the quick plan."""
    return QUICK if scale.quick else FULL


def with_experiments(study: Study, scale: Scale, chosen: Sequence[Cell], what: str) -> Settings:
    """The chosen settings, each with its experiments and what follows from the arm's data."""
    plan = plan_of(scale)
    wanted = [(cell, source) for cell in chosen for source in plan.sources(cell)]
    found = samples(study, scale, wanted, what)
    static = {run.STATIC: statics_of(study, plan.readings)}
    if plan.variants:
        static[run.PLANTED] = planted_of(study, plan.readings)
    made = {}
    for cell in chosen:
        place = plan.readings.index(cell.arm)
        made[cell] = Known({source: by_arm[place] for source, by_arm in static.items()})
    for (cell, source), sample in found.items():
        made[cell][source] = sample
    for known in made.values():
        known.update(dict.fromkeys(run.DEFAULTS, known[run.PD]))
    return list(made.items())


def variations(study: Study, scale: Scale) -> dict[GearModel, Settings]:
    """The settings of each of VARIANTS with what is asked there; none if the plan has none."""
    plan = plan_of(scale)
    asked = {model: plan.of(model) for model in cells.VARIANTS} if plan.variants else {}
    wanted = [(cell, source) for own in asked.values() for cell in own for source in VARIED]
    found = samples(study, scale, wanted, "claims, variants")
    return {
        model: [(cell, Known({source: found[cell, source] for source in VARIED})) for cell in own]
        for model, own in asked.items()
    }


def statics_of(study: Study, arms: Sequence[str]) -> list[Sample]:
    """The numbers that follow from the data of each arm alone."""
    return [_of(n) for n in study.answers([Statics(arm) for arm in arms], "claims: statics")]


def planted_of(study: Study, arms: Sequence[str]) -> list[Sample]:
    """The share of planted errors that an agreement of two models would show, for each arm."""
    found = study.answers([Planted(arm) for arm in arms], "claims: planted slips")
    return [_of({"planted_shown": shown(plants)}) for plants in found]


def _of(numbers: Numbers) -> Sample:
    """A sample of one start whose numbers are these."""
    values = {name: np.array([value], float) for name, value in numbers.items()}
    return Sample(values, diverged=np.zeros(1, dtype=bool))

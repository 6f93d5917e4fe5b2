"""When the planets of a stage part: predicted by Hill's equation, and measured in the free run."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from analytic.model import PhysicalModel
from crosscheck.paper.planets.hill import Differences, followed
from crosscheck.paper.undefined import defined
from crosscheck.studies.variant import Variant
from models.errors import Diverged
from models.loading import Case

APART_M = 1e-6  # planets have parted: a fifth of the tooth error
BIN_S = 0.005
FAINTEST_M = 1e-30  # for the logarithm of planets that are exactly alike

Series = tuple[tuple[float | None, ...], ...]  # (stages, bins)
Times = tuple[float | None, ...]  # (stages,)


@dataclass(frozen=True)
class Course:
    """Largest spread of a stage's planets in every bin, log10 of metres; when it passes 1 um."""

    spread: Series
    parting_s: Times


@dataclass(frozen=True)
class Parted:
    """One start: the free run's own course, and what Hill's equation says of it, stage by stage.

    time_s: where the bins begin; by_lumped: along the run with all planets lumped, started as the
    mean of the planets; by_free: along the free run, every stage's planets at their mean; pressed:
    along the lumped run as if no mesh ever parted; strayed_s: when that mean and the lumped run's
    x_pr are 1 um apart.
    """

    time_s: tuple[float, ...]
    measured: Course
    by_lumped: Course
    by_free: Course
    pressed: Course
    strayed_s: Times


@dataclass(frozen=True)
class Parting:
    """The parting of the planets in a variant's experiment, its planets free."""

    variant: Variant

    @property
    def inputs(self) -> str:
        return "\n".join(record.model_dump_json() for record in self.variant.case())

    @property
    def cost(self) -> float:
        return 4.0 * (self.variant.duration_s or 3.0)

    def answer(self) -> Parted | None:
        """None if a run diverges."""
        case = self.variant.case()
        start = np.ptp(np.array(case.scenario.start.planet_offset_m), axis=1)
        try:
            free = followed(PhysicalModel(*case), start)
            shared = followed(PhysicalModel(*alike(case)), start, pressed=(False, True))
        except Diverged:
            return None
        time, by_lumped, by_pressed = free.time, *shared.differences
        spread = _log(np.column_stack([np.ptp(x, axis=1) for x in free.x_pr]))
        means = np.column_stack([x.mean(axis=1) for x in free.x_pr])
        strayed = _log(np.abs(means - np.column_stack(shared.x_pr)))
        return Parted(
            tuple(map(float, time[_edges(time)])),
            _course(time, Differences(spread, spread)),
            _course(time, by_lumped),
            _course(time, *free.differences),
            _course(time, by_pressed),
            tuple(_first(time, column) for column in strayed.T),
        )


def _log(length_m: np.ndarray) -> np.ndarray:
    return np.log(np.maximum(length_m, FAINTEST_M))


def alike(case: Case) -> Case:
    """The experiment with planets lumped, each stage's started as the mean of its free ones."""
    start = case.scenario.start
    mean = np.array(start.planet_offset_m).mean(axis=1)
    moved = {
        "sun_planet_offset_m": tuple(map(float, np.array(start.sun_planet_offset_m) - mean)),
        "planet_ring_offset_m": tuple(map(float, np.array(start.planet_ring_offset_m) + mean)),
        "planet_offset_m": (),
    }
    scenario = case.scenario.model_copy(update={"start": start.model_copy(update=moved)})
    switches = case.switches.model_copy(update={"planets": "lumped"})
    return Case(case.arm, scenario, switches)


def _edges(time: np.ndarray) -> np.ndarray:
    """Where bins begin."""
    return np.flatnonzero(np.diff(np.floor(time / BIN_S + 1e-9), prepend=-1))


def _course(time: np.ndarray, found: Differences) -> Course:
    """found: natural logarithms."""
    largest = np.maximum.reduceat(found.size, _edges(time), axis=0) / np.log(10)
    spread = tuple(tuple(defined(value) for value in column) for column in largest.T)
    return Course(spread, tuple(_first(time, column) for column in found.part.T))


def _first(time: np.ndarray, spread: np.ndarray) -> float | None:
    parted = spread >= np.log(APART_M)
    return float(time[np.argmax(parted)]) if parted.any() else None


def partings(one: Variant, starts: int) -> list[Parting]:
    """Of so many starts."""
    return [Parting(replace(one, seed=seed)) for seed in range(1, starts + 1)]

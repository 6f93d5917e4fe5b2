"""When the planets of a stage part: predicted by Hill's equation, and measured in the free run."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from crosscheck.analytic.model import PhysicalModel
from crosscheck.audit.experiments.question import Question, Records
from crosscheck.audit.experiments.starts import Perturbed
from crosscheck.audit.experiments.variant import Variant
from crosscheck.audit.measures.third import APART_M
from crosscheck.audit.measures.undefined import defined
from crosscheck.audit.phase.runs.experiments import models_of
from crosscheck.audit.phase.runs.plant import motion
from crosscheck.audit.planets.hill import Differences, FollowedPlanets, followed, stages_of
from crosscheck.models.loading import Case

BIN_S = 0.005
FAINTEST_M = 1e-30  # for the logarithm of planets that are exactly alike

Series = tuple[tuple[float | None, ...], ...]  # (stages, bins)
Times = tuple[float | None, ...]  # (stages,)


@dataclass(frozen=True)
class PartingCourse:
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
    measured: PartingCourse
    by_lumped: PartingCourse
    by_free: PartingCourse
    pressed: PartingCourse
    strayed_s: Times


@dataclass(frozen=True)
class FirstPartings(Perturbed[list[float | None]]):
    """When planets of a stage are first 1 um apart [s], of every start.

    None where they never are, or the run diverges before.
    """

    def answer(self) -> list[float | None]:
        models = models_of(self.variant, self.seeds)
        run = motion(models)
        with np.errstate(invalid="ignore"):  # of runs that diverge
            stages = stages_of(models[0])
            ends = stages.ring + stages.planets
            rings = zip(stages.ring, ends, strict=True)
            spreads = [np.ptp(run.q[:, begin:end], axis=1) for begin, end in rings]
            parted = np.max(spreads, axis=0) >= APART_M
        return [_when(run.time, each) for each in parted.T]


def _when(time: np.ndarray, happens: np.ndarray) -> float | None:
    """First, if ever."""
    return float(time[np.argmax(happens)]) if happens.any() else None


@dataclass(frozen=True)
class Partings(Question[list[Parted | None]]):
    """The parting of the planets in variants' experiments, alike but for their starts.

    Their planets are free.
    """

    variants: tuple[Variant, ...]

    def records(self) -> Records:
        return [record for variant in self.variants for record in variant.case()]

    @property
    def cost(self) -> float:
        return len(self.variants) * (self.variants[0].duration_s or 3.0)

    def answer(self) -> list[Parted | None]:
        """None for a start from which a run diverges."""
        cases = [variant.case() for variant in self.variants]
        offsets = [np.array(case.scenario.start.planet_offset_m) for case in cases]
        starts = np.array([np.ptp(each, axis=1) for each in offsets])
        free = followed([PhysicalModel(*case) for case in cases], starts)
        shared = followed([PhysicalModel(*alike(case)) for case in cases], starts)
        return [
            None if one is None or other is None else _parted(one, other)
            for one, other in zip(free, shared, strict=True)
        ]


def _parted(free: FollowedPlanets, shared: FollowedPlanets) -> Parted:
    """Of one start: its free run and the lumped one."""
    time = free.time
    spread = _log(np.column_stack([np.ptp(x, axis=1) for x in free.x_pr]))
    means = np.column_stack([x.mean(axis=1) for x in free.x_pr])
    strayed = _log(np.abs(means - np.column_stack(shared.x_pr)))
    return Parted(
        tuple(map(float, time[_edges(time)])),
        _course(time, Differences(spread, spread)),
        _course(time, shared.by_contact),
        _course(time, free.by_contact),
        _course(time, shared.pressed),
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


def _course(time: np.ndarray, found: Differences) -> PartingCourse:
    """found: natural logarithms."""
    largest = np.maximum.reduceat(found.size, _edges(time), axis=0) / np.log(10)
    spread = tuple(tuple(defined(value) for value in column) for column in largest.T)
    return PartingCourse(spread, tuple(_first(time, column) for column in found.part.T))


def _first(time: np.ndarray, spread: np.ndarray) -> float | None:
    return _when(time, spread >= np.log(APART_M))

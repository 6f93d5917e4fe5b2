"""When the planets of a stage part: predicted by Hill's equation, and measured in the free run."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from crosscheck.analytic.model import PhysicalModel
from crosscheck.audit.experiments.cells import LAWS, PRINTED, Cell
from crosscheck.audit.experiments.question import Question, Records
from crosscheck.audit.experiments.scale import Scale
from crosscheck.audit.experiments.starts import Perturbed
from crosscheck.audit.experiments.study import Study
from crosscheck.audit.experiments.variant import Variant
from crosscheck.audit.measures.events import THIRD_S
from crosscheck.audit.measures.shares import Share
from crosscheck.audit.measures.third import APART_M, Quantiles, quantiles
from crosscheck.audit.measures.undefined import defined, extreme
from crosscheck.audit.phase.runs import models_of, motion, pd_run
from crosscheck.audit.planets.hill import Differences, FollowedPlanets, followed, stages_of
from crosscheck.models.loading import Case

BIN_S = 0.005
FAINTEST_M = 1e-30  # for the logarithm of planets that are exactly alike

Series = tuple[tuple[float | None, ...], ...]  # (stages, bins)
Times = tuple[float | None, ...]  # (stages,)
JOINTS = ("shoulder", "elbow")
CELL = Cell(PRINTED, 0.005)  # where the start decides
BREAKING_ZETAS = (0.003, 0.005, 0.01, 0.02, 0.05)
STARTING_S = 0.3  # the teeth first change sides then: before, it is the starting vibration
STARTS = 24
RECORD_EVERY = 10
TOGETHER = 12  # starts that are followed at a time
PREDICTED = 0.10  # relative error of the time at which planets part
BINS_FOR_A_RATE = 4  # of 5 ms: over which a growth rate is taken


@dataclass(frozen=True)
class PartingCourse:
    """Largest spread of a stage's planets in every bin, log10 of metres; when it passes 1 um."""

    spread: Series
    parting_s: Times


@dataclass(frozen=True)
class Parted:
    """The parting in one start: the free run's course, and what Hill's equation says, by stage.

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
    """A question: when planets of a stage are first 1 um apart [s], for every start.

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
    """The first time [s] at which it happens; None if it never does."""
    return float(time[np.argmax(happens)]) if happens.any() else None


@dataclass(frozen=True)
class Partings(Question[list[Parted | None]]):
    """A question: the parting of planets in variants' experiments, alike but for their starts.

    Their planets are free.
    """

    variants: tuple[Variant, ...]

    def records(self) -> Records:
        return [record for variant in self.variants for record in variant.case()]

    @property
    def cost(self) -> float:
        return len(self.variants) * (self.variants[0].duration_s or 3.0)

    def answer(self) -> list[Parted | None]:
        """The parting in every start; None for a start from which a run diverges."""
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
    """The parting in one start, from its free run and its lumped one."""
    time = free.time
    spread = _log(np.column_stack([np.ptp(x, axis=1) for x in free.x_pr]))
    means = np.column_stack([x.mean(axis=1) for x in free.x_pr])
    strayed = _log(np.abs(means - np.column_stack(shared.x_pr)))
    return Parted(
        time_s=tuple(map(float, time[_edges(time)])),
        measured=_course(time, Differences(spread, spread)),
        by_lumped=_course(time, shared.by_contact),
        by_free=_course(time, free.by_contact),
        pressed=_course(time, shared.pressed),
        strayed_s=_passed(time, strayed),
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
    """Indices of the times at which bins begin."""
    return np.flatnonzero(np.diff(np.floor(time / BIN_S + 1e-9), prepend=-1))


def _course(time: np.ndarray, found: Differences) -> PartingCourse:
    """The course of planets' differences; found: natural logarithms of metres."""
    largest = np.maximum.reduceat(found.size, _edges(time), axis=0) / np.log(10)
    spread = tuple(tuple(defined(value) for value in column) for column in largest.T)
    return PartingCourse(spread, _passed(time, found.part))


def _passed(time: np.ndarray, spread: np.ndarray) -> Times:
    """Times [s] at which logarithms (times, stages) first pass that of 1 um, (stages,)."""
    return tuple(_when(time, column) for column in (spread >= np.log(APART_M)).T)


@dataclass(frozen=True)
class Predictions:
    """Times at which a joint's planets part, over the starts, as measured and as predicted.

    lumped_right, free_right: starts whose time is predicted within a tenth along the lumped or the
    free run, or that neither part nor should; largest_error: of those in which both part; first: in
    how many starts these planets part before the other joint's.
    """

    joint: str
    starts: int
    parted: int
    first: int
    median_s: float | None
    lumped_right: int
    lumped_largest_error: float | None
    free_right: int
    free_largest_error: float | None
    largest_growth_per_s: float | None
    pressed_largest_m: float | None


@dataclass(frozen=True)
class Foretold:
    """The first parting of a run, whichever joint's, along the lumped run or along the free one.

    asked: starts that were run; diverged: those left out because a run diverged; starts: those in
    which planets part or should; courses_part: in which they should; right: starts in which it is
    foretold within a tenth; strayed: in which the planets' mean had by then left the lumped run by
    1 um; right_unless_strayed: of the others.
    """

    along: str
    asked: int
    diverged: int
    starts: int
    courses_part: int
    right: int
    largest_error: float | None
    median_error: float | None
    strayed: int
    right_unless_strayed: int

    @property
    def all_right(self) -> bool | None:
        """Whether every start is foretold within a tenth; None if most runs diverged."""
        if not self.starts or 2 * self.diverged > self.asked:
            return None
        return self.right == self.starts


@dataclass(frozen=True)
class Breaking:
    """Times [s] at which the symmetry of the planets breaks in a setting, over its starts.

    parted: starts in which planets get 1 um apart; early: in which they do before STARTING_S.
    """

    cell: Cell
    parted: Share
    early: Share
    time_s: Quantiles


@dataclass(frozen=True)
class Growth:
    """Results on when planets part in many settings, and on what foretells it in one."""

    breaking: Sequence[Breaking]
    starts: Sequence[Parted]
    lumped: Foretold
    free: Foretold
    joints: Sequence[Predictions]


def growth(study: Study, scale: Scale) -> Growth:
    """Results at the bistable setting, from many starts, with the breaking in many settings."""
    one = replace(scale.cut(pd_run(CELL, THIRD_S[1])), record_every=RECORD_EVERY)
    starts = [replace(one, seed=seed) for seed in scale.seeds[: scale.starts(STARTS)]]
    asked_of = [
        Partings(tuple(starts[first : first + TOGETHER]))
        for first in range(0, len(starts), TOGETHER)
    ]
    answers = [each for some in study.answers(asked_of, "planets: parting") for each in some]
    found = [answer for answer in answers if answer is not None]
    asked = len(answers)
    return Growth(
        breaking(study, scale),
        found,
        _first_parting("lumped", asked, found),
        _first_parting("free", asked, found),
        [_predictions(found, joint) for joint in range(len(JOINTS))],
    )


def breaking(study: Study, scale: Scale) -> list[Breaking]:
    """The times at which planets part, over damping and laws, from the scale's starts."""
    asked = {
        cell: FirstPartings(scale.cut(pd_run(cell, THIRD_S[1])), scale.seeds)
        for cell in (Cell(law, zeta) for law in LAWS for zeta in BREAKING_ZETAS)
    }
    found = []
    for cell, answer in study.answered(asked, "planets: symmetry breaking").items():
        times = np.array(answer, dtype=float)
        parted, early = (int(x.sum()) for x in (np.isfinite(times), times < STARTING_S))
        shares = Share(parted, times.size), Share(early, times.size)
        found.append(Breaking(cell, *shares, quantiles(times)))
    return found


def parting_is_predicted(predicted_s: float | None, measured_s: float | None) -> bool:
    """Whether both never part, or both part at nearly the same time [s]."""
    if predicted_s is None or measured_s is None:
        return predicted_s is measured_s
    return abs(predicted_s / measured_s - 1) <= PREDICTED


def earliest(times: Sequence[float | None]) -> float | None:
    """The earliest of the times [s] that are not None; None without any."""
    return min((time for time in times if time is not None), default=None)


def _first_parting(along: str, asked: int, found: Sequence[Parted]) -> Foretold:
    """How the first parting is foretold. along: the ``lumped`` or the ``free`` run."""
    told, strayed = [], []
    for one in found:
        courses = getattr(one, f"by_{along}"), one.measured
        predicted, measured = (earliest(course.parting_s) for course in courses)
        if predicted is not None or measured is not None:
            told.append((predicted, measured))
            left = earliest(one.strayed_s)  # whether it did before the planets parted
            strayed.append(left is not None and (measured is None or left < measured))
    right = [parting_is_predicted(*pair) for pair in told]
    errors = _errors(told)
    return Foretold(
        along=along,
        asked=asked,
        diverged=asked - len(found),
        starts=len(told),
        courses_part=sum(predicted is not None for predicted, _ in told),
        right=sum(right),
        largest_error=defined(extreme(errors, max)),
        median_error=defined(float(np.median(errors))) if errors else None,
        strayed=sum(strayed),
        right_unless_strayed=sum(a and not b for a, b in zip(right, strayed, strict=True)),
    )


def _predictions(found: Sequence[Parted], joint: int) -> Predictions:
    measured = [one.measured.parting_s[joint] for one in found]
    lumped, free = (
        [(getattr(one, along).parting_s[joint], one.measured.parting_s[joint]) for one in found]
        for along in ("by_lumped", "by_free")
    )
    parted = [time for time in measured if time is not None]
    pressed = extreme((v for one in found for v in one.pressed.spread[joint]), max)
    return Predictions(
        joint=JOINTS[joint],
        starts=len(found),
        parted=len(parted),
        first=sum(
            time is not None and time == earliest(one.measured.parting_s)
            for one, time in zip(found, measured, strict=True)
        ),
        median_s=float(np.median(parted)) if parted else None,
        lumped_right=sum(parting_is_predicted(*pair) for pair in lumped),
        lumped_largest_error=defined(extreme(_errors(lumped), max)),
        free_right=sum(parting_is_predicted(*pair) for pair in free),
        free_largest_error=defined(extreme(_errors(free), max)),
        largest_growth_per_s=defined(extreme((_rate(one, joint) for one in found), max)),
        pressed_largest_m=defined(10**pressed),
    )


def _errors(pairs: Sequence[tuple[float | None, float | None]]) -> list[float]:
    """Relative errors of (predicted, measured) times, where both are there."""
    return [abs(p / m - 1) for p, m in pairs if p is not None and m is not None]


def _rate(one: Parted, joint: int) -> float:
    """Largest growth rate [1/s] that the equation has along the lumped run; nan if too short."""
    if len(one.time_s) <= BINS_FOR_A_RATE:
        return float("nan")
    later, before = slice(BINS_FOR_A_RATE, None), slice(-BINS_FOR_A_RATE)
    time, found = np.array(one.time_s), levels(one.by_lumped, joint)
    rates = np.log(10) * (found[later] - found[before]) / (time[later] - time[before])
    return float(np.nanmax(rates))


def levels(course: PartingCourse, joint: int) -> np.ndarray:
    """The log10 of the spread [m] in every bin, (bins,), nan where undefined."""
    return np.array(course.spread[joint], dtype=float)

"""When the planets of a stage part: predicted by Hill's equation, and measured in the free run."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from crosscheck.analytic.model import PhysicalModel
from crosscheck.audit.experiments.ensembles import EnsembleQuestion
from crosscheck.audit.experiments.paper_conditions import LAWS, PRINTED, Condition
from crosscheck.audit.experiments.question import Question, Records
from crosscheck.audit.experiments.scale import Scale
from crosscheck.audit.experiments.study import Study
from crosscheck.audit.experiments.variant import Variant
from crosscheck.audit.measures.events import THIRD_S
from crosscheck.audit.measures.shares import Share
from crosscheck.audit.measures.third_fluctuation import PARTING_SPREAD_M, Quantiles, quantiles
from crosscheck.audit.measures.undefined import extreme_value, float_or_none
from crosscheck.audit.phase.runs import build_models, build_pd_variant, simulate_motion
from crosscheck.audit.planets.hill import Differences, FollowedPlanets, build_stages, follow_planets
from crosscheck.models.loading import Case

BIN_S = 0.005
FAINTEST_M = 1e-30  # for the logarithm of planets that are exactly alike

Series = tuple[tuple[float | None, ...], ...]  # (stages, bins)
Times = tuple[float | None, ...]  # (stages,)
JOINTS = ("shoulder", "elbow")
CELL = Condition(PRINTED, 0.005)  # where the start decides
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
class SymmetryBreaking:
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
class FirstPartingQuestion(EnsembleQuestion[list[float | None]]):
    """A question: when planets of a stage are first 1 um apart [s], for every start.

    None where they never are, or the run diverges before.
    """

    def answer(self) -> list[float | None]:
        models = build_models(self.variant, self.seeds)
        run = simulate_motion(models)
        with np.errstate(invalid="ignore"):  # of runs that diverge
            stages = build_stages(models[0])
            ends = stages.ring + stages.planets
            rings = zip(stages.ring, ends, strict=True)
            spreads = [np.ptp(run.q[:, begin:end], axis=1) for begin, end in rings]
            parted = np.max(spreads, axis=0) >= PARTING_SPREAD_M
        return [_first_time(run.time, each) for each in parted.T]


def _first_time(time: np.ndarray, happens: np.ndarray) -> float | None:
    """The first time [s] at which it happens; None if it never does."""
    return float(time[np.argmax(happens)]) if happens.any() else None


@dataclass(frozen=True)
class PartingQuestion(Question[list[SymmetryBreaking | None]]):
    """A question: the parting of planets in variants' experiments, alike but for their starts.

    Their planets are free.
    """

    variants: tuple[Variant, ...]

    def records(self) -> Records:
        return [record for variant in self.variants for record in variant.case()]

    @property
    def cost(self) -> float:
        return len(self.variants) * (self.variants[0].duration_s or 3.0)

    def answer(self) -> list[SymmetryBreaking | None]:
        """The parting in every start; None for a start from which a run diverges."""
        cases = [variant.case() for variant in self.variants]
        offsets = [np.array(case.scenario.start.planet_offset_m) for case in cases]
        starts = np.array([np.ptp(each, axis=1) for each in offsets])
        free = follow_planets([PhysicalModel(*case) for case in cases], starts)
        shared = follow_planets([PhysicalModel(*make_lumped_case(case)) for case in cases], starts)
        return [
            None if free_run is None or lumped_run is None else _compare_runs(free_run, lumped_run)
            for free_run, lumped_run in zip(free, shared, strict=True)
        ]


def _compare_runs(free: FollowedPlanets, shared: FollowedPlanets) -> SymmetryBreaking:
    """The parting in one start, from its free run and its lumped one."""
    time = free.time
    spread = _log(np.column_stack([np.ptp(x, axis=1) for x in free.x_pr]))
    means = np.column_stack([x.mean(axis=1) for x in free.x_pr])
    strayed = _log(np.abs(means - np.column_stack(shared.x_pr)))
    return SymmetryBreaking(
        time_s=tuple(map(float, time[_edges(time)])),
        measured=_course(time, Differences(spread, spread)),
        by_lumped=_course(time, shared.by_contact),
        by_free=_course(time, free.by_contact),
        pressed=_course(time, shared.pressed),
        strayed_s=_passing_times(time, strayed),
    )


def _log(length_m: np.ndarray) -> np.ndarray:
    return np.log(np.maximum(length_m, FAINTEST_M))


def make_lumped_case(case: Case) -> Case:
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


def _course(time: np.ndarray, differences: Differences) -> PartingCourse:
    """The course of planets' differences; differences: natural logarithms of metres."""
    largest = np.maximum.reduceat(differences.size, _edges(time), axis=0) / np.log(10)
    spread = tuple(tuple(float_or_none(value) for value in column) for column in largest.T)
    return PartingCourse(spread, _passing_times(time, differences.part))


def _passing_times(time: np.ndarray, spread: np.ndarray) -> Times:
    """Times [s] at which logarithms (times, stages) first pass that of 1 um, (stages,)."""
    return tuple(_first_time(time, column) for column in (spread >= np.log(PARTING_SPREAD_M)).T)


@dataclass(frozen=True)
class JointPrediction:
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
class PartingPrediction:
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
class BreakingTimes:
    """Times [s] at which the symmetry of the planets breaks in a setting, over its starts.

    parted: starts in which planets get 1 um apart; early: in which they do before STARTING_S.
    """

    cell: Condition
    parted: Share
    early: Share
    time_s: Quantiles


@dataclass(frozen=True)
class PartingResult:
    """Results on when planets part in many settings, and on what foretells it in one."""

    breaking: Sequence[BreakingTimes]
    starts: Sequence[SymmetryBreaking]
    lumped: PartingPrediction
    free: PartingPrediction
    joints: Sequence[JointPrediction]


def compare_partings(study: Study, scale: Scale) -> PartingResult:
    """Results at the bistable setting, from many starts, with the breaking in many settings."""
    variant = replace(scale.cut(build_pd_variant(CELL, THIRD_S[1])), record_every=RECORD_EVERY)
    starts = [replace(variant, seed=seed) for seed in scale.seeds[: scale.limit_starts(STARTS)]]
    questions = [
        PartingQuestion(tuple(starts[first : first + TOGETHER]))
        for first in range(0, len(starts), TOGETHER)
    ]
    answers = [
        each for some in study.answer_questions(questions, "planets: parting") for each in some
    ]
    partings = [answer for answer in answers if answer is not None]
    start_count = len(answers)
    return PartingResult(
        measure_breaking_times(study, scale),
        partings,
        _count_predictions("lumped", start_count, partings),
        _count_predictions("free", start_count, partings),
        [_summarize_joint(partings, joint) for joint in range(len(JOINTS))],
    )


def measure_breaking_times(study: Study, scale: Scale) -> list[BreakingTimes]:
    """The times at which planets part, over damping and laws, from the scale's starts."""
    questions = {
        cell: FirstPartingQuestion(scale.cut(build_pd_variant(cell, THIRD_S[1])), scale.seeds)
        for cell in (Condition(law, zeta) for law in LAWS for zeta in BREAKING_ZETAS)
    }
    breaking_times = []
    for cell, answer in study.answer_by_key(questions, "planets: symmetry breaking").items():
        times = np.array(answer, dtype=float)
        parted, early = (int(x.sum()) for x in (np.isfinite(times), times < STARTING_S))
        shares = Share(parted, times.size), Share(early, times.size)
        breaking_times.append(BreakingTimes(cell, *shares, quantiles(times)))
    return breaking_times


def is_parting_predicted(predicted_s: float | None, measured_s: float | None) -> bool:
    """Whether both never part, or both part at nearly the same time [s]."""
    if predicted_s is None or measured_s is None:
        return predicted_s is measured_s
    return abs(predicted_s / measured_s - 1) <= PREDICTED


def earliest_time(times: Sequence[float | None]) -> float | None:
    """The earliest of the times [s] that are not None; None without any."""
    return min((time for time in times if time is not None), default=None)


def _count_predictions(
    along: str, start_count: int, partings: Sequence[SymmetryBreaking]
) -> PartingPrediction:
    """How the first parting is foretold. along: the ``lumped`` or the ``free`` run."""
    pairs, strayed = [], []
    for start in partings:
        courses = getattr(start, f"by_{along}"), start.measured
        predicted, measured = (earliest_time(course.parting_s) for course in courses)
        if predicted is not None or measured is not None:
            pairs.append((predicted, measured))
            left = earliest_time(start.strayed_s)  # whether it did before the planets parted
            strayed.append(left is not None and (measured is None or left < measured))
    right = [is_parting_predicted(*pair) for pair in pairs]
    errors = _errors(pairs)
    return PartingPrediction(
        along=along,
        asked=start_count,
        diverged=start_count - len(partings),
        starts=len(pairs),
        courses_part=sum(predicted is not None for predicted, _ in pairs),
        right=sum(right),
        largest_error=float_or_none(extreme_value(errors, max)),
        median_error=float_or_none(float(np.median(errors))) if errors else None,
        strayed=sum(strayed),
        right_unless_strayed=sum(a and not b for a, b in zip(right, strayed, strict=True)),
    )


def _summarize_joint(partings: Sequence[SymmetryBreaking], joint: int) -> JointPrediction:
    measured = [start.measured.parting_s[joint] for start in partings]
    lumped, free = (
        [
            (getattr(start, along).parting_s[joint], start.measured.parting_s[joint])
            for start in partings
        ]
        for along in ("by_lumped", "by_free")
    )
    parted = [time for time in measured if time is not None]
    pressed = extreme_value((v for start in partings for v in start.pressed.spread[joint]), max)
    return JointPrediction(
        joint=JOINTS[joint],
        starts=len(partings),
        parted=len(parted),
        first=sum(
            time is not None and time == earliest_time(start.measured.parting_s)
            for start, time in zip(partings, measured, strict=True)
        ),
        median_s=float(np.median(parted)) if parted else None,
        lumped_right=sum(is_parting_predicted(*pair) for pair in lumped),
        lumped_largest_error=float_or_none(extreme_value(_errors(lumped), max)),
        free_right=sum(is_parting_predicted(*pair) for pair in free),
        free_largest_error=float_or_none(extreme_value(_errors(free), max)),
        largest_growth_per_s=float_or_none(
            extreme_value((_rate(start, joint) for start in partings), max)
        ),
        pressed_largest_m=float_or_none(10**pressed),
    )


def _errors(pairs: Sequence[tuple[float | None, float | None]]) -> list[float]:
    """Relative errors of (predicted, measured) times, where both are there."""
    return [abs(p / m - 1) for p, m in pairs if p is not None and m is not None]


def _rate(parting: SymmetryBreaking, joint: int) -> float:
    """Largest growth rate [1/s] that the equation has along the lumped run; nan if too short."""
    if len(parting.time_s) <= BINS_FOR_A_RATE:
        return float("nan")
    later, before = slice(BINS_FOR_A_RATE, None), slice(-BINS_FOR_A_RATE)
    time, logarithms = np.array(parting.time_s), log_spread(parting.by_lumped, joint)
    rates = np.log(10) * (logarithms[later] - logarithms[before]) / (time[later] - time[before])
    return float(np.nanmax(rates))


def log_spread(course: PartingCourse, joint: int) -> np.ndarray:
    """The log10 of the spread [m] in every bin, (bins,), nan where undefined."""
    return np.array(course.spread[joint], dtype=float)

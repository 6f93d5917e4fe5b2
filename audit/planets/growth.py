"""When planets part: Hill's equation along the run, and the times that it foretells."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from crosscheck.audit.experiments.cells import LAWS, PRINTED, Cell
from crosscheck.audit.experiments.scale import Scale
from crosscheck.audit.experiments.study import Study
from crosscheck.audit.measures.events import THIRD_S
from crosscheck.audit.measures.shares import Share
from crosscheck.audit.measures.third import Quantiles, quantiles
from crosscheck.audit.measures.undefined import defined, extreme
from crosscheck.audit.phase.runs.experiments import pd_run
from crosscheck.audit.planets.parting import FirstPartings, Parted, PartingCourse, Partings
from crosscheck.audit.planets.verdict import parting_is_predicted

JOINTS = ("shoulder", "elbow")
CELL = Cell(PRINTED, 0.005)  # where the start decides
BREAKING_ZETAS = (0.003, 0.005, 0.01, 0.02, 0.05)
STARTING_S = 0.3  # the teeth first change sides then: before, it is the starting vibration
STARTS = 24
RECORD_EVERY = 10
TOGETHER = 12  # starts that are followed at a time
BINS_FOR_A_RATE = 4  # of 5 ms: over which a growth rate is taken


@dataclass(frozen=True)
class Predictions:
    """Of a joint's planets, over the starts: when they part as measured and as predicted.

    right, of: starts whose time is predicted within a tenth, of those that part or should, along
    the lumped run and along the free one; largest_error: of those in which both part; first: in how
    many starts these planets part before the other joint's.
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
    """A setting: when the symmetry of the planets breaks [s], over its starts.

    parted: starts in which planets get 1 um apart; early: in which they do before STARTING_S.
    """

    cell: Cell
    parted: Share
    early: Share
    time_s: Quantiles


@dataclass(frozen=True)
class Growth:
    """When planets part in many settings, and what foretells it in one."""

    breaking: Sequence[Breaking]
    starts: Sequence[Parted]
    lumped: Foretold
    free: Foretold
    joints: Sequence[Predictions]


def growth(study: Study, scale: Scale) -> Growth:
    """At the bistable setting, from many starts."""
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
        _first_parting("lumped", asked, found, [one.by_lumped for one in found]),
        _first_parting("free", asked, found, [one.by_free for one in found]),
        [_predictions(found, joint) for joint in range(len(JOINTS))],
    )


def breaking(study: Study, scale: Scale) -> list[Breaking]:
    """When planets part, over damping and laws."""
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


def earliest(times: Sequence[float | None]) -> float | None:
    """Of those that happen."""
    return min((time for time in times if time is not None), default=None)


def _first_parting(
    along: str, asked: int, found: Sequence[Parted], courses: Sequence[PartingCourse]
) -> Foretold:
    told = [
        (pair, _strayed_before(one, pair[1]))
        for one, course in zip(found, courses, strict=True)
        if (pair := (earliest(course.parting_s), earliest(one.measured.parting_s))) != (None, None)
    ]
    errors = _errors([pair for pair, _ in told])
    return Foretold(
        along=along,
        asked=asked,
        diverged=asked - len(found),
        starts=len(told),
        courses_part=sum(predicted is not None for (predicted, _), _ in told),
        right=sum(parting_is_predicted(*pair) for pair, _ in told),
        largest_error=defined(extreme(errors, max)),
        median_error=defined(float(np.median(errors))) if errors else None,
        strayed=sum(strayed for _, strayed in told),
        right_unless_strayed=sum(parting_is_predicted(*p) for p, strayed in told if not strayed),
    )


def _strayed_before(one: Parted, parting_s: float | None) -> bool:
    """Whether the planets' mean had left the lumped run before they parted."""
    first = earliest(one.strayed_s)
    return first is not None and (parting_s is None or first < parting_s)


def _predictions(found: Sequence[Parted], joint: int) -> Predictions:
    measured = [one.measured.parting_s[joint] for one in found]
    lumped, free = (
        [(course.parting_s[joint], time) for course, time in zip(courses, measured, strict=True)]
        for courses in ([one.by_lumped for one in found], [one.by_free for one in found])
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
    """Relative, of (predicted, measured) times that are both there."""
    return [abs(p / m - 1) for p, m in pairs if p is not None and m is not None]


def _rate(one: Parted, joint: int) -> float:
    """Largest growth rate [1/s] that the equation has along the lumped run; nan if too short."""
    found = levels(one.by_lumped, joint)
    if found.size <= BINS_FOR_A_RATE:
        return float("nan")
    span = np.array(one.time_s)[BINS_FOR_A_RATE:] - np.array(one.time_s)[:-BINS_FOR_A_RATE]
    rates = np.log(10) * (found[BINS_FOR_A_RATE:] - found[:-BINS_FOR_A_RATE]) / span
    return float(np.nanmax(rates))


def levels(course: PartingCourse, joint: int) -> np.ndarray:
    """log10 of the spread [m] in every bin, nan where undefined."""
    return np.array(course.spread[joint], dtype=float)

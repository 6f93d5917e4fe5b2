"""Why planets part: Hill's equation along the run, and the times that it foretells."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from matplotlib.axes import Axes

from crosscheck.paper.numbers import defined
from crosscheck.paper.phase.experiments import SETTINGS
from crosscheck.paper.planets.pairs import STARTS
from crosscheck.paper.planets.parting import APART_M, Course, Parted, partings
from crosscheck.paper.planets.samples import Cell
from crosscheck.paper.planets.verdict import PREDICTED, parting_is_predicted
from crosscheck.paper.record import JsonObject, Record
from crosscheck.paper.scale import Scale
from crosscheck.paper.undefined import extreme, known, percent, shown
from crosscheck.report.figures import legend, new_figure, not_reached, to_svg
from crosscheck.report.fragments import COLOURS, figure, heading, paragraph, table
from crosscheck.studies.study import Study

JOINTS = ("shoulder", "elbow")
BINS_FOR_A_RATE = 4  # of 5 ms: over which a growth rate is taken
LOWEST, HIGHEST = -20.5, -2.0  # log10 of metres: what is drawn


@dataclass(frozen=True)
class Predictions(Record):
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

    @property
    def id(self) -> str:
        return f"planets/parting/{self.joint}"


@dataclass(frozen=True)
class Foretold(Record):
    """The first parting of a run, whichever joint's, along the lumped run or along the free one.

    asked: starts that were run; diverged: those left out because a run diverged; starts: those in
    which planets part or should; courses_part: in which they should; earliest_s, latest_s: when
    they part as measured; right: starts in which it is foretold within a tenth; strayed: in which
    the planets' mean had by then left the lumped run by 1 um; right_unless_strayed: of the others.
    """

    along: str
    asked: int
    diverged: int
    starts: int
    courses_part: int
    earliest_s: float | None
    latest_s: float | None
    right: int
    largest_error: float | None
    median_error: float | None
    strayed: int
    right_unless_strayed: int

    @property
    def id(self) -> str:
        return f"planets/parting/first/{self.along}"

    @property
    def all_right(self) -> bool | None:
        """Whether every start is foretold within a tenth; None if most runs diverged."""
        if not self.starts or 2 * self.diverged > self.asked:
            return None
        return self.right == self.starts

    @property
    def always_parts(self) -> bool:
        """Whether the equation parts planets in every start that did not diverge."""
        return 0 < self.courses_part == self.asked - self.diverged

    def to_dict(self) -> JsonObject:
        return {**super().to_dict(), "within": PREDICTED, "predicted": self.all_right}


@dataclass(frozen=True)
class Growth:
    """The predictions and their text."""

    html: str
    lumped: Foretold
    free: Foretold
    joints: Sequence[Predictions]

    @cached_property
    def records(self) -> list[Record]:
        """All of them."""
        return [self.lumped, self.free, *self.joints]


def growth(study: Study, scale: Scale) -> Growth:
    """At the bistable setting, from many starts."""
    one = scale.cut(Cell("omega_t", SETTINGS[0]).starts("free", [1])[0])
    asked_of = partings(one, scale.starts(STARTS))
    answers = [each for some in study.answers(asked_of, "planets: parting") for each in some]
    found = [answer for answer in answers if answer is not None]
    asked = len(answers)
    lumped = _first_parting("lumped", asked, found, [one.by_lumped for one in found])
    free = _first_parting("free", asked, found, [one.by_free for one in found])
    joints = [_predictions(found, joint) for joint in range(len(JOINTS))]
    text = [
        heading("2. Why planets that start alike part"),
        paragraph(_derivation()),
        figure(_figure(found), _caption()),
        table(_HEAD, map(_row, joints)),
        paragraph(_statement(lumped, free, joints)),
    ]
    return Growth("\n".join(text), lumped, free, joints)


def earliest(times: Sequence[float | None]) -> float | None:
    """Of those that happen."""
    return min((time for time in times if time is not None), default=None)


def _first_parting(
    along: str, asked: int, found: Sequence[Parted], courses: Sequence[Course]
) -> Foretold:
    told = [
        (pair, _strayed_before(one, pair[1]))
        for one, course in zip(found, courses, strict=True)
        if (pair := (earliest(course.parting_s), earliest(one.measured.parting_s))) != (None, None)
    ]
    errors = _errors([pair for pair, _ in told])
    predicted, measured = ([pair[k] for pair, _ in told] for k in (0, 1))
    return Foretold(
        along=along,
        asked=asked,
        diverged=asked - len(found),
        starts=len(told),
        courses_part=sum(time is not None for time in predicted),
        earliest_s=earliest(measured),
        latest_s=defined(extreme(measured, max)),
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
    levels = _levels(one.by_lumped, joint)
    if levels.size <= BINS_FOR_A_RATE:
        return float("nan")
    span = np.array(one.time_s)[BINS_FOR_A_RATE:] - np.array(one.time_s)[:-BINS_FOR_A_RATE]
    rates = np.log(10) * (levels[BINS_FOR_A_RATE:] - levels[:-BINS_FOR_A_RATE]) / span
    return float(np.nanmax(rates))


def _levels(course: Course, joint: int) -> np.ndarray:
    """log10 of the spread [m] in every bin, nan where undefined."""
    return np.array([np.nan if v is None else v for v in course.spread[joint]])


_HEAD = (
    "joint",
    "starts",
    "planets part in",
    "before the other joint's in",
    "median time [s]",
    "foretold along the lumped run in",
    "largest error",
    "foretold along the free run in",
    "largest error",
    "largest growth rate, lumped run [1/s]",
    "largest spread if no mesh ever parted [m]",
)


def _row(record: Predictions) -> tuple[str, ...]:
    return (
        record.joint,
        str(record.starts),
        str(record.parted),
        str(record.first),
        shown(record.median_s, ".4f"),
        str(record.lumped_right),
        percent(record.lumped_largest_error),
        str(record.free_right),
        percent(record.free_largest_error),
        shown(record.largest_growth_per_s, ".0f"),
        shown(record.pressed_largest_m, ".2g"),
    )


def _derivation() -> str:
    zeta, ring = SETTINGS[0]
    return (
        "Let planet n of a stage be δ_n from the mean of its stage, the δ_n adding up to 0:"
        " x_pr,n = x_pr + δ_n and, the sun's advance being one for all, x_sp,n = x_sp - δ_n. All"
        " terms of the energies that are linear in δ_n add up to 0 as well, so while they are small"
        " they feel nothing of the arm and the arm nothing of them:"
        " M_p δ'' + (d_sp + d_pr)/N δ' + (k_sp c_sp + k_pr c_pr) δ = 0, where c is 1 while a mesh"
        " is in contact on the motion that all planets share and 0 while it is apart. It is Hill's"
        " equation, its stiffness switched by contacts that come and go. It is integrated here"
        " along the run with lumped planets, started as the mean of the free ones, with the same"
        " Runge-Kutta stages; rounding sets a floor, a last place of x_pr in every step against the"
        f" damping. Under omega_t, zeta = {zeta:g}, ring rate {ring}, labelled reading, {STARTS}"
        f" starts; planets have parted once they are {1e6 * APART_M:g} µm apart."
    )


def _statement(lumped: Foretold, free: Foretold, joints: Sequence[Predictions]) -> str:
    left_out = f"{free.diverged} of {free.asked} starts are left out, because a run diverged."
    if not free.starts:
        return f"{left_out} In no start do planets part: what foretells it is undefined."
    parts = (_along_free(free), _along_lumped(lumped), _window(lumped), _cause(joints))
    return " ".join([left_out, *parts])


def _along_free(free: Foretold) -> str:
    limit = percent(PREDICTED, ".0f")
    shortest, longest = (
        shown(None if time is None else 1e3 * PREDICTED * time, ".0f")
        for time in (free.earliest_s, free.latest_s)
    )
    return (
        "Along the motion that the planets really shared, the mean of the free ones, the equation"
        f" foretells the first parting within {limit} in {free.right} of {free.starts} starts"
        f" (median error {percent(free.median_error, '.2g')}, largest"
        f" {percent(free.largest_error, '.2g')}). It is told from the free run itself, not ahead of"
        f" it; and the time counts from the start, so {limit} of it is {shortest} to {longest} ms,"
        " which a plainer predictor, such as the first loss of contact, might meet as well: none"
        " was tried."
    )


def _along_lumped(lumped: Foretold) -> str:
    return (
        "Along the lumped run, which knows nothing of free planets, it does so in"
        f" {lumped.right} of {lumped.starts} (median error"
        f" {percent(lumped.median_error, '.2g')}, largest"
        f" {percent(lumped.largest_error, '.2g')}): under omega_t the shared motion is itself"
        " sensitive, more so than the differences, and had left the lumped run by 1 µm before the"
        f" planets parted in {lumped.strayed} of them; of the others"
        f" {lumped.right_unless_strayed} of {lumped.starts - lumped.strayed} are foretold."
    )


def _window(lumped: Foretold) -> str:
    if lumped.always_parts:
        return "Which window of impacts parts the planets then differs, not that one does."
    return (
        f"Along the lumped run they should part in {lumped.courses_part} of"
        f" {lumped.asked - lumped.diverged} starts: whether a window of impacts parts them hangs on"
        " the start too."
    )


def _cause(joints: Sequence[Predictions]) -> str:
    """What grows without loss of contact; undefined unless known of every joint."""
    largest = [one.pressed_largest_m for one in joints]
    if not known(largest):
        return "How far they would part if no mesh ever did is undefined."
    stable = max(value for value in largest if value is not None)
    told = "If no mesh ever parted, the same equation would let differences grow up to"
    if stable >= APART_M:
        return f"{told} {stable:.2g} m: the varying stiffness alone could part the planets."
    return (
        f"{told} {stable:.2g} m at most: the varying stiffness alone does not do it, the loss of"
        " contact does. At this setting planets counted as one are a motion that is parametrically"
        " unstable while its teeth bounce."
    )


def _figure(found: Sequence[Parted]) -> str:
    drawing, grid = new_figure(len(JOINTS), 2, 2.4)
    for joint, (left, right) in enumerate(grid):
        left.set(title=f"{JOINTS[joint]}, first start", ylabel="log10 of the spread [m]")
        right.set(title=f"{JOINTS[joint]}, {len(found)} starts")
        if found:
            _draw_one(left, found[0], joint)
            _draw_all(right, found, joint)
        for axes in (left, right):
            axes.axhline(np.log10(APART_M), color="black", lw=0.8, ls="--")
            axes.set_ylim(LOWEST, HIGHEST)
            if not found:
                not_reached(axes)
    for axes in grid[-1]:
        axes.set_xlabel("time [s]")
    if found:
        legend(drawing, grid[0, 0], grid[0, 1])
    return to_svg(drawing)


def _draw_one(axes: Axes, one: Parted, joint: int) -> None:
    lines = (
        (one.measured, "measured", "-", 1.6),
        (one.by_lumped, "Hill, along the lumped run", "--", 1.1),
        (one.by_free, "Hill, along the free run", ":", 1.4),
        (one.pressed, "Hill, no mesh ever apart", "-.", 1.0),
    )
    for (course, name, style, width), colour in zip(lines, COLOURS, strict=False):
        axes.plot(one.time_s, _levels(course, joint), style, lw=width, color=colour, label=name)


def _draw_all(axes: Axes, found: Sequence[Parted], joint: int) -> None:
    """Median and range over the starts, measured and along the lumped run."""
    pairs = ([one.measured for one in found], [one.by_lumped for one in found])
    for courses, colour, style in zip(pairs, COLOURS, ("-", "--"), strict=False):
        levels = np.array([_levels(course, joint) for course in courses])
        low, high = levels.min(axis=0), levels.max(axis=0)
        axes.fill_between(found[0].time_s, low, high, color=colour, alpha=0.25)
        axes.plot(found[0].time_s, np.median(levels, axis=0), color=colour, ls=style)


def _caption() -> str:
    return (
        "How far the planets of a stage are apart, the largest in every 5 ms: measured in the run"
        " with free planets, and as Hill's equation has it from the same start, which knows no"
        " limit. Left: the first start; right: median (line) and range (band) over all. Dashed:"
        " 1 µm."
    )

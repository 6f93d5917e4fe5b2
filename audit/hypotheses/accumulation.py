"""Hypothesis H3: the error that accumulates in Fig. 15 is the rigid arm's own sensitivity."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import NamedTuple

import numpy as np

from crosscheck import signals
from crosscheck.audit.claims.rule import State, state
from crosscheck.audit.hypotheses.evidence.shaking import (
    BACKLASHES_M,
    DRIVES,
    LEARNT_S,
    NUDGE,
    REFERENCE_M,
    SMALL_S,
    ZETAS,
    Shaken,
    Shaking,
    running,
)
from crosscheck.audit.measures.shares import Share
from crosscheck.audit.measures.undefined import UNDEFINED, JsonObject
from crosscheck.audit.page.chapter import AuditChapter
from crosscheck.audit.page.columns import Columns, TableColumn
from crosscheck.audit.page.material import Material
from crosscheck.audit.page.text import html, text
from crosscheck.report.fragments import COLOURS
from crosscheck.report.plots.figures import legend, new_figure, to_svg

ID, TITLE = "accumulation", "Errors that accumulate back and forth (H3)"
DURATION_S = 2.0  # the paper's Fig. 15 does not say
WORDS = {"sqrt_time": "2000 sin(20π√t)", "time": "2000 sin(20πt)"}  # N m
_WORDS: dict[State | None, str] = {
    State.YES: "holds",
    State.NO: "does not hold",
    State.BISTABLE: "bistable",
    State.UNDEFINED: UNDEFINED,
}


class DriveVerdict(NamedTuple):
    """H3 for each drive, over all damping ratios: the state that all of them have, else None."""

    own: State | None
    linear: State | None
    ordered: State | None


def chapter(material: Material) -> AuditChapter:
    """Growth, prediction, linearity and order of the backlash error, for both drive laws."""
    scale, found = material.scale, shaken(material)
    verdicts = {drive: verdict([x for x in found if x.drive == drive]) for drive in DRIVES}
    first = {one.drive: one for one in reversed(found)}  # at the larger damping
    page = text(
        "hypotheses/accumulation",
        printed=first["sqrt_time"],
        even=first["time"],
        largest=largest,
        verdicts=verdicts,
        small_s=SMALL_S,
        learnt_s=LEARNT_S,
        nudge=NUDGE,
        starts=len(scale.seeds),
        picture=html(drawing(list(first.values())[::-1], WORDS)),
        summary=html(SUMMARY.html(found)),
        sizes=html(SIZES.html(_sizes(found))),
    )
    printed = verdicts["sqrt_time"]
    outcome = text("hypotheses/accumulation_outcome", own=printed.own, found=first["sqrt_time"])
    records = [_record(verdicts), *SUMMARY.json(found), *SIZES.json(_sizes(found))]
    return AuditChapter(ID, TITLE, page, records, outcome)


def shaken(material: Material) -> list[Shaken]:
    """Both drives at every damping ratio."""
    scale = material.scale
    asked = [
        Shaking(drive, zeta, scale.seeds, scale.seconds(DURATION_S))
        for drive in DRIVES
        for zeta in ZETAS
    ]
    return material.study.answers(asked, "H3, back and forth")


def verdict(found: Sequence[Shaken]) -> DriveVerdict:
    """Of one drive at every damping ratio."""
    return DriveVerdict(
        _common(one.own for one in found),
        _common(one.linear for one in found),
        _common(one.ordered for one in found),
    )


def _common(shares: Iterable[Share | None]) -> State | None:
    states = {state(share) for share in shares}
    return states.pop() if len(states) == 1 else None


def largest(found: Shaken, backlash_m: float = REFERENCE_M) -> float:
    """Largest error [rad] of a backlash in any start."""
    place = BACKLASHES_M.index(backlash_m)
    return max(start.largest_rad[place] for start in found.starts)


def _record(verdicts: dict[str, DriveVerdict]) -> JsonObject:
    return {
        "id": "H3",
        "verdict": _WORDS.get(verdicts["sqrt_time"].own, "depends on the damping"),
        "by_drive": {drive: dict(one._asdict()) for drive, one in verdicts.items()},
    }


def _span(name: str, factor: float = 1.0) -> Callable[[Shaken], tuple[float | None, ...]]:
    return lambda found: tuple(None if x is None else factor * x for x in found.span(name))


def _yes(share: Share | None) -> int | None:
    return None if share is None else share.yes


SUMMARY: Columns[Shaken] = Columns(
    lambda one: one.id,
    [
        TableColumn("drive", "drive [N m]", lambda one: WORDS[one.drive]),
        TableColumn("zeta", "ζ", lambda one: one.zeta, "g"),
        TableColumn("starts", "starts", lambda one: len(one.starts)),
        TableColumn("error_growth_per_s", "growth of the error [1/s]", _span("growth_per_s")),
        TableColumn(
            "rigid_growth_per_s", "of the nudged rigid arm", lambda one: one.rigid_growth_per_s
        ),
        TableColumn(
            "misfit_percent", "rigid arm's forecast misses by [%]", _span("misfit", 100), ".2g"
        ),
        TableColumn("own_sensitivity", "own sensitivity in", lambda one: _yes(one.own)),
        TableColumn(
            "nonlinearity_percent", "not linear in b by [%]", _span("nonlinearity", 100), ".2g"
        ),
        TableColumn("linear", "linear in", lambda one: _yes(one.linear)),
        TableColumn("ordered_before_percent", None, _span("ordered_before", 100)),
        TableColumn("ordered_percent", "later in order [% of 0.2 s]", _span("ordered_after", 100)),
        TableColumn("ordered", "ordered in", lambda one: _yes(one.ordered)),
        TableColumn("sensitivity_small", None, lambda one: one.sensitivity_small),
        TableColumn(
            "largest_sensitivity", "largest dθ₁/dθ₂(0)", lambda one: one.largest_sensitivity
        ),
        TableColumn("geared_minus_rigid_rad", None, lambda one: one.rest_rad),
    ],
)


class BacklashErrors(NamedTuple):
    """Errors [rad] of one backlash [um], least and largest of the starts."""

    found: Shaken
    b_um: float
    largest: tuple[float, float]
    end: tuple[float, float]


def _sizes(found: Sequence[Shaken]) -> list[BacklashErrors]:
    return [
        BacklashErrors(
            one,
            1e6 * b,
            _ends([start.largest_rad[place] for start in one.starts]),
            _ends([start.end_rad[place] for start in one.starts]),
        )
        for one in found
        for place, b in enumerate(BACKLASHES_M)
    ]


def _ends(values: Sequence[float]) -> tuple[float, float]:
    return min(values), max(values)


SIZES: Columns[BacklashErrors] = Columns(
    lambda size: f"{size.found.id}/{size.b_um:g}",
    [
        TableColumn("drive", "drive [N m]", lambda size: WORDS[size.found.drive]),
        TableColumn("zeta", "ζ", lambda size: size.found.zeta, "g"),
        TableColumn("b_um", "b [µm]", lambda size: size.b_um, "g"),
        TableColumn("largest_rad", "largest error of θ₁ [rad]", lambda size: size.largest),
        TableColumn("end_rad", "at 2 s [rad]", lambda size: size.end),
    ],
)


def drawing(found: Sequence[Shaken], titles: dict[str, str]) -> str:
    """Errors of the first start over time, and over b, a row for each; titles: by drive."""
    picture, grid = new_figure(len(found), 2, 2.9)
    for row, case in zip(grid, found, strict=True):
        time, predicted = (np.array(x, float) for x in (case.curves.time, case.curves.predicted))
        for b, values, colour in zip(BACKLASHES_M, case.curves.errors, COLOURS, strict=True):
            error = np.array(values)
            row[0].plot(time, running(error), color=colour, label=f"b {1e6 * b:g} µm")
            row[1].plot(time, error / b, color=colour, lw=0.9)
        row[0].plot(time, running(predicted), "k--", lw=1, label="rigid arm's own, b 50 µm")
        row[1].plot(time, predicted / REFERENCE_M, "k--", lw=1)
        own = np.array(case.curves.errors[BACKLASHES_M.index(REFERENCE_M)])
        bound = 1.3 * signals.amplitude(own[time <= SMALL_S[1]]) / REFERENCE_M
        row[0].set(yscale="log", ylim=(1e-10, 10), xlabel="time [s]", ylabel="|Δθ₁| [rad]",
                   title=f"T = {titles[case.drive]}, ζ = {case.zeta:g}")  # fmt: skip
        row[1].set(xlim=(0, SMALL_S[1]), ylim=(-bound, bound), xlabel="time [s]",
                   ylabel="Δθ₁ / b [rad/m]")  # fmt: skip
    legend(picture, grid[0, 0])
    return to_svg(picture)

"""Hypothesis H3: the error that accumulates in Fig. 15 is the rigid arm's own sensitivity."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from crosscheck import signals
from crosscheck.audit.claims.rule import State, state
from crosscheck.audit.hypotheses.evidence import shaking
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
    """The verdict on H3 for a drive: the state that it has at all damping ratios, else None."""

    own: State | None
    linear: State | None
    ordered: State | None


def chapter(material: Material) -> AuditChapter:
    """The chapter on growth, prediction, linearity and order of the backlash error, both drives."""
    found = shaken(material)
    sizes = _sizes(found)
    verdicts = {drive: verdict([x for x in found if x.drive == drive]) for drive in shaking.DRIVES}
    first = {one.drive: one for one in reversed(found)}  # at the larger damping
    own = verdicts["sqrt_time"].own
    page = text(
        "hypotheses/accumulation",
        printed=first["sqrt_time"],
        even=first["time"],
        largest=largest,
        verdicts=verdicts,
        shaking=shaking,
        starts=len(material.scale.seeds),
        picture=html(drawing(list(first.values())[::-1])),
        summary=SUMMARY.html(found),
        sizes=SIZES.html(sizes),
    )
    record: JsonObject = {
        "id": "H3",
        "verdict": _WORDS.get(own, "depends on the damping"),
        "by_drive": {drive: dict(one._asdict()) for drive, one in verdicts.items()},
    }
    outcome = text("hypotheses/accumulation_outcome", own=own, found=first["sqrt_time"])
    records = [record, *SUMMARY.json(found), *SIZES.json(sizes)]
    return AuditChapter(ID, TITLE, page, records, outcome)


def shaken(material: Material) -> list[shaking.Shaken]:
    """The results of both drives at every damping ratio."""
    scale = material.scale
    asked = [
        shaking.Shaking(drive, zeta, scale.seeds, scale.seconds(DURATION_S))
        for drive in shaking.DRIVES
        for zeta in shaking.ZETAS
    ]
    return material.study.answers(asked, "H3, back and forth")


def verdict(found: Sequence[shaking.Shaken]) -> DriveVerdict:
    """The verdict on one drive from its results at every damping ratio."""
    answers = ({state(getattr(one, name)) for one in found} for name in DriveVerdict._fields)
    return DriveVerdict(*(states.pop() if len(states) == 1 else None for states in answers))


def largest(found: shaking.Shaken, backlash_m: float = shaking.REFERENCE_M) -> float:
    """The largest error [rad] of a backlash in any start."""
    place = shaking.BACKLASHES_M.index(backlash_m)
    return max(start.largest_rad[place] for start in found.starts)


def _percent(name: str) -> Callable[[shaking.Shaken], tuple[float | None, ...]]:
    """A function from a result to the least and largest value of a share over the starts [%]."""
    return lambda found: tuple(None if x is None else 100 * x for x in found.span(name))


SUMMARY = Columns[shaking.Shaken](
    "{0.id}",
    [
        TableColumn("drive", "drive [N m]", lambda one: WORDS[one.drive]),
        TableColumn("zeta", "ζ", form="g"),
        TableColumn("starts", "starts", lambda one: len(one.starts)),
        TableColumn(
            "error_growth_per_s", "growth of the error [1/s]", lambda one: one.span("growth_per_s")
        ),
        TableColumn("rigid_growth_per_s", "of the nudged rigid arm"),
        TableColumn(
            "misfit_percent", "rigid arm's forecast misses by [%]", _percent("misfit"), ".2g"
        ),
        TableColumn("own_sensitivity", "own sensitivity in", "own.yes"),
        TableColumn(
            "nonlinearity_percent", "not linear in b by [%]", _percent("nonlinearity"), ".2g"
        ),
        TableColumn("linear", "linear in", "linear.yes"),
        TableColumn("ordered_before_percent", None, _percent("ordered_before")),
        TableColumn("ordered_percent", "later in order [% of 0.2 s]", _percent("ordered_after")),
        TableColumn("ordered", "ordered in", "ordered.yes"),
        TableColumn("sensitivity_small", None),
        TableColumn("largest_sensitivity", "largest dθ₁/dθ₂(0)"),
        TableColumn("geared_minus_rigid_rad", None, "rest_rad"),
    ],
)


class BacklashErrors(NamedTuple):
    """The errors [rad] of one backlash [um], least and largest of the starts."""

    found: shaking.Shaken
    b_um: float
    largest: tuple[float, float]
    end: tuple[float, float]


def _sizes(found: Sequence[shaking.Shaken]) -> list[BacklashErrors]:
    """The errors of every drive, damping ratio and backlash."""
    return [
        BacklashErrors(one, 1e6 * b, (min(most), max(most)), (min(last), max(last)))
        for one in found
        for b, most, last in zip(
            shaking.BACKLASHES_M,
            zip(*(start.largest_rad for start in one.starts), strict=True),
            zip(*(start.end_rad for start in one.starts), strict=True),
            strict=True,
        )
    ]


SIZES = Columns[BacklashErrors](
    "{0.found.id}/{0.b_um:g}",
    [
        TableColumn("drive", "drive [N m]", lambda size: WORDS[size.found.drive]),
        TableColumn("zeta", "ζ", "found.zeta", "g"),
        TableColumn("b_um", "b [µm]", form="g"),
        TableColumn("largest_rad", "largest error of θ₁ [rad]", "largest"),
        TableColumn("end_rad", "at 2 s [rad]", "end"),
    ],
)


def drawing(found: Sequence[shaking.Shaken]) -> str:
    """Errors of the first start over time, and over b, a row for each result, as svg."""
    picture, grid = new_figure(len(found), 2, 2.9)
    for row, case in zip(grid, found, strict=True):
        time, predicted = (np.array(x, float) for x in (case.curves.time, case.curves.predicted))
        for b, values, colour in zip(
            shaking.BACKLASHES_M, case.curves.errors, COLOURS, strict=True
        ):
            error = np.array(values)
            row[0].plot(time, shaking.running(error), color=colour, label=f"b {1e6 * b:g} µm")
            row[1].plot(time, error / b, color=colour, lw=0.9)
        row[0].plot(time, shaking.running(predicted), "k--", lw=1, label="rigid arm's own, b 50 µm")
        row[1].plot(time, predicted / shaking.REFERENCE_M, "k--", lw=1)
        own = np.array(case.curves.errors[shaking.BACKLASHES_M.index(shaking.REFERENCE_M)])
        bound = 1.3 * signals.amplitude(own[time <= shaking.SMALL_S[1]]) / shaking.REFERENCE_M
        row[0].set(yscale="log", ylim=(1e-10, 10), xlabel="time [s]", ylabel="|Δθ₁| [rad]",
                   title=f"T = {WORDS[case.drive]}, ζ = {case.zeta:g}")  # fmt: skip
        row[1].set(xlim=(0, shaking.SMALL_S[1]), ylim=(-bound, bound), xlabel="time [s]",
                   ylabel="Δθ₁ / b [rad/m]")  # fmt: skip
    legend(picture, grid[0, 0])
    return to_svg(picture)

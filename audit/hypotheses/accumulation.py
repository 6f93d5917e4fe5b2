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
from crosscheck.audit.page.context import AuditContext
from crosscheck.audit.page.text import render_template, to_markup
from crosscheck.report.fragments import COLOURS
from crosscheck.report.plots.figures import draw_legend, make_figure, to_svg

ID, TITLE = "accumulation", "Errors that accumulate back and forth (H3)"
DURATION_S = 2.0  # the paper's text does not say of Fig. 15
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


def build_chapter(context: AuditContext) -> AuditChapter:
    """The chapter on growth, prediction, linearity and order of the backlash error, both drives."""
    results = run_shaking(context)
    sizes = _error_ranges(results)
    verdicts = {
        drive: judge_drive([x for x in results if x.drive == drive]) for drive in shaking.DRIVES
    }
    first = {entry.drive: entry for entry in reversed(results)}  # at the larger damping
    sensitivity_state = verdicts["sqrt_time"].own
    page = render_template(
        "hypotheses/accumulation",
        printed=first["sqrt_time"],
        even=first["time"],
        largest=largest_error,
        verdicts=verdicts,
        shaking=shaking,
        starts=len(context.scale.seeds),
        picture=to_markup(draw_errors(list(first.values())[::-1])),
        summary=SUMMARY.html(results),
        sizes=SIZES.html(sizes),
    )
    record: JsonObject = {
        "id": "H3",
        "verdict": _WORDS.get(sensitivity_state, "depends on the damping"),
        "by_drive": {drive: dict(entry._asdict()) for drive, entry in verdicts.items()},
    }
    outcome = render_template(
        "hypotheses/accumulation_outcome", own=sensitivity_state, found=first["sqrt_time"]
    )
    records = [record, *SUMMARY.json(results), *SIZES.json(sizes)]
    return AuditChapter(ID, TITLE, page, records, outcome)


def run_shaking(context: AuditContext) -> list[shaking.ShakingResult]:
    """The results of both drives at every damping ratio."""
    scale = context.scale
    questions = [
        shaking.ShakingQuestion(drive, zeta, scale.seeds, scale.limit_duration(DURATION_S))
        for drive in shaking.DRIVES
        for zeta in shaking.ZETAS
    ]
    return context.study.answer_questions(questions, "H3, back and forth")


def judge_drive(results: Sequence[shaking.ShakingResult]) -> DriveVerdict:
    """The verdict on one drive from its results at every damping ratio."""
    answers = (
        {state(getattr(result, name)) for result in results} for name in DriveVerdict._fields
    )
    return DriveVerdict(*(states.pop() if len(states) == 1 else None for states in answers))


def largest_error(result: shaking.ShakingResult, backlash_m: float = shaking.REFERENCE_M) -> float:
    """The largest error [rad] of a backlash in any start."""
    place = shaking.BACKLASHES_M.index(backlash_m)
    return max(start.largest_rad[place] for start in result.starts)


def _percent_range(name: str) -> Callable[[shaking.ShakingResult], tuple[float | None, ...]]:
    """A function from a result to the least and largest value of a share over the starts [%]."""
    return lambda result: tuple(None if x is None else 100 * x for x in result.span(name))


SUMMARY = Columns[shaking.ShakingResult](
    "{0.id}",
    [
        TableColumn("drive", "drive [N m]", lambda row: WORDS[row.drive]),
        TableColumn("zeta", "ζ", form="g"),
        TableColumn("starts", "starts", lambda row: len(row.starts)),
        TableColumn(
            "error_growth_per_s", "growth of the error [1/s]", lambda row: row.span("growth_per_s")
        ),
        TableColumn("rigid_growth_per_s", "of the nudged rigid arm"),
        TableColumn(
            "misfit_percent", "rigid arm's forecast misses by [%]", _percent_range("misfit"), ".2g"
        ),
        TableColumn("own_sensitivity", "own sensitivity in", "own.yes"),
        TableColumn(
            "nonlinearity_percent", "not linear in b by [%]", _percent_range("nonlinearity"), ".2g"
        ),
        TableColumn("linear", "linear in", "linear.yes"),
        TableColumn("ordered_before_percent", None, _percent_range("ordered_before")),
        TableColumn(
            "ordered_percent", "later in order [% of 0.2 s]", _percent_range("ordered_after")
        ),
        TableColumn("ordered", "ordered in", "ordered.yes"),
        TableColumn("sensitivity_small", None),
        TableColumn("largest_sensitivity", "largest dθ₁/dθ₂(0)"),
        TableColumn("geared_minus_rigid_rad", None, "rest_rad"),
    ],
)


class BacklashErrorRange(NamedTuple):
    """The errors [rad] of one backlash [um], least and largest of the starts."""

    case: shaking.ShakingResult
    b_um: float
    largest: tuple[float, float]
    end: tuple[float, float]


def _error_ranges(results: Sequence[shaking.ShakingResult]) -> list[BacklashErrorRange]:
    """The errors of every drive, damping ratio and backlash."""
    return [
        BacklashErrorRange(result, 1e6 * b, (min(most), max(most)), (min(last), max(last)))
        for result in results
        for b, most, last in zip(
            shaking.BACKLASHES_M,
            zip(*(start.largest_rad for start in result.starts), strict=True),
            zip(*(start.end_rad for start in result.starts), strict=True),
            strict=True,
        )
    ]


SIZES = Columns[BacklashErrorRange](
    "{0.case.id}/{0.b_um:g}",
    [
        TableColumn("drive", "drive [N m]", lambda size: WORDS[size.case.drive]),
        TableColumn("zeta", "ζ", "case.zeta", "g"),
        TableColumn("b_um", "b [µm]", form="g"),
        TableColumn("largest_rad", "largest error of θ₁ [rad]", "largest"),
        TableColumn("end_rad", "at 2 s [rad]", "end"),
    ],
)


def draw_errors(results: Sequence[shaking.ShakingResult]) -> str:
    """Errors of the first start over time, and over b, a row for each result, as svg."""
    picture, grid = make_figure(len(results), 2, 2.9)
    for row, case in zip(grid, results, strict=True):
        time, predicted = (np.array(x, float) for x in (case.curves.time, case.curves.predicted))
        for b, values, colour in zip(
            shaking.BACKLASHES_M, case.curves.errors, COLOURS, strict=True
        ):
            error = np.array(values)
            row[0].plot(
                time, shaking.running_maximum(error), color=colour, label=f"b {1e6 * b:g} µm"
            )
            row[1].plot(time, error / b, color=colour, lw=0.9)
        row[0].plot(
            time, shaking.running_maximum(predicted), "k--", lw=1, label="rigid arm's own, b 50 µm"
        )
        row[1].plot(time, predicted / shaking.REFERENCE_M, "k--", lw=1)
        reference_error = np.array(
            case.curves.errors[shaking.BACKLASHES_M.index(shaking.REFERENCE_M)]
        )
        bound = (
            1.3
            * signals.amplitude(reference_error[time <= shaking.SMALL_S[1]])
            / shaking.REFERENCE_M
        )
        row[0].set(yscale="log", ylim=(1e-10, 10), xlabel="time [s]", ylabel="|Δθ₁| [rad]",
                   title=f"T = {WORDS[case.drive]}, ζ = {case.zeta:g}")  # fmt: skip
        row[1].set(xlim=(0, shaking.SMALL_S[1]), ylim=(-bound, bound), xlabel="time [s]",
                   ylabel="Δθ₁ / b [rad/m]")  # fmt: skip
    draw_legend(picture, grid[0, 0])
    return to_svg(picture)

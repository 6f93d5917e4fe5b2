"""Figures 10 to 14: PD control to 30 degrees."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from pydantic import JsonValue

from crosscheck import signals
from crosscheck.audit.experiments.cells import INTEGRAL, Cell
from crosscheck.audit.experiments.experiments import PD, SHORT_S
from crosscheck.audit.figures.plate import Drawing, Plate
from crosscheck.audit.figures.runs import (
    DERIVATIVE,
    GAINS,
    LOW_ZETA,
    PROPORTIONAL,
    ZETA,
    drawn,
    gain_run,
)
from crosscheck.audit.figures.shelf import Shelf
from crosscheck.audit.figures.views import Strip, conditions, law_figure
from crosscheck.audit.measures import events
from crosscheck.audit.measures.course import Course
from crosscheck.audit.measures.rigid import COUPLED, rigid_arm
from crosscheck.audit.measures.third import Third
from crosscheck.audit.measures.thresholds import SEVERE
from crosscheck.audit.page.columns import Columns, TableColumn
from crosscheck.audit.page.words import LAW_NAMES
from crosscheck.report.fragments import COLOURS
from crosscheck.report.plots.figures import new_figure, to_svg

TARGET_RAD = np.pi / 6
BANDS = (0.02, 0.01)
WHOLE_S, START_S = (0.0, 3.0), (0.0, 0.02)
SIDE_S, THIRD_S = (0.345, 0.385), (1.10, 1.11)  # a few periods of what happens there
RIGID_STYLES = {COUPLED: "--", "links": ":"}


class Gain(NamedTuple):
    """A joint's step with gains: overshoot over the step, when within each of BANDS for good."""

    proportional: float
    derivative: float
    joint: int
    overshoot: float
    within_s: tuple[float | None, ...]


GAIN_COLUMNS = Columns[Gain](
    lambda row: f"P {row.proportional:g} D {row.derivative:g} joint {row.joint}",
    (
        TableColumn("proportional", "P [N m/rad]", lambda row: row.proportional, "g"),
        TableColumn("derivative", "D [N m s/rad]", lambda row: row.derivative, "g"),
        TableColumn("joint", "joint", lambda row: row.joint),
        TableColumn("overshoot_percent", "overshoot [%]", lambda row: 100 * row.overshoot, ".1f"),
        TableColumn("within_2_s", "within 2 % from [s]", lambda row: row.within_s[0], ".2f"),
        TableColumn("within_1_s", "within 1 % from [s]", lambda row: row.within_s[1], ".2f"),
    ),
)


def figure_10(shelf: Shelf) -> Plate:
    """Joint angles for several gains."""
    gains = [*((p, GAINS[1]) for p in PROPORTIONAL), *((GAINS[0], d) for d in DERIVATIVE)]
    variants = {gain: gain_run(*gain, shelf.seed) for gain in gains}
    runs = shelf.courses(variants.values(), 10)
    by_gain = {gain: runs[variant] for gain, variant in variants.items()}
    rows = [row for gain, run in by_gain.items() for row in _steps(run, *gain)]
    caption = conditions(by_gain[GAINS], shelf.seed, "Other gains as in the legend.")
    return Plate(
        10,
        [Drawing(_gains_svg(by_gain), caption)],
        ZETA,
        shelf.seed,
        {"gains": list(GAIN_COLUMNS.json(rows))},
        {"gains": GAIN_COLUMNS.html(rows)},
    )


def _steps(run: Course, proportional: float, derivative: float) -> list[Gain]:
    return [
        Gain(
            proportional,
            derivative,
            joint,
            max(0.0, events.overshoot(angle, TARGET_RAD)),
            tuple(events.settling(run.time, angle, TARGET_RAD, band) for band in BANDS),
        )
        for joint, angle in enumerate(run.theta.T, start=1)
    ]


def _gains_svg(runs: Mapping[tuple[float, float], Course]) -> str:
    """(a), (b): P varies, shoulder and elbow; (c), (d): D varies."""
    figure, grid = new_figure(2, 2, 2.3)
    panels = iter("abcd")
    for varied, row in enumerate(grid):
        fixed = GAINS[1 - varied]
        chosen = {gain[varied]: run for gain, run in runs.items() if gain[1 - varied] == fixed}
        for joint, axes in enumerate(row):
            for (gain, run), colour in zip(chosen.items(), COLOURS, strict=False):
                degrees = np.degrees(run.theta[:, joint])
                axes.plot(run.time, degrees, color=colour, label=f"{'PD'[varied]} = {gain:g}")
            axes.axhline(np.degrees(TARGET_RAD), color="k", linewidth=0.6, linestyle=":")
            title = f"({next(panels)}) {('shoulder', 'elbow')[joint]}, {'DP'[varied]} = {fixed:g}"
            axes.set(xlabel="time [s]", ylabel="angle [deg]", title=title)
        row[0].legend(frameon=False, loc="lower right")
    return to_svg(figure)


def whole_run(shelf: Shelf, number: int, quantity: str, label: str, scale: float = 1.0) -> Plate:
    """A quantity over all of the PD run, and near the side change and the third fluctuation."""
    runs, bands = shelf.laws(number, PD, LOW_ZETA), shelf.bands(LOW_ZETA, number)
    strips = [
        Strip(label, quantity, WHOLE_S, scale, band=True),
        *(Strip(label, quantity, window, scale) for window in (SIDE_S, THIRD_S)),
    ]
    caption = conditions(runs[INTEGRAL], shelf.seed, "Grey: between all starts (shoulder).")
    brakes = signals.first_below(runs[INTEGRAL].time, runs[INTEGRAL].torque[:, 0], 0.0)
    drawing = Drawing(law_figure(runs, strips, bands), caption)
    return Plate(number, [drawing], LOW_ZETA, shelf.seed, {"brakes_s": brakes})


def figure_14(shelf: Shelf) -> Plate:
    """Shoulder acceleration in the first 1.2 s."""
    runs, bands = shelf.laws(14, PD, LOW_ZETA), shelf.bands(LOW_ZETA, 14)
    own = drawn(PD, Cell(INTEGRAL, LOW_ZETA), shelf.seed)
    levels = {level: rigid_arm(own, level) for level in RIGID_STYLES}
    found = shelf.courses(levels.values(), 14)
    rigid = {level: found[variant] for level, variant in levels.items()}

    def overlay(axes: Axes, window: tuple[float, float]) -> None:
        for level, arm in rigid.items():
            part = signals.window(arm.time, *window)
            values = arm.theta_ddot[part, 0]
            axes.plot(
                arm.time[part], values, RIGID_STYLES[level], color="k", label=f"rigid, {level}"
            )

    shoulder = {law: replace(run, theta_ddot=run.theta_ddot[:, :1]) for law, run in runs.items()}
    thirds = {law: Third.of(known[PD]) for law, known in shelf.known(LOW_ZETA).items()}
    severe: dict[str, JsonValue] = {  # of the starts that have a third fluctuation
        LAW_NAMES[law]: [int(one.of_branch(severe=True).sum()), one.sizes.size]
        for law, one in thirds.items()
    }
    strips = [
        Strip("θ_1'' [rad/s²]", "theta_ddot", window, band=window == (0.0, SHORT_S))
        for window in ((0.0, SHORT_S), START_S, SIDE_S, THIRD_S)
    ]
    caption = conditions(runs[INTEGRAL], shelf.seed, "Grey: between all starts.")
    drawing = Drawing(law_figure(shoulder, strips, bands, overlay), caption)
    return Plate(14, [drawing], LOW_ZETA, shelf.seed, {"limit": SEVERE, "severe": severe})

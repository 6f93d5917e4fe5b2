"""How figures are drawn: panels of curves in a grid; what a run's parameters are, in words."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import chain
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes

from crosscheck.audit.experiments.paper_conditions import LAWS
from crosscheck.audit.measures.run_signals import RunSignals
from crosscheck.audit.measures.stage import paper_stage
from crosscheck.audit.page.chapter import DRAWN_NAMES
from crosscheck.report.fragments import COLOURS
from crosscheck.report.plots.figures import (
    draw_legend,
    make_figure,
    mark_not_reached,
    set_log_scale,
    to_svg,
)
from crosscheck.signals import envelope

MICRO, KILO = 1e6, 1e-3
LAW_COLOURS = dict(zip(LAWS, (COLOURS[4], COLOURS[1], COLOURS[0]), strict=True))
SHADE = "#d9a400"  # of what is enlarged below
TICKS = 5  # along an axis of a third of the page's width


class Curve(NamedTuple):
    """A line of a panel, x and y (points,); without a label none in the legend; width [pt].

    bins: from two samples a bin on, the band from minima to maxima is drawn.
    """

    x: np.ndarray | Sequence[float]
    y: np.ndarray | Sequence[float]
    colour: str
    label: str | None = None
    style: str = "-"
    width: float | None = None
    bins: int | None = None


class Panel(NamedTuple):
    """One pair of axes: curves, and the arguments for Matplotlib's ``Axes.set``.

    shaded: parts of the x axis; log: with a logarithmic y axis, if anything is above zero.
    """

    curves: Sequence[Curve]
    settings: Mapping[str, object]
    shaded: Sequence[tuple[float, float]] = ()
    log: bool = False


def draw_panels(height: float, xlabel: str, *rows: Sequence[Panel], by_law: bool = False) -> str:
    """Rows of panels, each of this height [in], above one legend, as svg.

    by_law: a column for each of LAWS, and one y range for all panels of a row.
    """
    figure, grid = make_figure(len(rows), len(rows[0]), height)
    for axes, panel in zip(grid.flat, chain(*rows), strict=True):
        _draw_panel(axes, panel)
    for axes in grid[-1]:
        axes.set_xlabel(xlabel)
    if by_law:
        for axes, law in zip(grid[0], LAWS, strict=True):
            axes.set_title(DRAWN_NAMES[law])
        set_same_scale(grid)
    if len(grid[0, 0].get_legend_handles_labels()[1]) > 1:
        draw_legend(figure, *grid.flat)
    return to_svg(figure)


def _draw_panel(axes: Axes, panel: Panel) -> None:
    for x, y, colour, name, style, width, bins in panel.curves:
        if bins is not None and len(x) > 2 * bins:
            x, low, high = envelope(np.asarray(x), np.asarray(y), bins)
            axes.fill_between(x, low, high, label=name, color=colour, linewidth=0.6, alpha=0.75)
        else:
            axes.plot(x, y, style, color=colour, label=name, linewidth=width, markersize=3.5)
    for part in panel.shaded:
        axes.axvspan(*part, color=SHADE, alpha=0.35, linewidth=0)
    axes.set(**panel.settings)
    if "xticks" in panel.settings:
        axes.tick_params(axis="x", labelsize=7)
    else:
        axes.locator_params(axis="x", nbins=TICKS)
    if panel.log:
        set_log_scale(axes)
    elif not any(len(curve.x) for curve in panel.curves):
        mark_not_reached(axes)


def set_same_scale(grid: np.ndarray) -> None:
    """Give each row of axes, (rows, columns), one y range; rows of different scales are kept."""
    for row in grid:
        if len({axes.get_yscale() for axes in row}) > 1:
            continue
        limits = np.array([axes.get_ylim() for axes in row])
        for axes in row:
            axes.set_ylim(limits[:, 0].min(), limits[:, 1].max())


def describe_run(run: RunSignals, seed: int, more: str = "") -> str:
    """The parameter values of a geared run in words, for the line under a figure."""
    stage = paper_stage(run.case.arm)
    driven = [
        f"{key} {value:.6g}" if isinstance(value, float) else f"{key} {value}"
        for key, value in run.case.scenario.drive.model_dump().items()
    ]
    parts = [
        f"Arm {run.case.arm.name}",
        f"b {MICRO * stage.backlash_m:g} µm, E {MICRO * stage.tooth_error_m:g} µm",
        f"k_m {stage.mesh_stiffness_N_per_m:g} N/m"
        f", k_a {stage.mesh_stiffness_amplitude_N_per_m:g} N/m",
        f"zeta {stage.damping_ratio:g}, planets {run.case.switches.planets}",
        f"start {seed}",
        f"drive: {', '.join(driven)}",
    ]
    return f"{'; '.join(parts)}.{' ' + more if more else ''}"

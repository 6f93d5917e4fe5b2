"""How the figures are drawn: strips in time under every law, bands, quantiles over a size."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes

from crosscheck import signals
from crosscheck.audit.experiments.bands import Between
from crosscheck.audit.experiments.cells import LAWS, Law
from crosscheck.audit.measures.course import Course
from crosscheck.audit.measures.shares import Share
from crosscheck.audit.measures.stage import paper_stage
from crosscheck.audit.page.words import LAW_NAMES
from crosscheck.report.fragments import COLOURS
from crosscheck.report.plots.figures import BINS, legend, new_figure, not_reached, to_svg
from crosscheck.signals import envelope

MICRO, KILO = 1e6, 1e-3
SHADE = "#d9a400"  # of what is enlarged below
ALL_STARTS = "#b8c4d0"
LAW_COLOURS = dict(zip(LAWS, (COLOURS[4], COLOURS[1], COLOURS[0]), strict=True))
Overlay = Callable[[Axes, tuple[float, float]], None]


class Curve(NamedTuple):
    """A line of a panel, x and y (points,); without a label none in the legend; width [pt]."""

    x: np.ndarray | Sequence[float]
    y: np.ndarray
    colour: str
    label: str | None = None
    style: str = "-"
    width: float | None = None


class Panel(NamedTuple):
    """Curves in one pair of axes, with what Matplotlib's ``Axes.set`` is to be told."""

    curves: Sequence[Curve]
    settings: Mapping[str, object]


def panels(height: float, *shown: Panel) -> str:
    """Panels side by side, of this height [in], above one legend."""
    figure, grid = new_figure(1, len(shown), height)
    for axes, (curves, settings) in zip(grid[0], shown, strict=True):
        for x, y, colour, label, style, width in curves:
            axes.plot(x, y, style, color=colour, label=label, linewidth=width)
        axes.set(**settings)
    legend(figure, *grid[0])
    return to_svg(figure)


class Strip(NamedTuple):
    """One row of a figure over the laws: a quantity of a Course in a window [s].

    scale: its unit in SI units, inverse; band: whether all starts are drawn behind; elbow: whether
    the outer joint is drawn, too.
    """

    label: str
    quantity: str
    window: tuple[float, float]
    scale: float = 1.0
    band: bool = False
    elbow: bool = True


def law_figure(
    runs: Mapping[Law, Course],
    strips: Sequence[Strip],
    bands: Mapping[Law, Between] | None = None,
    overlay: Overlay | None = None,
) -> str:
    """Strips below each other, laws side by side, one scale per row; enlarged parts are shaded."""
    figure, grid = new_figure(len(strips), len(runs), 1.9)
    for column, (law, run) in enumerate(runs.items()):
        grid[0, column].set_title(LAW_NAMES[law])
        for axes, strip in zip(grid[:, column], strips, strict=True):
            if bands is not None and strip.band:
                between = bands[law]
                low, high = (strip.scale * np.array(x) for x in between.bands[strip.quantity])
                name = f"between all {between.starts} starts"
                axes.fill_between(
                    between.time, low, high, color=ALL_STARTS, linewidth=0.4, label=name
                )
            draw_strip(axes, run, strip)
            axes.locator_params(axis="x", nbins=5)
            if overlay is not None:
                overlay(axes, strip.window)
        for zoom in strips[1:]:
            grid[0, column].axvspan(*zoom.window, color=SHADE, alpha=0.35, linewidth=0)
        grid[-1, column].set_xlabel("time [s]")
    same_scale(grid)
    if len(grid[0, 0].get_legend_handles_labels()[1]) > 1:
        legend(figure, grid[0, 0])
    return to_svg(figure)


def draw_strip(axes: Axes, run: Course, strip: Strip) -> None:
    """Every column of the strip's quantity, (times,) or (times, joints)."""
    part = signals.window(run.time, *strip.window)
    columns = strip.scale * np.atleast_2d(getattr(run, strip.quantity).T)
    columns = columns if strip.elbow else columns[:1]
    for joint, (column, colour) in enumerate(zip(columns, COLOURS, strict=False), start=1):
        name = f"joint {joint}, one start" if len(columns) > 1 else "shoulder, one start"
        line(axes, run.time[part], column[part], name, colour)
    axes.set(ylabel=strip.label, xlim=strip.window)
    if not run.time[part].size:
        not_reached(axes)


def line(
    axes: Axes, time: np.ndarray, values: np.ndarray, label: str, colour: str, bins: int = BINS
) -> None:
    """A line, or from two samples a bin on the band from minima to maxima."""
    if time.size <= 2 * bins:
        axes.plot(time, values, label=label, color=colour, linewidth=1.0)
        return
    centres, low, high = envelope(time, values, bins)
    axes.fill_between(centres, low, high, label=label, color=colour, linewidth=0.6, alpha=0.75)


def same_scale(grid: np.ndarray) -> None:
    """One y range per row of axes, (rows, columns); a row of unlike scales is left as it is."""
    for row in grid:
        if len({axes.get_yscale() for axes in row}) > 1:
            continue
        limits = np.array([axes.get_ylim() for axes in row])
        for axes in row:
            axes.set_ylim(limits[:, 0].min(), limits[:, 1].max())


def dots(axes: Axes, found: Mapping[Law, Mapping[float, np.ndarray]], scale: float = 1.0) -> None:
    """Every start's number against a size, the laws beside each other; the size's axis by rank."""
    sizes = list(next(iter(found.values())))
    for place, (law, by_size) in enumerate(found.items()):
        colour, name = LAW_COLOURS[law], LAW_NAMES[law]
        for at, size in enumerate(sizes):
            values = scale * np.sort(by_size[size][np.isfinite(by_size[size])])
            x = at + 0.27 * (place - 1) + np.linspace(-0.1, 0.1, values.size)
            axes.plot(x, values, ".", ms=3.5, color=colour, label=None if at else name)
    axes.set_xticks(range(len(sizes)), [f"{size:g}" for size in sizes], fontsize=7)


def conditions(run: Course, seed: int, more: str = "") -> str:
    """The parameter values of a geared run, for the line under a figure."""
    stage = paper_stage(run.case.arm)
    drive = run.case.scenario.drive.model_dump()
    parts = [
        f"Arm {run.case.arm.name}",
        f"b {MICRO * stage.backlash_m:g} µm, E {MICRO * stage.tooth_error_m:g} µm",
        f"k_m {stage.mesh_stiffness_N_per_m:g} N/m"
        f", k_a {stage.mesh_stiffness_amplitude_N_per_m:g} N/m",
        f"zeta {stage.damping_ratio:g}, planets {run.case.switches.planets}",
        f"start {seed}",
        f"drive: {', '.join(f'{key} {_short(value)}' for key, value in drive.items())}",
    ]
    return f"{'; '.join(parts)}.{' ' + more if more else ''}"


def _short(value: object) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def severe_over_zeta(found: Mapping[Law, Mapping[float, Share | None]]) -> str:
    """Shares of starts against the damping ratio, with their 95 % intervals, the laws in turn."""
    figure, grid = new_figure(1, 1, 2.9)
    axes = grid[0, 0]
    for place, (law, by_zeta) in enumerate(found.items()):
        shares = [(zeta, share) for zeta, share in by_zeta.items() if share is not None]
        zeta = np.array([one for one, _ in shares]) * (1 + 0.03 * (place - 1))
        value = np.array([share.value for _, share in shares])
        ends = np.array([share.interval for _, share in shares]).reshape(-1, 2).T
        label, colour = LAW_NAMES[law], LAW_COLOURS[law]
        axes.errorbar(
            zeta, value, np.abs(ends - value), fmt="o-", label=label, color=colour, ms=4, lw=1.0
        )
    axes.set(xscale="log", xlabel="damping ratio ζ [1]", ylabel="share of starts [1]")
    axes.set_ylim(-0.05, 1.05)
    ticks = sorted({zeta for by_zeta in found.values() for zeta in by_zeta})
    axes.set_xticks(ticks, [f"{zeta:g}" for zeta in ticks])
    axes.minorticks_off()
    legend(figure, axes)
    return to_svg(figure)

"""Figures of the report, as SVG text."""

from __future__ import annotations

import io
import itertools
import re
from collections.abc import Mapping
from contextlib import AbstractContextManager

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure
from matplotlib.ticker import LogFormatter

from crosscheck.report.fragments import COLOURS
from crosscheck.report.plots.signals import first_planet
from crosscheck.signals import envelope

BINS = 600  # bins over half the page's width: more than two for every point of it
# Letters that fit in a row; width of an entry's line, in letters.
LEGEND_LETTERS, KEY_LETTERS = 120, 9
MICRO, KILO = 1e6, 1e-3
SVG_DPI = 72  # a unit of SVG is a point
NOT_REACHED = "the run ends before"


def _style() -> AbstractContextManager[None]:
    return mpl.rc_context(
        {
            "svg.hashsalt": "geararm-crosscheck",  # identical inputs, identical file
            "font.size": 9,
            "axes.grid": True,
            "grid.alpha": 0.25,
            "axes.spines.top": False,
            "axes.spines.right": False,
            "lines.linewidth": 1.2,
        }
    )


def to_svg(figure: Figure) -> str:
    """The figure as an <svg> element."""
    stream = io.StringIO()
    with _style():
        _place_axes(figure)
        figure.savefig(stream, format="svg", metadata={"Date": None})
    text = stream.getvalue()
    return _IMAGE_ID.sub(r"\1", text[text.index("<svg") :])


def _place_axes(figure: Figure) -> None:
    """Lay the axes out for SVG here: ``savefig`` would draw the whole figure once more."""
    engine, dpi = figure.get_layout_engine(), figure.dpi
    if engine is not None:
        FigureCanvasSVG(figure)
        figure.dpi = SVG_DPI
        engine.execute(figure)
        figure.set_layout_engine(None)
        figure.dpi = dpi


def fix_links(html: str) -> str:
    """The page with unique ids in its drawings, and without links to missing places.

    Ids of the n-th drawing begin with its number; a link that leads nowhere becomes plain text.
    """
    numbers = itertools.count(1)

    def rename_ids(svg: re.Match[str]) -> str:
        return _ID.sub(rf"\1s{next(numbers)}-", svg[0])

    there = set(re.findall(r'\bid="([^"]+)"', html))
    return _LINK.sub(lambda link: link[0 if link[1] in there else 2], _SVG.sub(rename_ids, html))


_IMAGE_ID = re.compile(r'(<image\b[^>]*?) id="[^"]*"')  # equal images get equal ids
_SVG = re.compile(r"<svg\b.*?</svg>", re.DOTALL)
_LINK = re.compile(r'<a href="#([^"]+)">(.*?)</a>')
_ID = re.compile(r'(\bid="|xlink:href="#|url\(#)')


def make_figure(rows: int, columns: int = 2, height: float = 2.1) -> tuple[Figure, np.ndarray]:
    """A figure of the report's width with a grid of axes, (rows, columns)."""
    with _style():
        figure = Figure(figsize=(9.2, height * rows), layout="constrained")
        return figure, figure.subplots(rows, columns, squeeze=False)


def draw_legend(figure: Figure, *axes: Axes) -> None:
    """Draw one legend of all axes' lines below the drawing, where no curve can be."""
    entries: dict[str, Artist] = {}
    for axis in axes:
        for artist, name in zip(*axis.get_legend_handles_labels(), strict=True):
            entries.setdefault(name, artist)
    columns = max(1, min(len(entries), LEGEND_LETTERS // (max(map(len, entries)) + KEY_LETTERS)))
    figure.legend(
        entries.values(), entries, loc="outside lower center", ncols=columns, frameon=False
    )


def draw(axes: Axes, time: np.ndarray, values: np.ndarray, label: str, colour: str) -> None:
    """Draw a line, or a min-max band where there are more samples than the page can show."""
    if time.size <= 2 * BINS:
        axes.plot(time, values, label=label, color=colour)
        return
    centres, low, high = envelope(time, values, BINS)
    axes.fill_between(centres, low, high, label=label, color=colour, linewidth=0.6, alpha=0.75)


def mark_not_reached(axes: Axes) -> None:
    """Write in place of curves that no run reaches this part."""
    axes.text(0.5, 0.5, NOT_REACHED, ha="center", va="center", transform=axes.transAxes)


def set_log_scale(axes: Axes) -> None:
    """Set a logarithmic scale if a line has values above zero, else mark the axes as empty."""
    if any((np.asarray(line.get_ydata(), dtype=float) > 0).any() for line in axes.lines):
        axes.set_yscale("log")
    else:
        mark_not_reached(axes)


def _set_power_labels(axes: Axes) -> None:
    """Set a log scale labelled as 1e-05: typeset powers take a third of a drawing's time."""
    axes.set_yscale("log")
    axes.yaxis.set_major_formatter(LogFormatter())


def draw_run_comparison(reference_run: xr.Dataset, other_run: xr.Dataset) -> str:
    """Two models over one run: their signals on the left, the difference on the right.

    An arm without gears has no meshes, so its runs record and show angles and accelerations alone.
    """
    quantities = (
        ("theta", 1.0, "joint angle [rad]", "difference [rad]"),
        ("theta_ddot", 1.0, "acceleration [rad/s²]", "difference [rad/s²]"),
        ("x_sp", MICRO, "x_sp, planet 1 [µm]", "difference [m]"),
        ("F_sp", KILO, "F_sp, planet 1 [kN]", "difference [N]"),
    )
    rows = [row for row in quantities if row[0] in reference_run]
    figure, grid = make_figure(len(rows))
    for axes, (quantity, scale, label, difference_label) in zip(grid, rows, strict=True):
        values, others = (first_planet(run[quantity]) for run in (reference_run, other_run))
        time = reference_run["time"].values
        for joint, colour in zip(range(values.shape[1]), COLOURS, strict=False):
            draw(axes[0], time, scale * values[:, joint], f"joint {joint + 1}", colour)
            gap = np.maximum(np.abs(values[:, joint] - others[:, joint]), 1e-20)
            draw(axes[1], time, gap, f"joint {joint + 1}", colour)
        axes[0].set_ylabel(label)
        axes[1].set(ylabel=difference_label)
        _set_power_labels(axes[1])
    draw_legend(figure, grid[0, 0])
    for axes in grid[-1]:
        axes.set_xlabel("time [s]")
    return to_svg(figure)


def draw_level_deviations(geared: xr.Dataset, rigid: Mapping[str, xr.Dataset]) -> str:
    """Deviation of every rigid level from the geared arm, joint by joint."""
    figure, grid = make_figure(1, geared["joint"].size, 2.6)
    for joint, axes in enumerate(grid[0]):
        for colour, (level, run) in zip(COLOURS, rigid.items(), strict=False):
            gap = run["theta"].values[:, joint] - geared["theta"].values[:, joint]
            gap, time = np.maximum(np.abs(gap), 1e-12), geared["time"].values
            axes.plot(time, gap, color=colour, label=level)
        axes.set(xlabel="time [s]", ylabel="|deviation| [rad]", title=f"joint {joint + 1}")
        _set_power_labels(axes)
    draw_legend(figure, grid[0, 0])
    return to_svg(figure)

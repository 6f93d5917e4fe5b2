"""Figures of the report, as SVG text."""

from __future__ import annotations

import io
from collections.abc import Mapping
from typing import Any

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from crosscheck.envelope import envelope

BINS = 900
STYLE: dict[Any, Any] = {
    "svg.hashsalt": "geararm-crosscheck",  # identical inputs, identical file
    "font.size": 9,
    "axes.grid": True,
    "grid.alpha": 0.25,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "lines.linewidth": 1.2,
}
MICRO, KILO = 1e6, 1e-3


def to_svg(figure: Figure) -> str:
    """The figure as an <svg> element."""
    stream = io.StringIO()
    with mpl.rc_context(STYLE):
        figure.savefig(stream, format="svg", metadata={"Date": None})
    text = stream.getvalue()
    return text[text.index("<svg") :]


def new_figure(rows: int, columns: int = 2, height: float = 2.1) -> tuple[Figure, np.ndarray]:
    """A figure of the report's width with a grid of axes, (rows, columns)."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(9.2, height * rows), layout="constrained")
        return figure, figure.subplots(rows, columns, squeeze=False)


def draw(axes: Axes, time: np.ndarray, values: np.ndarray, label: str, colour: str) -> None:
    """A line, or a min-max band where there are more samples than the page can show."""
    if time.size <= 2 * BINS:
        axes.plot(time, values, label=label, color=colour)
        return
    centres, low, high = envelope(time, values, BINS)
    axes.fill_between(centres, low, high, label=label, color=colour, linewidth=0.6, alpha=0.75)


def run_figure(ours: xr.Dataset, theirs: xr.Dataset) -> str:
    """Two models over one run: what they did on the left, their difference on the right."""
    figure, grid = new_figure(4)
    rows = (
        ("theta", 1.0, "joint angle [rad]", "difference [rad]"),
        ("theta_ddot", 1.0, "acceleration [rad/s²]", "difference [rad/s²]"),
        ("x_sp", MICRO, "x_sp, planet 1 [µm]", "difference [m]"),
        ("F_sp", KILO, "F_sp, planet 1 [kN]", "difference [N]"),
    )
    for axes, (quantity, scale, label, difference_label) in zip(grid, rows, strict=True):
        one, other = (_first_planet(run[quantity]) for run in (ours, theirs))
        time = ours["time"].values
        for joint, colour in zip(range(one.shape[1]), _colours(), strict=False):
            draw(axes[0], time, scale * one[:, joint], f"joint {joint + 1}", colour)
            gap = np.maximum(np.abs(one[:, joint] - other[:, joint]), 1e-20)
            draw(axes[1], time, gap, f"joint {joint + 1}", colour)
        axes[0].set_ylabel(label)
        axes[1].set(ylabel=difference_label, yscale="log")
    grid[0, 0].legend(loc="best", frameon=False)
    for axes in grid[-1]:
        axes.set_xlabel("time [s]")
    return to_svg(figure)


def level_figure(geared: xr.Dataset, rigid: Mapping[str, xr.Dataset]) -> str:
    """Deviation of every rigid level from the geared arm, joint by joint."""
    joints = geared["joint"].size
    figure, grid = new_figure(1, joints, 2.6)
    for joint, axes in enumerate(grid[0]):
        for colour, (level, run) in zip(_colours(), rigid.items(), strict=False):
            gap = run["theta"].values[:, joint] - geared["theta"].values[:, joint]
            axes.plot(
                geared["time"].values, np.maximum(np.abs(gap), 1e-12), color=colour, label=level
            )
        axes.set(
            yscale="log", xlabel="time [s]", ylabel="|deviation| [rad]", title=f"joint {joint + 1}"
        )
    grid[0, 0].legend(frameon=False)
    return to_svg(figure)


def _first_planet(values: xr.DataArray) -> np.ndarray:
    return (values.isel(planet=0) if "planet" in values.dims else values).values


def _colours() -> list[str]:
    return ["#1f5fa8", "#d1702c", "#2f8f5b", "#8a4fb0", "#b03050", "#5a6b7a", "#a08a20"]

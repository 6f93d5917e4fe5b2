"""Drawings of the chapter on the planets."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes

from crosscheck.audit.experiments.cells import LAWS, READINGS
from crosscheck.audit.measures.third import APART_M, Third
from crosscheck.audit.measures.thresholds import SEVERE
from crosscheck.audit.phase.page.views import law_name
from crosscheck.audit.planets.freed import Freed
from crosscheck.audit.planets.growth import JOINTS, levels
from crosscheck.audit.planets.parting import Parted
from crosscheck.report.figures import legend, new_figure, not_reached, to_svg
from crosscheck.report.fragments import COLOURS

LIMITS = {"omega_t": (1.0, 2e3), "angle": (1e-5, 1e3)}  # rad/s^2, by phase law
SHIFTS = (-0.17, 0.17)  # of a damping ratio: lumped, free
LOWEST, HIGHEST = -20.5, -2.0  # log10 of metres: what is drawn


def sizes(found: Sequence[Freed]) -> str:
    """A dot for every start: a row for every law, a column for every reading."""
    arms = [arm for arm in READINGS if any(one.cell.arm == arm for one in found)]
    drawing, grid = new_figure(len(LAWS), len(arms), 2.1)
    for (row, column), axes in np.ndenumerate(grid):
        law, arm = LAWS[row], arms[column]
        chosen = [one for one in found if (one.cell.law, one.cell.arm) == (law, arm)]
        _panel(axes, chosen, *LIMITS[law.phase])
        axes.set_title(f"{READINGS[arm]}, {law_name(law)}", fontsize=8)
    for axes in grid[:, 0]:
        axes.set_ylabel("size [rad/s²]")
    for axes in grid[-1]:
        axes.set_xlabel("ζ")
    legend(drawing, grid[0, 0])
    return to_svg(drawing)


def _panel(axes: Axes, found: Sequence[Freed], least: float, most: float) -> None:
    for place, one in enumerate(found):
        pairs = zip(SHIFTS, (one.lumped, one.free), COLOURS, ("lumped", "free"), strict=False)
        for shift, third, colour, name in pairs:
            label = f"planets {name}" if place == 0 else None
            _dots(axes, place + shift, third, (least, most), colour, label)
    axes.axhline(SEVERE, color="black", lw=0.8, ls="--")
    axes.set_xticks(range(len(found)), [f"{one.cell.zeta:g}" for one in found], fontsize=6.5)
    axes.set_ylim(least, most)
    axes.set_yscale("log")


def _dots(
    axes: Axes,
    at: float,
    third: Third,
    limits: tuple[float, float],
    colour: str,
    label: str | None,
) -> None:
    across = at + np.linspace(-0.12, 0.12, third.sizes.size)
    axes.plot(across, np.clip(third.sizes, *limits), ".", color=colour, markersize=2.5, label=label)


def parting(found: Sequence[Parted]) -> str:
    """The spread of a stage's planets, measured and as Hill's equation has it."""
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
        axes.plot(one.time_s, levels(course, joint), style, lw=width, color=colour, label=name)


def _draw_all(axes: Axes, found: Sequence[Parted], joint: int) -> None:
    """Median and range over the starts, measured and along the lumped run."""
    pairs = ([one.measured for one in found], [one.by_lumped for one in found])
    for courses, colour, style in zip(pairs, COLOURS, ("-", "--"), strict=False):
        every = np.array([levels(course, joint) for course in courses])
        low, high = every.min(axis=0), every.max(axis=0)
        axes.fill_between(found[0].time_s, low, high, color=colour, alpha=0.25)
        axes.plot(found[0].time_s, np.median(every, axis=0), color=colour, ls=style)

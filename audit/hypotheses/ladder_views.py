"""The ladder drawn: what every baseline leaves, signed contributions, their sizes over decades."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes

from crosscheck.audit.claims.rule import Limits
from crosscheck.audit.experiments.cells import READINGS
from crosscheck.audit.hypotheses.evidence.attribution import IN_UNIT_OF_CLAIM, RigidResidual
from crosscheck.audit.hypotheses.evidence.rungs import QUANTITIES, Ladder
from crosscheck.audit.hypotheses.words import LEVELS, RUNGS, SYMBOLS
from crosscheck.registry import RIGID_LEVELS
from crosscheck.report.figures import legend, new_figure, to_svg
from crosscheck.report.fragments import COLOURS

MILLI = 1e3
_SMALLEST = 1e-13  # a contribution of rounding size still gets a mark


def baselines(found: Sequence[RigidResidual], limits: Mapping[str, Limits]) -> str:
    """The size of what every baseline leaves, beside what the paper says; limits: by quantity."""
    figure, grid = new_figure(1, len(QUANTITIES), 2.6)
    for axes, (name, factor) in zip(grid[0], IN_UNIT_OF_CLAIM.items(), strict=True):
        axes.axvspan(limits[name].low, limits[name].high, color="#999999", alpha=0.3, label="paper")
        for arm, marker, colour in zip(READINGS, "os", COLOURS, strict=False):
            mine = [one for one in found if one.arm == arm]
            sizes = [factor * abs(one.found[name].total) for one in mine]
            rows = [RIGID_LEVELS.index(one.level) for one in mine]
            axes.plot(sizes, rows, marker, color=colour, ms=5, label=READINGS[arm])
        axes.set(xscale="log", xlabel=f"left of {SYMBOLS[name]} [1]", yticks=[])
        axes.set_ylim(len(RIGID_LEVELS) - 0.5, -0.5)
    grid[0, 0].set_yticks(range(len(RIGID_LEVELS)), [LEVELS[level] for level in RIGID_LEVELS])
    legend(figure, grid[0, 0])
    return to_svg(figure)


def waterfall(ladders: list[Ladder]) -> str:
    """Above, the first order's contributions stacked; below, the sizes of every order's.

    Each column at the time of its own largest deviation.
    """
    figure, grid = new_figure(2, len(QUANTITIES), 3.0)
    names = ladders[0].names
    for quantity, (name, unit) in enumerate(QUANTITIES.items()):
        index = ladders[0].largest(quantity)
        _stack(grid[0, quantity], MILLI * ladders[0].fine[:, index, quantity])
        grid[0, quantity].set(
            xlabel=f"{SYMBOLS[name]} [m{unit}]",
            title=f"at t = {ladders[0].time[index]:.3f} s, order A",
            yticks=[],
        )
        for ladder, marker, colour in zip(ladders, "os", COLOURS, strict=False):
            _sizes(grid[1, quantity], ladder, names, quantity, marker, colour)
        grid[1, quantity].set(xlabel=f"|contribution to {SYMBOLS[name]}| [{unit}]", yticks=[])
    for axes in grid[:, 0]:
        axes.set_yticks(range(len(names)), [RUNGS[name] for name in names])
    legend(figure, grid[1, 0])
    return to_svg(figure)


def _stack(axes: Axes, steps: np.ndarray) -> None:
    """Bars, each from where the one above it ended; the total as a line."""
    rows = np.arange(steps.size)
    before = np.cumsum(steps) - steps
    axes.barh(rows, steps, left=before, color=[COLOURS[0] if s >= 0 else COLOURS[1] for s in steps])
    axes.vlines(np.cumsum(steps), rows - 0.4, rows + 1.4, color="k", lw=0.6)
    axes.set_ylim(steps.size - 0.4, -0.6)


def _sizes(
    axes: Axes, ladder: Ladder, names: tuple[str, ...], quantity: int, marker: str, colour: str
) -> None:
    """Each rung's magnitude as a mark, its numerical uncertainty as a grey cross."""
    index = ladder.largest(quantity)
    rows = [names.index(name) for name in ladder.names]
    size = np.maximum(np.abs(ladder.fine[:, index, quantity]), _SMALLEST)
    doubt = np.maximum(ladder.uncertainty[:, index, quantity], _SMALLEST)
    axes.plot(size, rows, marker, color=colour, label=f"order {ladder.order}", ms=4)
    axes.plot(doubt, rows, "x", color="#999999", ms=3, label="numerical uncertainty")
    axes.set(xscale="log", ylim=(len(names) - 0.4, -0.6))

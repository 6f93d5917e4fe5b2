"""The ladder drawn: a waterfall of signed contributions, and their sizes over many decades."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes

from crosscheck.paper.hypotheses.ladder_rungs import LABELS, QUANTITIES, Ladder
from crosscheck.report.figures import legend, new_figure, to_svg
from crosscheck.report.fragments import COLOURS

MILLI = 1e3
SYMBOLS = {"theta_1": "θ₁", "theta_2": "θ₂", "tip": "tip"}
_SMALLEST = 1e-13  # a contribution of rounding size still gets a mark


def waterfall(ladders: list[Ladder]) -> str:
    """Above, the first order's contributions stacked; below, the sizes of every order's.

    Each column at the time of its own largest deviation.
    """
    figure, grid = new_figure(2, len(QUANTITIES), 3.0)
    names = ladders[0].order
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
        axes.set_yticks(range(len(names)), [LABELS[name] for name in names])
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
    rows = [names.index(name) for name in ladder.order]
    size = np.maximum(np.abs(ladder.fine[:, index, quantity]), _SMALLEST)
    doubt = np.maximum(ladder.uncertainty[:, index, quantity], _SMALLEST)
    label = "order A" if ladder.order == names else "order B"
    axes.plot(size, rows, marker, color=colour, label=label, ms=4)
    axes.plot(doubt, rows, "x", color="#999999", ms=3)
    axes.set(xscale="log", ylim=(len(names) - 0.4, -0.6))

"""A drawing of the tip's error over the base's mass."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from crosscheck.audit.hypotheses.evidence.flights import LIMIT_M, SCENARIOS, SIDES_M, Flight
from crosscheck.audit.hypotheses.words import SCENARIOS as TITLES
from crosscheck.report.figures import legend, new_figure, to_svg
from crosscheck.report.fragments import COLOURS


def drawing(flights: Sequence[Flight]) -> str:
    """A panel for each experiment, a line for each cube."""
    picture, grid = new_figure(1, len(SCENARIOS), 2.9)
    for axes, scenario in zip(grid[0], SCENARIOS, strict=True):
        for side, colour in zip(SIDES_M, COLOURS, strict=False):
            mine = [f for f in flights if (f.scenario, f.side_m) == (scenario, side)]
            points = [(f.ratio, 1000 * f.largest_m) for f in mine]
            axes.plot(*np.array(points).T, "o-", color=colour, ms=3, label=f"cube {side:g} m")
        axes.axhline(1000 * LIMIT_M, color="#555555", linestyle=":")
        axes.set(xscale="log", yscale="log", xlabel="base mass / arm mass",
                 ylabel="largest tip error [mm]", title=TITLES[scenario])  # fmt: skip
    legend(picture, grid[0, 0])
    return to_svg(picture)

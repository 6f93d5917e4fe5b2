"""Drawings of the errors that accumulate back and forth."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from crosscheck import signals
from crosscheck.audit.hypotheses.evidence.shaking import (
    BACKLASHES_M,
    REFERENCE_M,
    SMALL_S,
    Shaken,
    running,
)
from crosscheck.report.figures import legend, new_figure, to_svg
from crosscheck.report.fragments import COLOURS


def drawing(found: Sequence[Shaken], titles: dict[str, str]) -> str:
    """Errors of the first start over time, and over b, a row for each; titles: by drive."""
    picture, grid = new_figure(len(found), 2, 2.9)
    for row, case in zip(grid, found, strict=True):
        time, predicted = (np.array(x, float) for x in (case.curves.time, case.curves.predicted))
        for b, values, colour in zip(BACKLASHES_M, case.curves.errors, COLOURS, strict=True):
            error = np.array(values)
            row[0].plot(time, running(error), color=colour, label=f"b {1e6 * b:g} µm")
            row[1].plot(time, error / b, color=colour, lw=0.9)
        row[0].plot(time, running(predicted), "k--", lw=1, label="rigid arm's own, b 50 µm")
        row[1].plot(time, predicted / REFERENCE_M, "k--", lw=1)
        own = np.array(case.curves.errors[BACKLASHES_M.index(REFERENCE_M)])
        bound = 1.3 * signals.amplitude(own[time <= SMALL_S[1]]) / REFERENCE_M
        row[0].set(yscale="log", ylim=(1e-10, 10), xlabel="time [s]", ylabel="|Δθ₁| [rad]",
                   title=f"T = {titles[case.drive]}, ζ = {case.zeta:g}")  # fmt: skip
        row[1].set(xlim=(0, SMALL_S[1]), ylim=(-bound, bound), xlabel="time [s]",
                   ylabel="Δθ₁ / b [rad/m]")  # fmt: skip
    legend(picture, grid[0, 0])
    return to_svg(picture)

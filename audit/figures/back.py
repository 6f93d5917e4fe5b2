"""Figure 15: the error of going back and forth."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from crosscheck.audit.experiments.cells import INTEGRAL, Cell
from crosscheck.audit.experiments.experiments import BACK, DEFAULT_B_UM
from crosscheck.audit.figures.plate import Drawing, Plate
from crosscheck.audit.figures.runs import SMOOTH_RECORD, ZETA, drawn, rigid_run
from crosscheck.audit.figures.shelf import Shelf
from crosscheck.audit.figures.views import conditions
from crosscheck.audit.measures.rigid import COUPLED
from crosscheck.report.figures import legend, new_figure, to_svg
from crosscheck.report.fragments import COLOURS

SMALLEST_RAD = 1e-8  # of what is drawn


def figure_15(shelf: Shelf) -> Plate:
    """Error of the shoulder angle when both joints go back and forth."""
    cell = Cell(INTEGRAL, ZETA)
    variants = {b: drawn(BACK(b), cell, shelf.seed, SMOOTH_RECORD) for b in shelf.plan.back}
    baseline = rigid_run("back-and-forth", COUPLED)
    runs = shelf.courses([*variants.values(), baseline], 15)
    rigid = runs[baseline]
    errors = {b: runs[one].theta[:, 0] - rigid.theta[:, 0] for b, one in variants.items()}
    more = "b as in the legend; Δ: detailed less rigid (coupled)."
    caption = conditions(runs[variants[DEFAULT_B_UM]], shelf.seed, more)
    return Plate(15, [Drawing(_svg(rigid.time, errors), caption)], ZETA, shelf.seed)


def _svg(time: np.ndarray, errors: Mapping[float, np.ndarray]) -> str:
    figure, grid = new_figure(1, 2, 2.8)
    for (b, error), colour in zip(errors.items(), COLOURS, strict=False):
        grid[0, 0].plot(time, error, color=colour, label=f"b {b:g} µm")
        size = np.maximum(np.abs(error), SMALLEST_RAD)
        grid[0, 1].plot(time, size, color=colour, linewidth=0.8)
    grid[0, 0].set(xlabel="time [s]", ylabel="Δθ_1 [rad]")
    grid[0, 1].set(xlabel="time [s]", ylabel="|Δθ_1| [rad]", yscale="log")
    legend(figure, grid[0, 0])
    return to_svg(figure)

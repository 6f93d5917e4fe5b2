"""Drawings of the chapter on the phase: linear theory against runs, resonance."""

from __future__ import annotations

import numpy as np

from crosscheck.audit.experiments.cells import Cell
from crosscheck.audit.phase.page.views import band, law_name
from crosscheck.audit.phase.resonance import SPEEDS, Resonance
from crosscheck.audit.phase.runs.experiments import DECISIVE, integrated
from crosscheck.audit.phase.stability import Linearised, Stability
from crosscheck.report.figures import legend, log_y, new_figure, to_svg
from crosscheck.report.fragments import COLOURS

LABELS = (
    "largest growth rate [1/s]",
    "mode frequency [Hz]",
    "vibration [rad/s²]",
    "shoulder acc. [rad/s²]",
)
STRIP = "#b03050"


def stability(found: Stability) -> str:
    """Growth, frequencies, vibration and acceleration; a column for every setting."""
    drawing, grid = new_figure(len(LABELS), len(DECISIVE), 2.2)
    for axes, cell in zip(grid.T, DECISIVE, strict=True):
        axes[0].set_title(f"ζ = {cell.zeta:g}, ring rate {cell.law.ring_rate}")
        for one, colour in zip((cell, integrated(cell)), COLOURS, strict=False):
            _column(axes, one, found.cells[one], colour)
        axes[0].axhline(0.0, color="black", lw=0.6)
        axes[0].set_ylim(-500, None)
        axes[2].set(yscale="log", ylim=(1e-13, 1e5))
        axes[3].set_xlabel("time [s]")
    for axes, label in zip(grid[:, 0], LABELS, strict=True):
        axes.set_ylabel(label)
    legend(drawing, grid[0, 0])
    return to_svg(drawing)


def _column(axes: np.ndarray, cell: Cell, one: Linearised, colour: str) -> None:
    axes[0].plot(*one.growth, color=colour, label=law_name(cell.law).partition(",")[0])
    for curve, unstable in zip(one.frequencies, one.unstable, strict=True):
        growing = np.where(unstable[: len(curve.values)], curve.values, np.nan)
        axes[1].plot(*curve, color=colour, lw=0.5, alpha=0.6)
        axes[1].plot(curve.time_s, growing, color=colour, lw=2.2)
    axes[2].plot(*one.simulated, color=colour)
    axes[2].plot(*one.predicted, color=colour, ls=":", lw=1.4)
    band(axes[3], one.shoulder, colour)
    if one.begun and one.begun[0].predicted_s is not None:
        for below in axes[2:]:
            below.axvline(one.begun[0].predicted_s, color="black", ls="--", lw=0.9)


def resonance(found: Resonance) -> str:
    """The run-up above, growth by stiffness alone below."""
    drawing, grid = new_figure(2, 1, 2.3)
    above, below = grid[:, 0]
    colours = dict(zip(found.tongues, COLOURS, strict=False))
    for zeta, ramp in found.run_ups.items():
        above.plot(ramp.drawn_speed, ramp.drawn_size, color=colours[zeta])
    log_y(above)
    for zeta, rates in found.tongues.items():
        below.plot(SPEEDS, rates.growth, color=colours[zeta], label=f"ζ = {zeta:g}")
    legend(drawing, below)
    for speed in found.modes.speeds:
        above.axvline(speed, color="black", ls="--", lw=0.8)
    for axes in (above, below):
        axes.axvspan(0.0, found.speeds.pd, color=STRIP, alpha=0.8)
        axes.set_xlim(-5.0, None)
    below.axhline(0.0, color="black", lw=0.6)
    above.set_ylabel("vibration, run-up [rad/s²]")
    below.set(xlabel="carrier speed [rad/s]", ylabel="Floquet growth rate [1/s]")
    return to_svg(drawing)

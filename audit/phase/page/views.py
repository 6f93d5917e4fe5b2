"""Drawings of the chapter on the phase: clock, maps, starts, linear theory, resonance."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes

from crosscheck.audit.experiments.cells import LABELLED, Law
from crosscheck.audit.experiments.experiments import DEFAULT_B_UM, DEFAULT_E_UM
from crosscheck.audit.figures.views import same_scale
from crosscheck.audit.measures.third import Third
from crosscheck.audit.phase.clock import RUN_WINDOW_S, Clocks, SignalEnvelope
from crosscheck.audit.phase.handover import HEIRS, HandedOver
from crosscheck.audit.phase.maps import BACKLASH_ZETAS, BACKLASHES_UM, FOUR, Maps
from crosscheck.audit.phase.resonance import SPEEDS, Resonance
from crosscheck.audit.phase.runs import DECISIVE, integrated
from crosscheck.audit.phase.stability import Stability
from crosscheck.report.fragments import COLOURS
from crosscheck.report.plots.figures import KILO, legend, log_y, new_figure, not_reached, to_svg

NAMES = {
    "omega_t/eq13": "ω t, ring rate of Eq. 13 (paper)",
    "omega_t/corrected": "ω t, ring rate corrected",
    "angle/corrected": "angle (integral)",
    "angle/eq13": "angle, ring rate of Eq. 13",
}
LABELS = (
    "largest growth rate [1/s]",
    "mode frequency [Hz]",
    "vibration [rad/s²]",
    "shoulder acc. [rad/s²]",
)
STRIP = "#b03050"


def band(
    axes: Axes, one: SignalEnvelope, colour: str, label: str | None = None, unit: float = 1.0
) -> None:
    """Draw a fast signal as a band from smallest to largest value, times a unit."""
    low, high = ([unit * value for value in values] for values in (one.low, one.high))
    axes.fill_between(one.time_s, low, high, color=colour, linewidth=0.6, alpha=0.75, label=label)


def law_name(law: Law) -> str:
    """The name of a law for readers."""
    return NAMES.get(law.id, law.id)


def clock(found: Clocks) -> str:
    """Forces along one motion above, runs from rest below, a column for every law, as svg."""
    drawing, grid = new_figure(2, len(found.laws), 2.3)
    for (above, below), law in zip(grid.T, found.laws, strict=True):
        for one, colour in reversed(list(zip(law.delays, COLOURS, strict=False))):
            label = f"clock from {one.clock_s:g} s"
            band(above, one.force_N, colour, label, KILO)
            band(below, within(one.shoulder, *RUN_WINDOW_S), colour, label)
        above.set_title(law_name(law.law))
        below.set_xlabel("time since the start [s]")
    grid[0, 0].set_ylabel("F_sp1, same motion [kN]")
    grid[1, 0].set_ylabel("shoulder acc. [rad/s²]")
    legend(drawing, grid[0, 0])
    same_scale(grid)
    return to_svg(drawing)


def within(one: SignalEnvelope, begin_s: float, end_s: float) -> SignalEnvelope:
    """The part of an envelope between two times [s]."""
    kept = [values for values in zip(*one, strict=True) if begin_s <= values[0] <= end_s]
    return (
        SignalEnvelope(*map(tuple, zip(*kept, strict=True))) if kept else SignalEnvelope((), (), ())
    )


def error_map(found: Maps) -> str:
    """Share of severe starts over damping and tooth error, a panel for every law, as svg."""
    chosen = {
        (one.setting.cell.law, one.setting.error_um, one.setting.cell.zeta): one
        for one in found.settings
        if one.setting.cell.arm == LABELLED and one.setting.backlash_um == DEFAULT_B_UM
    }
    zetas = sorted({zeta for _, _, zeta in chosen})
    errors = sorted({error for _, error, _ in chosen})
    drawing, grid = new_figure(2, 2, 2.2)
    for axes, law in zip(grid.ravel(), FOUR, strict=True):
        without = [chosen[law, errors[0], zeta].without for zeta in zetas]
        rows = [[chosen[law, error, zeta].third for zeta in zetas] for error in errors]
        _heat(axes, [without, *rows], zetas, [0.0, *errors])
        axes.set(title=law_name(law), xlabel="ζ", ylabel="E [µm]")
    return to_svg(drawing)


def backlash_map(found: Maps) -> str:
    """Share of severe starts over damping and backlash, a panel for every law, as svg."""
    chosen = {
        (one.setting.cell.law, one.setting.backlash_um, one.setting.cell.zeta): one
        for one in found.settings
        if one.setting.cell.arm == LABELLED and one.setting.error_um == DEFAULT_E_UM
    }
    drawing, grid = new_figure(1, len(FOUR), 2.4)
    for axes, law in zip(grid[0], FOUR, strict=True):
        rows = [[chosen[law, b, zeta].third for zeta in BACKLASH_ZETAS] for b in BACKLASHES_UM]
        _heat(axes, rows, BACKLASH_ZETAS, BACKLASHES_UM)
        axes.set_title(law_name(law).replace(", ", ",\n"))
        axes.set_xlabel("ζ")
    grid[0, 0].set_ylabel("b [µm]")
    return to_svg(drawing)


def _heat(
    axes: Axes, thirds: Sequence[Sequence[Third]], columns: Sequence[float], rows: Sequence[float]
) -> None:
    """Draw the shares of severe starts as colours and per cent."""
    shares = [[np.nan if x.share is None else 100 * x.share.value for x in row] for row in thirds]
    axes.imshow(shares, origin="lower", aspect="auto", cmap="YlOrRd", vmin=0, vmax=100)
    for (row, column), value in np.ndenumerate(shares):
        shade = "white" if value > 60 else "black"
        label = "-" if np.isnan(value) else f"{value:.0f}"
        axes.text(column, row, label, ha="center", va="center", fontsize=6.5, color=shade)
    axes.set_xticks(range(len(columns)), [f"{c:g}" for c in columns], fontsize=6.5)
    axes.set_yticks(range(len(rows)), [f"{r:g}" for r in rows], fontsize=7)
    axes.grid(visible=False)


def handed_over(found: HandedOver) -> str:
    """The first severe start continued under every heir, as svg."""
    drawing, grid = new_figure(1, len(HEIRS), 2.4)
    for axes, heir, drawn, colour in zip(grid[0], HEIRS, found.drawn, COLOURS, strict=False):
        band(axes, drawn, colour)
        axes.set(title=f"continued under {heir.name}", xlabel="time [s]")
    if found.drawn:
        same_scale(grid)
    else:
        for axes in grid[0]:
            not_reached(axes)
    grid[0, 0].set_ylabel("shoulder acc. [rad/s²]")
    return to_svg(drawing)


def stability(found: Stability) -> str:
    """Growth, frequencies, vibration and acceleration, a column for every setting, as svg."""
    drawing, grid = new_figure(len(LABELS), len(DECISIVE), 2.2)
    for axes, cell in zip(grid.T, DECISIVE, strict=True):
        axes[0].set_title(f"ζ = {cell.zeta:g}, ring rate {cell.law.ring_rate}")
        for of, colour in zip((cell, integrated(cell)), COLOURS, strict=False):
            one = found.cells[of]
            axes[0].plot(*one.growth, color=colour, label=law_name(of.law).partition(",")[0])
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
        axes[0].axhline(0.0, color="black", lw=0.6)
        axes[0].set_ylim(-500, None)
        axes[2].set(yscale="log", ylim=(1e-13, 1e5))
        axes[3].set_xlabel("time [s]")
    for axes, label in zip(grid[:, 0], LABELS, strict=True):
        axes.set_ylabel(label)
    legend(drawing, grid[0, 0])
    return to_svg(drawing)


def resonance(found: Resonance) -> str:
    """The vibration in a run-up above, growth by stiffness alone below, as svg."""
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

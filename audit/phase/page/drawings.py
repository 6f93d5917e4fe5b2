"""Drawings of the chapter on the phase: clock, maps, starts, linear theory, resonance."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes

from crosscheck.audit.experiments.experiments import DEFAULT_B_UM, DEFAULT_E_UM
from crosscheck.audit.experiments.paper_conditions import LABELLED, Law
from crosscheck.audit.figures.plotting import set_same_scale
from crosscheck.audit.measures.third_fluctuation import ThirdFluctuation
from crosscheck.audit.phase.clock import RUN_WINDOW_S, ClockTestResult, SignalEnvelope
from crosscheck.audit.phase.handover import LAWS_AFTER_SWITCH, LawSwitch
from crosscheck.audit.phase.maps import BACKLASH_ZETAS, BACKLASHES_UM, FOUR, Maps
from crosscheck.audit.phase.resonance import SPEEDS, Resonance
from crosscheck.audit.phase.runs import DECISIVE, use_integral_phase
from crosscheck.audit.phase.stability import Stability
from crosscheck.report.fragments import COLOURS
from crosscheck.report.plots.figures import (
    KILO,
    draw_legend,
    make_figure,
    mark_not_reached,
    set_log_scale,
    to_svg,
)

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


def draw_band(
    axes: Axes, envelope: SignalEnvelope, colour: str, label: str | None = None, unit: float = 1.0
) -> None:
    """Draw a fast signal as a band from smallest to largest value, times a unit."""
    low, high = ([unit * value for value in values] for values in (envelope.low, envelope.high))
    axes.fill_between(
        envelope.time_s, low, high, color=colour, linewidth=0.6, alpha=0.75, label=label
    )


def law_name(law: Law) -> str:
    """The name of a law for readers."""
    return NAMES.get(law.id, law.id)


def draw_clock_test(clock_test: ClockTestResult) -> str:
    """Forces along one motion above, runs from rest below, a column for every law, as svg."""
    drawing, grid = make_figure(2, len(clock_test.laws), 2.3)
    for (above, below), law in zip(grid.T, clock_test.laws, strict=True):
        for delay, colour in reversed(list(zip(law.delays, COLOURS, strict=False))):
            label = f"clock from {delay.clock_s:g} s"
            draw_band(above, delay.force_N, colour, label, KILO)
            draw_band(below, cut_envelope(delay.shoulder, *RUN_WINDOW_S), colour, label)
        above.set_title(law_name(law.law))
        below.set_xlabel("time since the start [s]")
    grid[0, 0].set_ylabel("F_sp1, same motion [kN]")
    grid[1, 0].set_ylabel("shoulder acc. [rad/s²]")
    draw_legend(drawing, grid[0, 0])
    set_same_scale(grid)
    return to_svg(drawing)


def cut_envelope(envelope: SignalEnvelope, begin_s: float, end_s: float) -> SignalEnvelope:
    """The part of an envelope between two times [s]."""
    kept = [values for values in zip(*envelope, strict=True) if begin_s <= values[0] <= end_s]
    return (
        SignalEnvelope(*map(tuple, zip(*kept, strict=True))) if kept else SignalEnvelope((), (), ())
    )


def draw_error_map(maps: Maps) -> str:
    """Share of severe starts over damping and tooth error, a panel for every law, as svg."""
    chosen = {
        (point.setting.cell.law, point.setting.error_um, point.setting.cell.zeta): point
        for point in maps.settings
        if point.setting.cell.arm == LABELLED and point.setting.backlash_um == DEFAULT_B_UM
    }
    zetas = sorted({zeta for _, _, zeta in chosen})
    errors = sorted({error for _, error, _ in chosen})
    drawing, grid = make_figure(2, 2, 2.2)
    for axes, law in zip(grid.ravel(), FOUR, strict=True):
        without = [chosen[law, errors[0], zeta].without for zeta in zetas]
        rows = [[chosen[law, error, zeta].third for zeta in zetas] for error in errors]
        _draw_heat_map(axes, [without, *rows], zetas, [0.0, *errors])
        axes.set(title=law_name(law), xlabel="ζ", ylabel="E [µm]")
    return to_svg(drawing)


def draw_backlash_map(maps: Maps) -> str:
    """Share of severe starts over damping and backlash, a panel for every law, as svg."""
    chosen = {
        (point.setting.cell.law, point.setting.backlash_um, point.setting.cell.zeta): point
        for point in maps.settings
        if point.setting.cell.arm == LABELLED and point.setting.error_um == DEFAULT_E_UM
    }
    drawing, grid = make_figure(1, len(FOUR), 2.4)
    for axes, law in zip(grid[0], FOUR, strict=True):
        rows = [[chosen[law, b, zeta].third for zeta in BACKLASH_ZETAS] for b in BACKLASHES_UM]
        _draw_heat_map(axes, rows, BACKLASH_ZETAS, BACKLASHES_UM)
        axes.set_title(law_name(law).replace(", ", ",\n"))
        axes.set_xlabel("ζ")
    grid[0, 0].set_ylabel("b [µm]")
    return to_svg(drawing)


def _draw_heat_map(
    axes: Axes,
    thirds: Sequence[Sequence[ThirdFluctuation]],
    columns: Sequence[float],
    rows: Sequence[float],
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


def draw_handover(law_switch: LawSwitch) -> str:
    """The first severe start continued under every heir, as svg."""
    drawing, grid = make_figure(1, len(LAWS_AFTER_SWITCH), 2.4)
    for axes, law, drawn, colour in zip(
        grid[0], LAWS_AFTER_SWITCH, law_switch.drawn, COLOURS, strict=False
    ):
        draw_band(axes, drawn, colour)
        axes.set(title=f"continued under {law.name}", xlabel="time [s]")
    if law_switch.drawn:
        set_same_scale(grid)
    else:
        for axes in grid[0]:
            mark_not_reached(axes)
    grid[0, 0].set_ylabel("shoulder acc. [rad/s²]")
    return to_svg(drawing)


def draw_stability(result: Stability) -> str:
    """Growth, frequencies, vibration and acceleration, a column for every setting, as svg."""
    drawing, grid = make_figure(len(LABELS), len(DECISIVE), 2.2)
    for axes, cell in zip(grid.T, DECISIVE, strict=True):
        axes[0].set_title(f"ζ = {cell.zeta:g}, ring rate {cell.law.ring_rate}")
        for of, colour in zip((cell, use_integral_phase(cell)), COLOURS, strict=False):
            linearised = result.cells[of]
            axes[0].plot(*linearised.growth, color=colour, label=law_name(of.law).partition(",")[0])
            for curve, unstable in zip(linearised.frequencies, linearised.unstable, strict=True):
                growing = np.where(unstable[: len(curve.values)], curve.values, np.nan)
                axes[1].plot(*curve, color=colour, lw=0.5, alpha=0.6)
                axes[1].plot(curve.time_s, growing, color=colour, lw=2.2)
            axes[2].plot(*linearised.simulated, color=colour)
            axes[2].plot(*linearised.predicted, color=colour, ls=":", lw=1.4)
            draw_band(axes[3], linearised.shoulder, colour)
            if linearised.onsets and linearised.onsets[0].predicted_s is not None:
                for below in axes[2:]:
                    below.axvline(linearised.onsets[0].predicted_s, color="black", ls="--", lw=0.9)
        axes[0].axhline(0.0, color="black", lw=0.6)
        axes[0].set_ylim(-500, None)
        axes[2].set(yscale="log", ylim=(1e-13, 1e5))
        axes[3].set_xlabel("time [s]")
    for axes, label in zip(grid[:, 0], LABELS, strict=True):
        axes.set_ylabel(label)
    draw_legend(drawing, grid[0, 0])
    return to_svg(drawing)


def draw_resonance(result: Resonance) -> str:
    """The vibration in a run-up above, growth by stiffness alone below, as svg."""
    drawing, grid = make_figure(2, 1, 2.3)
    above, below = grid[:, 0]
    colours = dict(zip(result.tongues, COLOURS, strict=False))
    for zeta, ramp in result.run_ups.items():
        above.plot(ramp.drawn_speed, ramp.drawn_size, color=colours[zeta])
    set_log_scale(above)
    for zeta, rates in result.tongues.items():
        below.plot(SPEEDS, rates.growth, color=colours[zeta], label=f"ζ = {zeta:g}")
    draw_legend(drawing, below)
    for speed in result.modes.speeds:
        above.axvline(speed, color="black", ls="--", lw=0.8)
    for axes in (above, below):
        axes.axvspan(0.0, result.speeds.pd, color=STRIP, alpha=0.8)
        axes.set_xlim(-5.0, None)
    below.axhline(0.0, color="black", lw=0.6)
    above.set_ylabel("vibration, run-up [rad/s²]")
    below.set(xlabel="carrier speed [rad/s]", ylabel="Floquet growth rate [1/s]")
    return to_svg(drawing)

"""Figures 16 to 20: forces and spectra over backlash and over tooth error."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from crosscheck import signals
from crosscheck.audit.experiments.experiments import (
    BACKLASH,
    DEFAULT_B_UM,
    DEFAULT_E_UM,
    ERROR,
    ExperimentSeries,
)
from crosscheck.audit.experiments.paper_conditions import INTEGRAL, LAWS, Law
from crosscheck.audit.figures.figure_data import (
    LOW_ZETA,
    FigureData,
    make_condition,
    make_start_variant,
)
from crosscheck.audit.figures.paper_figure import Drawing, PaperFigure
from crosscheck.audit.figures.plotting import (
    KILO,
    LAW_COLOURS,
    describe_run,
    draw_line,
    set_same_scale,
)
from crosscheck.audit.measures import events
from crosscheck.audit.measures.events import THIRD_S
from crosscheck.audit.measures.rigid import rigid_arm
from crosscheck.audit.measures.run_signals import RunSignals
from crosscheck.audit.page.labels import DRAWN_NAMES
from crosscheck.report.fragments import COLOURS
from crosscheck.report.plots.figures import (
    draw_legend,
    make_figure,
    mark_not_reached,
    set_log_scale,
    to_svg,
)
from crosscheck.signals import envelope

SMALL_BINS = 200
HIGHEST_HZ = 6000.0
FAINTEST = 1e-6  # rad/s^2: what is drawn of a spectrum
DRAWN = 150  # points of a spectrum: the largest line of every 40 Hz
Spectrum = tuple[np.ndarray, np.ndarray]  # frequency [Hz], amplitude [rad/s^2]


class Axis(NamedTuple):
    """A number on an axis: its name in MEASURED, the axis's label, the factor to its unit."""

    name: str
    label: str
    scale: float = 1.0
    log: bool = False


class Sweep(NamedTuple):
    """A figure's family of experiments, the paper's own size [um], and numbers of all starts.

    F_sp1 is drawn in a window [s]; without one the spectra of both joints' accelerations are drawn.
    """

    series: ExperimentSeries
    default_um: float
    numbers: tuple[Axis, ...]
    window: tuple[float, float] | None = None


_THIRD = (
    Axis("third_force_fast_N", "fast part of F_sp1 [kN]", KILO, log=True),
    Axis("third", "third fluctuation [rad/s²]", log=True),
)
_IMPACT = (
    Axis("side_change_s", "first contact [s]"),
    Axis("second_force_N", "impact [kN]", KILO, log=True),
    Axis("second_decay_s", "falls to a tenth in [s]"),
)
_LINES = (
    Axis("frequency_Hz", "shoulder's frequency [Hz]"),
    Axis("line_share", "share of energy in one line [1]"),
    Axis("low_share", "share of energy below 500 Hz [1]"),
)
_JOINTS = (
    Axis("third", "shoulder [rad/s²]", log=True),
    Axis("third_elbow", "elbow [rad/s²]", log=True),
)
FIGURES = {
    16: Sweep(BACKLASH, DEFAULT_B_UM, _IMPACT, (0.34, 0.46)),
    17: Sweep(BACKLASH, DEFAULT_B_UM, _THIRD, THIRD_S),
    18: Sweep(BACKLASH, DEFAULT_B_UM, _LINES),
    19: Sweep(ERROR, DEFAULT_E_UM, _THIRD, THIRD_S),
    20: Sweep(ERROR, DEFAULT_E_UM, _JOINTS),
}


def draw_sweep_figure(data: FigureData, number: int) -> PaperFigure:
    """The plate of one of FIGURES: numbers of all starts, then what one start gives."""
    series, default_um, shown, window = FIGURES[number]
    sweep = data.sweep(number, series, LOW_ZETA)
    default_run = sweep[INTEGRAL][default_um]
    if window is None:
        where = "in the legend"
        plain = {
            law: make_start_variant(series(default_um), make_condition(law, LOW_ZETA), None)
            for law in sweep
        }
        beside = {
            law: rigid_arm(replace(variant, duration_s=None)) for law, variant in plain.items()
        }
        rigid = data.load_courses(beside, number)
        lines = {
            law: {size: excess_spectra(run, rigid[law]) for size, run in row.items()}
            for law, row in sweep.items()
        }
        svg = _draw_spectra(lines, series.symbol)
    else:
        where = "at the panels"
        svg = _draw_forces(sweep, series.symbol, window)
    caption = describe_run(default_run, data.seed, f"{series.symbol} as {where}.")
    drawings = [_draw_start_numbers(data, series, shown), Drawing(svg, caption)]
    return PaperFigure(number, drawings, LOW_ZETA, data.seed)


def _draw_start_numbers(
    data: FigureData, series: ExperimentSeries, shown: Sequence[Axis]
) -> Drawing:
    """A drawing of all starts' numbers, a dot each, laws side by side, sizes by rank."""
    figure, grid = make_figure(1, len(shown), 2.9)
    members = data.members(series)
    samples = [data.samples_by_law(member, LOW_ZETA) for member in members]
    for axes, axis in zip(grid[0], shown, strict=True):
        for at, by_law in enumerate(samples):
            for place, (law, sample) in enumerate(by_law.items()):
                values = sample[axis.name]
                values = axis.scale * np.sort(values[np.isfinite(values)])
                x = at + 0.27 * (place - 1) + np.linspace(-0.1, 0.1, values.size)
                label = None if at else DRAWN_NAMES[law]
                axes.plot(x, values, ".", ms=3.5, color=LAW_COLOURS[law], label=label)
        ticks = [f"{member.size_um:g}" for member in members]
        axes.set_xticks(range(len(members)), ticks, fontsize=7)
        axes.set(xlabel=f"{series.symbol} [µm]", ylabel=axis.label)
        if axis.log:
            set_log_scale(axes)
    draw_legend(figure, grid[0, 0])
    count = data.context.scale.most_starts
    caption = (
        f"Every dot is one of {count} starts that differ by 1e-12 m, at zeta {LOW_ZETA:g};"
        f" {series.symbol} in µm, not to scale."
    )
    return Drawing(to_svg(figure), caption)


def _draw_forces(
    sweep: Mapping[Law, Mapping[float, RunSignals]], symbol: str, window: tuple[float, float]
) -> str:
    """F_sp1 [kN] in a window [s] from one start, a row per size, the laws side by side; svg."""
    sizes = list(sweep[INTEGRAL])
    figure, grid = make_figure(len(sizes), len(sweep), 1.15)
    for column, (law, row) in enumerate(sweep.items()):
        grid[0, column].set_title(DRAWN_NAMES[law])
        grid[-1, column].set_xlabel("time [s]")
        for axes, (size, run) in zip(grid[:, column], row.items(), strict=True):
            part = signals.window(run.time, *window)
            time, force = run.time[part], run.F_sp[part]
            draw_line(axes, time, KILO * force, DRAWN_NAMES[law], LAW_COLOURS[law], SMALL_BINS)
            if not time.size:
                mark_not_reached(axes)
            axes.set(xlim=window, ylabel=f"{symbol} {size:g} µm\nF_sp1 [kN]")
            axes.tick_params(labelbottom=axes is grid[-1, column])
    set_same_scale(grid)
    return to_svg(figure)


def excess_spectra(run: RunSignals, rigid: RunSignals) -> list[Spectrum]:
    """The spectra of both joints in the part of the run that the claims' numbers look at."""
    third = events.third_window_after_changes(run.time, run.F_sp, run.F_outer[:, 0])
    if not run.time[third].size:
        return [(np.empty(0), np.empty(0))] * 2
    excess = run.theta_ddot - rigid.at(run.time).theta_ddot
    near = events.third_peak(run.time, excess[:, 0], third)
    return [signals.spectrum(run.time[near], excess[near, joint]) for joint in (0, 1)]


def _draw_spectra(lines: Mapping[Law, Mapping[float, list[Spectrum]]], symbol: str) -> str:
    figure, grid = make_figure(2, len(LAWS), 2.4)
    for column, (law, row) in enumerate(lines.items()):
        grid[0, column].set_title(DRAWN_NAMES[law])
        grid[-1, column].set_xlabel("frequency [Hz]")
        for joint, axes in enumerate(grid[:, column]):
            for (size, spectra), colour in zip(row.items(), COLOURS, strict=False):
                label = f"{symbol} {size:g} µm"
                axes.plot(*_bin_maxima(*spectra[joint]), color=colour, label=label, linewidth=0.8)
            axes.set(xlim=(0, HIGHEST_HZ), ylabel=f"{('shoulder', 'elbow')[joint]} [rad/s²]")
            set_log_scale(axes)
    set_same_scale(grid)
    for axes in grid.flat:
        axes.set_ylim(bottom=max(FAINTEST, axes.get_ylim()[0]))
    draw_legend(figure, grid[0, 0])
    return to_svg(figure)


def _bin_maxima(frequency: np.ndarray, amplitudes: np.ndarray) -> Spectrum:
    """The largest amplitude of every bin of a drawing, with the bins' frequencies."""
    kept = frequency <= HIGHEST_HZ
    if not kept.any():
        return np.empty(0), np.empty(0)
    centres, _, high = envelope(frequency[kept], amplitudes[kept], DRAWN)
    return centres, high

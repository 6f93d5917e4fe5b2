"""Figures 18 and 20: spectra of both joints' accelerations over backlash and over tooth error."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from crosscheck import signals
from crosscheck.audit.experiments.cells import INTEGRAL, LAWS, Cell, Law
from crosscheck.audit.experiments.experiments import BACKLASH, ERROR, Family
from crosscheck.audit.figures.plate import Drawing, Plate
from crosscheck.audit.figures.runs import LOW_ZETA, drawn
from crosscheck.audit.figures.shelf import Shelf, excess
from crosscheck.audit.figures.sweeps import DEFAULTS, Axis, over_sizes
from crosscheck.audit.figures.views import conditions, same_scale
from crosscheck.audit.measures import events
from crosscheck.audit.measures.course import Course
from crosscheck.audit.page.words import LAW_NAMES
from crosscheck.envelope import envelope
from crosscheck.report.figures import legend, log_y, new_figure, to_svg
from crosscheck.report.fragments import COLOURS

HIGHEST_HZ = 6000.0
FAINTEST = 1e-6  # rad/s^2: what is drawn of a spectrum
DRAWN = 300  # points of a spectrum: the largest line of every 20 Hz
BACKLASH_AXES = (
    Axis("frequency_Hz", "shoulder's frequency [Hz]"),
    Axis("line_share", "share of energy in one line [1]"),
    Axis("low_share", "share of energy below 500 Hz [1]"),
)
ERROR_AXES = (
    Axis("third", "shoulder [rad/s²]", log=True),
    Axis("third_elbow", "elbow [rad/s²]", log=True),
)
Spectrum = tuple[np.ndarray, np.ndarray]  # frequency [Hz], amplitude [rad/s^2]


def figure_18(shelf: Shelf) -> Plate:
    """Over b."""
    return _plate(shelf, 18, BACKLASH, BACKLASH_AXES)


def figure_20(shelf: Shelf) -> Plate:
    """Over E."""
    return _plate(shelf, 20, ERROR, ERROR_AXES)


def _plate(shelf: Shelf, number: int, family: Family, axes: tuple[Axis, ...]) -> Plate:
    sweep = shelf.sweep(number, family, LOW_ZETA)
    rigid = shelf.rigid(drawn(family(DEFAULTS[family]), Cell(INTEGRAL, LOW_ZETA), None), number)
    lines = {
        law: {size: spectra(run, rigid) for size, run in row.items()} for law, row in sweep.items()
    }
    own = sweep[INTEGRAL][DEFAULTS[family]]
    caption = conditions(own, shelf.seed, f"{family.symbol} as in the legend.")
    one = Drawing(_svg(lines, family.symbol), caption)
    return Plate(number, [over_sizes(shelf, family, axes), one], LOW_ZETA, shelf.seed)


def spectra(run: Course, rigid: Course) -> list[Spectrum]:
    """Of both joints, in the part of the run that the claims' numbers look at."""
    third = events.third_after(run.time, run.F_sp, run.F_outer[:, 0])
    if not run.time[third].size:
        return [(np.empty(0), np.empty(0))] * 2
    own = excess(run, rigid)
    near = events.third_peak(run.time, own[:, 0], third)
    return [signals.spectrum(run.time[near], own[near, joint]) for joint in (0, 1)]


def _svg(lines: Mapping[Law, Mapping[float, list[Spectrum]]], symbol: str) -> str:
    figure, grid = new_figure(2, len(LAWS), 2.4)
    for column, (law, row) in enumerate(lines.items()):
        grid[0, column].set_title(LAW_NAMES[law])
        grid[-1, column].set_xlabel("frequency [Hz]")
        for joint, axes in enumerate(grid[:, column]):
            for (size, found), colour in zip(row.items(), COLOURS, strict=False):
                label = f"{symbol} {size:g} µm"
                axes.plot(*_drawn(*found[joint]), color=colour, label=label, linewidth=0.8)
            axes.set(xlim=(0, HIGHEST_HZ), ylabel=f"{('shoulder', 'elbow')[joint]} [rad/s²]")
            log_y(axes)
    same_scale(grid)
    for axes in grid.flat:
        axes.set_ylim(bottom=max(FAINTEST, axes.get_ylim()[0]))
    legend(figure, grid[0, 0])
    return to_svg(figure)


def _drawn(frequency: np.ndarray, amplitudes: np.ndarray) -> Spectrum:
    """The largest amplitude of every bin of a drawing."""
    kept = frequency <= HIGHEST_HZ
    if not kept.any():
        return np.empty(0), np.empty(0)
    centres, _, high = envelope(frequency[kept], amplitudes[kept], DRAWN)
    return centres, high

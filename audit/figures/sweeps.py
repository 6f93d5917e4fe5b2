"""Figures 16 to 20: forces and spectra over backlash and over tooth error."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from pydantic import TypeAdapter

from crosscheck import signals
from crosscheck.audit.experiments.experiments import DEFAULTS, PD, SERIES, ExperimentSeries
from crosscheck.audit.experiments.paper_conditions import INTEGRAL, LAWS, Law
from crosscheck.audit.experiments.variant import rigid_arm
from crosscheck.audit.figures.figure_data import (
    FIGURES_FILE,
    LOW_ZETA,
    Drawing,
    FigureData,
    PaperFigure,
    make_condition,
    make_start_variant,
)
from crosscheck.audit.figures.plotting import (
    KILO,
    LAW_COLOURS,
    Curve,
    Panel,
    describe_run,
    draw_panels,
)
from crosscheck.audit.measures import events
from crosscheck.audit.measures.run_signals import RunSignals
from crosscheck.audit.page.chapter import DRAWN_NAMES
from crosscheck.models.files import read_toml
from crosscheck.report.fragments import COLOURS
from crosscheck.signals import envelope

SMALL_BINS = 200
HIGHEST_HZ = 6000.0
FAINTEST = 1e-6  # rad/s^2: what is drawn of a spectrum
DRAWN = 150  # points of a spectrum: the largest line of every 40 Hz


class Axis(NamedTuple):
    """A number on an axis: its name in MEASURED, the axis's label, the factor to its unit."""

    name: str
    label: str
    scale: float = 1.0
    log: bool = False


class Sweep(NamedTuple):
    """A figure's family of experiments by its kind, and numbers of all starts, as in the file."""

    series: str
    axes: tuple[Axis, ...]
    window: tuple[float, float] | None = None


FIGURES = TypeAdapter(dict[int, Sweep]).validate_python(read_toml(FIGURES_FILE)["sweeps"])


def draw_sweep_figure(data: FigureData, number: int) -> PaperFigure:
    """The plate of one of FIGURES: numbers of all starts, then what one start gives."""
    kind, axes, window = FIGURES[number]
    series = SERIES[kind]
    members = data.members(series)
    courses = data.courses_by_law(number, *members)
    sizes = [f"{series.symbol} {member.size:g} µm" for member in members]
    if window is None:
        where, svg = "in the legend", _draw_spectra(data, number, courses, sizes)
    else:
        where, rows = "at the panels", []
        for size, runs in zip(sizes, courses, strict=True):
            settings: dict[str, object] = {"xlim": window, "ylabel": f"{size}\nF_sp1 [kN]"}
            if size != sizes[-1]:
                settings["xticklabels"] = []
            row = []
            for law, run in runs.items():
                part = signals.window(run.time, *window)
                force = KILO * run.F_sp[part]
                curve = Curve(run.time[part], force, LAW_COLOURS[law], bins=SMALL_BINS)
                row.append(Panel([curve], settings))
            rows.append(row)
        svg = draw_panels(1.15, "time [s]", *rows, by_law=True)
    default_run = next(
        runs[INTEGRAL] for member, runs in zip(members, courses, strict=True) if member in DEFAULTS
    )
    caption = describe_run(default_run, data.seed, f"{series.symbol} as {where}.")
    drawings = [_draw_start_numbers(data, series, axes), Drawing(svg, caption)]
    return PaperFigure(number, drawings, LOW_ZETA, data.seed)


def _draw_spectra(
    data: FigureData, number: int, courses: Sequence[Mapping[Law, RunSignals]], sizes: Sequence[str]
) -> str:
    """The spectra of both joints' accelerations of one start, a curve for each size, as svg."""
    plain = replace(make_start_variant(PD, make_condition(INTEGRAL), None), duration_s=None)
    (rigid,), rows = data.load_courses({PD: rigid_arm(plain)}, number).values(), []
    for joint, name in enumerate(("shoulder", "elbow")):
        settings = {"xlim": (0, HIGHEST_HZ), "ylabel": f"{name} [rad/s²]"}
        row = []
        for law in LAWS:
            spectra = [find_spectrum(runs[law], rigid, joint) for runs in courses]
            curves = [
                Curve(*spectrum, colour, size, width=0.8)
                for spectrum, size, colour in zip(spectra, sizes, COLOURS, strict=False)
            ]
            row.append(Panel(curves, settings, log=True))
        rows.append(row)
    return draw_panels(2.4, "frequency [Hz]", *rows, by_law=True)


def _draw_start_numbers(
    data: FigureData, series: ExperimentSeries, shown: Sequence[Axis]
) -> Drawing:
    """A drawing of all starts' numbers, a dot each, laws side by side, sizes by rank."""
    members = data.members(series)
    samples = [data.samples_by_law(member) for member in members]
    ticks = {"xticks": range(len(members)), "xticklabels": [f"{x.size:g}" for x in members]}
    row = []
    for axis in shown:
        curves = list[Curve]()
        for at, by_law in enumerate(samples):
            for place, (law, sample) in enumerate(by_law.items()):
                values = sample[axis.name]
                values = axis.scale * np.sort(values[np.isfinite(values)])
                x = at + 0.27 * (place - 1) + np.linspace(-0.1, 0.1, values.size)
                label = None if at else DRAWN_NAMES[law]
                curves.append(Curve(x, values, LAW_COLOURS[law], label, "."))
        row.append(Panel(curves, {**ticks, "ylabel": axis.label}, log=axis.log))
    caption = (
        f"Every dot is one of {data.context.scale.most_starts} starts that differ by 1e-12 m,"
        f" at zeta {LOW_ZETA:g}; {series.symbol} in µm, not to scale."
    )
    return Drawing(draw_panels(2.9, f"{series.symbol} [µm]", row), caption)


def find_spectrum(run: RunSignals, rigid: RunSignals, joint: int) -> tuple[np.ndarray, np.ndarray]:
    """A joint's spectrum, frequency [Hz] and amplitude [rad/s^2], as it is drawn.

    Of the part of the run that the claims' numbers look at; of every bin of the drawing the
    largest amplitude.
    """
    third = events.third_window(run.time, run.F_sp, run.F_outer[:, 0])
    if not run.time[third].size:
        return np.empty(0), np.empty(0)
    excess = run.theta_ddot - rigid.at(run.time).theta_ddot
    near = events.third_peak(run.time, excess[:, 0], third)
    frequency, amplitudes = signals.spectrum(run.time[near], excess[near, joint])
    kept = frequency <= HIGHEST_HZ
    if not kept.any():
        return np.empty(0), np.empty(0)
    centres, _, high = envelope(frequency[kept], amplitudes[kept], DRAWN)
    return centres, np.where(high > FAINTEST, high, np.nan)

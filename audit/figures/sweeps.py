"""Figures 16 to 20: forces and spectra over backlash and over tooth error."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import xarray as xr

from crosscheck import signals
from crosscheck.audit.experiments.cells import INTEGRAL, LAWS, Cell, Law
from crosscheck.audit.experiments.experiments import (
    BACKLASH,
    DEFAULT_B_UM,
    DEFAULT_E_UM,
    ERROR,
    Family,
)
from crosscheck.audit.figures.plate import Drawing, Plate
from crosscheck.audit.figures.shelf import LOW_ZETA, Shelf, drawn
from crosscheck.audit.figures.views import KILO, LAW_COLOURS, conditions, line, same_scale
from crosscheck.audit.measures import events
from crosscheck.audit.measures.course import Course
from crosscheck.audit.measures.events import THIRD_S
from crosscheck.audit.measures.reading import arm_of
from crosscheck.audit.measures.rigid import rigid_arm
from crosscheck.audit.measures.stage import paper_stage
from crosscheck.audit.page.words import LAW_NAMES
from crosscheck.report import fragments
from crosscheck.report.fragments import COLOURS
from crosscheck.report.plots.figures import legend, log_y, new_figure, not_reached, to_svg
from crosscheck.signals import envelope

SMALL_BINS = 350
HIGHEST_HZ = 6000.0
FAINTEST = 1e-6  # rad/s^2: what is drawn of a spectrum
DRAWN = 300  # points of a spectrum: the largest line of every 20 Hz
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

    family: Family
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


def figure_17(shelf: Shelf) -> Plate:
    """The plate of Fig. 17: F_sp1 over b in the third fluctuation; runs with too much energy."""
    plate = over_sizes(shelf, 17)
    fed = []
    for (law, b_um), run in shelf.runs(shelf.members(BACKLASH, LOW_ZETA), 17).items():
        peak_J, work_J = energy_peak(run)
        if peak_J > work_J:
            fed.append([LAW_NAMES[law], f"{b_um:g}", f"{peak_J:.4g}", f"{work_J:.4g}"])
    energies = ("largest kinetic energy [J]", "work of the drive until then [J]")
    table = fragments.table(["phase law", "b [µm]", *energies], fed)
    return replace(plate, tables={"energy": table} if fed else {})


def over_sizes(shelf: Shelf, number: int) -> Plate:
    """The plate of one of FIGURES: numbers of all starts, then what one start gives."""
    family, default_um, shown, window = FIGURES[number]
    sweep = shelf.sweep(number, family, LOW_ZETA)
    own = sweep[INTEGRAL][default_um]
    if window is None:
        where = "in the legend"
        plain = drawn(family(default_um), Cell(INTEGRAL, LOW_ZETA), None)
        beside = {"rigid": rigid_arm(replace(plain, duration_s=None))}
        rigid = shelf.courses(beside, number)["rigid"]
        lines = {
            law: {size: spectra(run, rigid) for size, run in row.items()}
            for law, row in sweep.items()
        }
        svg = _spectra_svg(lines, family.symbol)
    else:
        where = "at the panels"
        svg = _force_svg(sweep, family.symbol, window)
    caption = conditions(own, shelf.seed, f"{family.symbol} as {where}.")
    drawings = [_numbers_of_all(shelf, family, shown), Drawing(svg, caption)]
    return Plate(number, drawings, LOW_ZETA, shelf.seed)


def _numbers_of_all(shelf: Shelf, family: Family, shown: Sequence[Axis]) -> Drawing:
    """A drawing of all starts' numbers, a dot each, laws side by side, sizes by rank."""
    figure, grid = new_figure(1, len(shown), 2.9)
    known = shelf.known(LOW_ZETA)
    for axes, one in zip(grid[0], shown, strict=True):
        for place, law in enumerate(known):
            members = known[law].members(family)
            for at, member in enumerate(members):
                values = known[law][member][one.name]
                values = one.scale * np.sort(values[np.isfinite(values)])
                x = at + 0.27 * (place - 1) + np.linspace(-0.1, 0.1, values.size)
                label = None if at else LAW_NAMES[law]
                axes.plot(x, values, ".", ms=3.5, color=LAW_COLOURS[law], label=label)
        ticks = [f"{member.size_um:g}" for member in members]
        axes.set_xticks(range(len(members)), ticks, fontsize=7)
        axes.set(xlabel=f"{family.symbol} [µm]", ylabel=one.label)
        if one.log:
            log_y(axes)
    legend(figure, grid[0, 0])
    count = shelf.material.scale.most_starts
    caption = (
        f"Every dot is one of {count} starts that differ by 1e-12 m, at zeta {LOW_ZETA:g};"
        f" {family.symbol} in µm, not to scale."
    )
    return Drawing(to_svg(figure), caption)


def _force_svg(
    sweep: Mapping[Law, Mapping[float, Course]], symbol: str, window: tuple[float, float]
) -> str:
    """F_sp1 [kN] in a window [s] from one start, a row per size, the laws side by side; svg."""
    sizes = list(sweep[INTEGRAL])
    figure, grid = new_figure(len(sizes), len(sweep), 1.15)
    for column, (law, row) in enumerate(sweep.items()):
        grid[0, column].set_title(LAW_NAMES[law])
        grid[-1, column].set_xlabel("time [s]")
        for axes, (size, run) in zip(grid[:, column], row.items(), strict=True):
            part = signals.window(run.time, *window)
            time, force = run.time[part], run.F_sp[part]
            line(axes, time, KILO * force, LAW_NAMES[law], LAW_COLOURS[law], SMALL_BINS)
            if not time.size:
                not_reached(axes)
            axes.set(xlim=window, ylabel=f"{symbol} {size:g} µm\nF_sp1 [kN]")
            axes.tick_params(labelbottom=axes is grid[-1, column])
    same_scale(grid)
    return to_svg(figure)


def energy_peak(run: xr.Dataset) -> tuple[float, float]:
    """The largest kinetic energy [J], and the drive's work until then [J].

    The drive turns the sun: T theta_s' / n = T (theta' + (x_sp' + x_pr') / (2 r_cp)), summed over
    recorded intervals.
    """
    arm, energy = arm_of(run), run["kinetic_energy"].values
    radii = [paper_stage(arm, place).geometry.r_cp for place in range(len(arm.joints))]
    last = int(np.argmax(energy))
    meshes = run["x_sp"].values[:, :, 0] + run["x_pr"].values[:, :, 0]
    turned = run["theta"].values + meshes / (2 * np.array(radii))
    torque = run["torque"].values
    work = (torque[1:] + torque[:-1]) / 2 * np.diff(turned, axis=0)
    return float(energy[last]), float(work[:last].sum())


def spectra(run: Course, rigid: Course) -> list[Spectrum]:
    """The spectra of both joints in the part of the run that the claims' numbers look at."""
    third = events.third_after(run.time, run.F_sp, run.F_outer[:, 0])
    if not run.time[third].size:
        return [(np.empty(0), np.empty(0))] * 2
    own = run.theta_ddot - rigid.at(run.time).theta_ddot
    near = events.third_peak(run.time, own[:, 0], third)
    return [signals.spectrum(run.time[near], own[near, joint]) for joint in (0, 1)]


def _spectra_svg(lines: Mapping[Law, Mapping[float, list[Spectrum]]], symbol: str) -> str:
    figure, grid = new_figure(2, len(LAWS), 2.4)
    for column, (law, row) in enumerate(lines.items()):
        grid[0, column].set_title(LAW_NAMES[law])
        grid[-1, column].set_xlabel("frequency [Hz]")
        for joint, axes in enumerate(grid[:, column]):
            for (size, found), colour in zip(row.items(), COLOURS, strict=False):
                label = f"{symbol} {size:g} µm"
                axes.plot(*_highest(*found[joint]), color=colour, label=label, linewidth=0.8)
            axes.set(xlim=(0, HIGHEST_HZ), ylabel=f"{('shoulder', 'elbow')[joint]} [rad/s²]")
            log_y(axes)
    same_scale(grid)
    for axes in grid.flat:
        axes.set_ylim(bottom=max(FAINTEST, axes.get_ylim()[0]))
    legend(figure, grid[0, 0])
    return to_svg(figure)


def _highest(frequency: np.ndarray, amplitudes: np.ndarray) -> Spectrum:
    """The largest amplitude of every bin of a drawing, with the bins' frequencies."""
    kept = frequency <= HIGHEST_HZ
    if not kept.any():
        return np.empty(0), np.empty(0)
    centres, _, high = envelope(frequency[kept], amplitudes[kept], DRAWN)
    return centres, high

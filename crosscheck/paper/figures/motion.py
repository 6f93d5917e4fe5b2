"""Figures 14 and 15: shoulder acceleration, and the error of going back and forth."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from crosscheck import signals
from crosscheck.paper import events
from crosscheck.paper.figures.measures import line
from crosscheck.paper.figures.plate import (
    Plate,
    Shelf,
    Strip,
    conditions,
    law_figure,
    table,
)
from crosscheck.paper.figures.runs import DRIVEN_UM, SHORT_S, driven_run, rigid_run, size_run
from crosscheck.paper.figures.verdicts import (
    accumulates,
    by_law,
    fluctuates,
    in_range,
    proportional,
    rises,
    verdict,
)
from crosscheck.paper.numbers import quotient
from crosscheck.paper.reading import excess_acceleration
from crosscheck.paper.rigid import COUPLED, rigid_arm
from crosscheck.paper.undefined import all_of, shown
from crosscheck.report.figures import legend, new_figure, to_svg
from crosscheck.report.fragments import COLOURS

IMPACTS_S = ((0.0, 0.1), (0.3, 0.5))  # of the first two fluctuations
ZOOMS_S = ((0.0, 0.02), (0.345, 0.385), (1.10, 1.11))
IMPACTS = (10.0, 40.0)  # rad/s^2, Section 3.2: the first two fluctuations


def figure_14(shelf: Shelf) -> Plate:
    """Shoulder acceleration in the first 1.2 s."""
    runs = shelf.laws(14, size_run)
    rigid = _rigid_arms(shelf)
    measured = {law: fluctuations(run, rigid[COUPLED]) for law, run in runs.items()}
    rows = [(law, *m) for law, m in measured.items()]
    head = ("phase law", "first", "second", "third [rad/s²]", "third, onset [s]", "frequency [Hz]")

    firsts = {law: m.first_rad_per_s2 for law, m in measured.items()}
    seconds = {law: m.second_rad_per_s2 for law, m in measured.items()}
    third = {law: m.third_rad_per_s2 for law, m in measured.items()}
    return Plate(
        14,
        "shoulder acceleration in the first 1.2 s",
        _acceleration_svg(runs, rigid),
        "Three fluctuations: at the start and after 0.3 s, 10 to 40 rad/s², by impacts; then a"
        " third of up to 300 rad/s² without a sudden excitation, called self-excited and put down"
        " to tooth error and time-variant stiffness.",
        "Numbers are the largest detailed less rigid (coupled) acceleration in 0 to 0.1, 0.3 to 0.5"
        " and 0.5 to 1.2 s; the onset is where half of it is reached, the frequency that of 1.0 to"
        " 1.2 s. With the phase as the"
        f" integral of the mesh frequency the third one is {shown(third['angle'])} rad/s², with"
        f" frequency times time {shown(third['omega_t'])} rad/s².",
        conditions(runs["angle"]),
        {
            f"first fluctuation {IMPACTS[0]:g} to {IMPACTS[1]:g} rad/s²": _in_range(firsts),
            f"second fluctuation {IMPACTS[0]:g} to {IMPACTS[1]:g} rad/s²": _in_range(seconds),
            "third fluctuation": by_law({law: fluctuates(size) for law, size in third.items()}),
        },
        {"laws": {law: m._asdict() for law, m in measured.items()}},
        table(head, rows),
    )


def _rigid_arms(shelf: Shelf) -> dict[str, xr.Dataset]:
    """By level, in the same experiment."""
    variants = {level: rigid_arm(size_run("angle"), level) for level in (COUPLED, "links")}
    runs = shelf.runs(variants.values(), 14)
    return {level: runs[variant] for level, variant in variants.items()}


def _acceleration_svg(runs: Mapping[str, xr.Dataset], rigid: Mapping[str, xr.Dataset]) -> str:
    def overlay(axes: Axes, run: xr.Dataset, window: tuple[float, float]) -> None:
        for (level, arm), style in zip(rigid.items(), ("--", ":"), strict=True):
            part = signals.window(arm["time"].values, *window)
            time, acceleration = arm["time"].values[part], arm["theta_ddot"].values[part, 0]
            axes.plot(time, acceleration, style, color="k", label=f"rigid, {level}")

    strips = [
        Strip("θ_1'' [rad/s²]", lambda run: run["theta_ddot"].values[:, 0], window)
        for window in ((0.0, SHORT_S), *ZOOMS_S)
    ]
    return law_figure(runs, strips, overlay)


def _in_range(sizes: dict[str, float]) -> str:
    return by_law({law: in_range(size, *IMPACTS) for law, size in sizes.items()})


class Fluctuations(NamedTuple):
    """Sizes of the three fluctuations; onset and frequency of the third, None if there is none."""

    first_rad_per_s2: float
    second_rad_per_s2: float
    third_rad_per_s2: float
    onset_s: float | None
    frequency_Hz: float | None


def fluctuations(run: xr.Dataset, rigid: xr.Dataset) -> Fluctuations:
    """Of the shoulder, detailed less rigid; the rigid arm is smooth and may be interpolated."""
    time, excess = run["time"].values, excess_acceleration(run, rigid)[:, 0]
    third = events.third_window(time)
    windows = (*(signals.window(time, *impact) for impact in IMPACTS_S), third)
    first, second, largest = (signals.amplitude(excess[window]) for window in windows)
    sizes = (first, second, largest)
    if not fluctuates(largest):
        return Fluctuations(*sizes, None, None)
    onset = events.third_onset(time, excess, third)
    return Fluctuations(*sizes, onset, line(run, 0).frequency_Hz)


def figure_15(shelf: Shelf) -> Plate:
    """Error of the shoulder angle when both joints go back and forth."""
    variants = {b: driven_run(b) for b in DRIVEN_UM}
    baseline = rigid_run("back-and-forth", COUPLED)
    runs = shelf.runs([*variants.values(), baseline], 15)
    rigid = runs[baseline]
    time = rigid["time"].values
    errors = {
        b: runs[variant]["theta"].values[:, 0] - rigid["theta"].values[:, 0]
        for b, variant in variants.items()
    }
    sizes = {b: _quarters(error) for b, error in errors.items()}
    head = ("b [µm]", *(f"quarter {quarter}" for quarter in (1, 2, 3, 4)))
    ranked = [rises(list(DRIVEN_UM), [sizes[b][q] for b in DRIVEN_UM]) for q in range(4)]
    ordered = [number for number, yes in enumerate(ranked, start=1) if yes]
    per_size = [sizes[b][1] / b for b in DRIVEN_UM]
    spread = quotient(max(per_size), min(per_size))
    growth = [quotient(sizes[b][2], sizes[b][1]) for b in DRIVEN_UM]
    seen = (
        "Largest |Δθ_1| [rad] in each quarter of the run. The errors of different backlash rank by"
        f" b in these quarters: {', '.join(map(str, ordered)) or 'none'}. Divided by b they differ"
        f" by a factor of {shown(spread, '.2f')} in the second; from there to the third they grow"
        f" by factors of {shown(min(growth))} to {shown(max(growth))}. Torque in open loop draws"
        " nothing back: growth that does not depend on b is the arm's own sensitivity to any"
        " disturbance, which hypothesis H3 tests."
    )
    return Plate(
        15,
        "accumulated error when rotating back and forth",
        _error_svg(time, errors),
        "Driven by T = 2000 sin(20 pi sqrt(t)) on both joints, the arm accumulates an error that"
        " increases with the size of the backlash. Backlashes, duration and rigid reference are not"
        " given.",
        seen,
        conditions(runs[variants[50]], "b as in the legend; Δ: detailed less rigid (coupled)."),
        {
            "the error accumulates, every b": verdict(
                all_of(accumulates(size[0], size[-1]) for size in sizes.values())
            ),
            "the error increases with b, every quarter": verdict(all_of(ranked)),
            "while small it is proportional to b": verdict(proportional(spread)),
        },
        {
            "largest_rad": {f"b {b:g} um": s for b, s in sizes.items()},
            "spread": spread,
            "growth": growth,
        },
        table(head, [(b, *s) for b, s in sizes.items()]),
    )


def _quarters(error: np.ndarray) -> list[float]:
    return [signals.amplitude(part) for part in np.array_split(error, 4)]


def _error_svg(time: np.ndarray, errors: dict[float, np.ndarray]) -> str:
    figure, grid = new_figure(1, 2, 2.8)
    for (b, error), colour in zip(errors.items(), COLOURS, strict=False):
        grid[0, 0].plot(time, error, color=colour, label=f"b {b:g} µm")
        grid[0, 1].plot(time, np.maximum(np.abs(error), 1e-8), color=colour, linewidth=0.8)
    grid[0, 0].set(xlabel="time [s]", ylabel="Δθ_1 [rad]")
    grid[0, 1].set(xlabel="time [s]", ylabel="|Δθ_1| [rad]", yscale="log")
    legend(figure, grid[0, 0])
    return to_svg(figure)

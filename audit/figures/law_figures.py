"""Figures 8, 9 and 11 to 14: one quantity of a run in time, by every law of the mesh phase."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from pydantic import JsonValue

from crosscheck import signals
from crosscheck.audit.experiments.bands import ShoulderBands
from crosscheck.audit.experiments.experiments import CONSTANT, PD, SHORT_S, PaperExperiment
from crosscheck.audit.experiments.paper_conditions import INTEGRAL, Condition, Law
from crosscheck.audit.experiments.torque import RING_CYCLES
from crosscheck.audit.figures.figure_data import (
    BAND_BINS,
    LOW_ZETA,
    FigureData,
    make_start_variant,
)
from crosscheck.audit.figures.paper_figure import Drawing, PaperFigure
from crosscheck.audit.figures.plotting import MICRO, describe_run, draw_line, set_same_scale
from crosscheck.audit.measures.rigid import COUPLED, rigid_arm
from crosscheck.audit.measures.run_signals import RunSignals
from crosscheck.audit.measures.stage import paper_stage
from crosscheck.audit.measures.third_fluctuation import ThirdFluctuation
from crosscheck.audit.measures.thresholds import SEVERE
from crosscheck.audit.page.labels import DRAWN_NAMES
from crosscheck.models.experiment.scenario import ConstantDrive, expand_to_joints
from crosscheck.report.fragments import COLOURS
from crosscheck.report.plots.figures import draw_legend, make_figure, mark_not_reached, to_svg

# Windows [s]; of the side change and the third fluctuation a few periods of what happens there.
TORQUE_S = ((0.0, 0.5), (0.0, 0.01))
SIDE_S, THIRD_S = (0.345, 0.385), (1.10, 1.11)
WHOLE_S = ((0.0, 3.0), SIDE_S, THIRD_S)
TRANSIENT_S = ((0.0, SHORT_S), (0.0, 0.02), SIDE_S, THIRD_S)
RIGID_STYLES = {COUPLED: "--", "links": ":"}
SHADE = "#d9a400"  # of what is enlarged below
ALL_STARTS = "#b8c4d0"
Overlay = Callable[[Axes, tuple[float, float]], None]
Numbers = Mapping[str, JsonValue]


class LawFigure(NamedTuple):
    """A figure of one quantity of a Course times ``scale``; windows: of the rows [s], first wide.

    scale: the factor from SI units to the drawn one; more: said below the drawing; numbers: for the
    figure's words, of a run by INTEGRAL. With ``bands`` all starts are drawn behind the first row;
    without ``elbow`` the shoulder alone.
    """

    experiment: PaperExperiment
    quantity: str
    label: str
    windows: tuple[tuple[float, float], ...]
    scale: float = 1.0
    more: str = ""
    numbers: Callable[[RunSignals], Numbers] = lambda run: {}
    bands: bool = False
    elbow: bool = True


def static_numbers(run: RunSignals) -> dict[str, JsonValue]:
    """The displacement [um] by statics, and the largest frequency [Hz] at which teeth pass."""
    stage, drive = paper_stage(run.case.arm), run.case.scenario.drive
    assert isinstance(drive, ConstantDrive)
    torque = expand_to_joints(drive.torque_N_m, len(run.case.arm.joints))[0]
    force = torque / (stage.geometry.n * stage.joint.planet_count * stage.geometry.r_s)
    static = stage.backlash_m + force / stage.mesh_stiffness_N_per_m
    top = float(np.abs(run.theta_dot[:, 0]).max())
    return {"static_um": MICRO * static, "mesh_Hz": RING_CYCLES * top / (2 * np.pi)}


def braking_numbers(run: RunSignals) -> dict[str, JsonValue]:
    """Time [s] when the shoulder's torque first turns negative, as ``brakes_s``; None for never."""
    return {"brakes_s": signals.crossing_time_below(run.time, run.torque[:, 0], 0.0)}


_GREY = "Grey: between all starts (shoulder)."
_PER_PLANET = "Force per planet, without its damper."
FIGURES = {
    8: LawFigure(CONSTANT, "x_sp", "x_sp1 [µm]", TORQUE_S, MICRO, numbers=static_numbers),
    9: LawFigure(CONSTANT, "F_sp", "F_sp1 [N]", TORQUE_S, more=_PER_PLANET),
    11: LawFigure(PD, "torque", "T [N m]", WHOLE_S, 1.0, _GREY, braking_numbers, bands=True),
    12: LawFigure(PD, "x_sp", "x_sp1 [µm]", WHOLE_S, MICRO, _GREY, braking_numbers, bands=True),
    13: LawFigure(PD, "F_sp", "F_sp1 [N]", WHOLE_S, 1.0, _GREY, braking_numbers, bands=True),
    14: LawFigure(
        *(PD, "theta_ddot", "θ_1'' [rad/s²]", TRANSIENT_S),
        more="Grey: between all starts.",
        bands=True,
        elbow=False,
    ),
}


def draw_law_figure(data: FigureData, number: int, overlay: Overlay | None = None) -> PaperFigure:
    """The plate of one of FIGURES, by its number; overlay: draws more into every panel."""
    law_figure = FIGURES[number]
    runs = data.courses_by_law(number, law_figure.experiment, LOW_ZETA)
    bands = data.start_bands(LOW_ZETA, number) if law_figure.bands else {}
    integral_run = runs[INTEGRAL]
    caption = describe_run(integral_run, data.seed, law_figure.more)
    drawing = Drawing(_draw_laws(law_figure, runs, bands, overlay), caption)
    return PaperFigure(number, [drawing], LOW_ZETA, data.seed, law_figure.numbers(integral_run))


def _draw_laws(
    law_figure: LawFigure,
    runs: Mapping[Law, RunSignals],
    bands: Mapping[Law, ShoulderBands],
    overlay: Overlay | None,
) -> str:
    """Windows below each other, laws side by side, a scale per row, enlarged parts shaded; svg."""
    figure, grid = make_figure(len(law_figure.windows), len(runs), 1.9)
    for column, (law, run) in enumerate(runs.items()):
        grid[0, column].set_title(DRAWN_NAMES[law])
        grid[-1, column].set_xlabel("time [s]")
        if law in bands:
            time, bands_by_name, starts = bands[law]
            low, high = (
                law_figure.scale * np.array(values) for values in bands_by_name[law_figure.quantity]
            )
            name = f"between all {starts} starts"
            grid[0, column].fill_between(
                time, low, high, color=ALL_STARTS, linewidth=0.4, label=name
            )
        values = law_figure.scale * np.atleast_2d(getattr(run, law_figure.quantity).T)
        joints = values if law_figure.elbow else values[:1]
        for axes, window in zip(grid[:, column], law_figure.windows, strict=True):
            part = signals.window(run.time, *window)
            for joint, (signal, colour) in enumerate(zip(joints, COLOURS, strict=False), start=1):
                name = f"joint {joint}, one start" if len(joints) > 1 else "shoulder, one start"
                draw_line(axes, run.time[part], signal[part], name, colour, BAND_BINS)
            axes.set(ylabel=law_figure.label, xlim=window)
            if not run.time[part].size:
                mark_not_reached(axes)
            axes.locator_params(axis="x", nbins=5)
            if overlay is not None:
                overlay(axes, window)
        for zoom in law_figure.windows[1:]:
            grid[0, column].axvspan(*zoom, color=SHADE, alpha=0.35, linewidth=0)
    set_same_scale(grid)
    if len(grid[0, 0].get_legend_handles_labels()[1]) > 1:
        draw_legend(figure, grid[0, 0])
    return to_svg(figure)


def draw_figure_14(data: FigureData) -> PaperFigure:
    """The plate of Fig. 14: shoulder acceleration in 1.2 s, rigid arms, how many are severe."""
    variant = make_start_variant(PD, Condition(INTEGRAL, LOW_ZETA), data.seed)
    rigid = data.load_courses({level: rigid_arm(variant, level) for level in RIGID_STYLES}, 14)

    def draw_rigid_arms(axes: Axes, window: tuple[float, float]) -> None:
        for level, run in rigid.items():
            part, name = signals.window(run.time, *window), f"rigid, {level}"
            axes.plot(
                run.time[part], run.theta_ddot[part, 0], RIGID_STYLES[level], color="k", label=name
            )

    thirds = {
        law: ThirdFluctuation.from_samples(sample)
        for law, sample in data.samples_by_law(PD, LOW_ZETA).items()
    }
    severe: dict[str, JsonValue] = {  # of the starts that have a third fluctuation
        DRAWN_NAMES[law]: [third.severe_count, third.sizes.size] for law, third in thirds.items()
    }
    figure = draw_law_figure(data, 14, draw_rigid_arms)
    return replace(figure, numbers={"limit": SEVERE, "severe": severe})

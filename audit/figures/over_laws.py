"""Figures 8, 9 and 11 to 14: one quantity of a run in time, by every law of the mesh phase."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from pydantic import JsonValue

from crosscheck import signals
from crosscheck.audit.experiments.bands import Between
from crosscheck.audit.experiments.cells import INTEGRAL, Cell, Law
from crosscheck.audit.experiments.experiments import CONSTANT, PD, SHORT_S, Source
from crosscheck.audit.experiments.torque import RING_CYCLES
from crosscheck.audit.figures.plate import Drawing, Plate
from crosscheck.audit.figures.shelf import LOW_ZETA, Shelf, drawn
from crosscheck.audit.figures.views import MICRO, conditions, line, same_scale
from crosscheck.audit.measures.course import Course
from crosscheck.audit.measures.rigid import COUPLED, rigid_arm
from crosscheck.audit.measures.stage import paper_stage
from crosscheck.audit.measures.third import Third
from crosscheck.audit.measures.thresholds import SEVERE
from crosscheck.audit.page.words import LAW_NAMES
from crosscheck.models.experiment.scenario import ConstantDrive, per_joint
from crosscheck.report.fragments import COLOURS
from crosscheck.report.plots.figures import legend, new_figure, not_reached, to_svg

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

    source: Source
    quantity: str
    label: str
    windows: tuple[tuple[float, float], ...]
    scale: float = 1.0
    more: str = ""
    numbers: Callable[[Course], Numbers] = lambda run: {}
    bands: bool = False
    elbow: bool = True


def statics(run: Course) -> dict[str, JsonValue]:
    """The displacement [um] by statics, and the largest frequency [Hz] at which teeth pass."""
    stage, drive = paper_stage(run.case.arm), run.case.scenario.drive
    assert isinstance(drive, ConstantDrive)
    torque = per_joint(drive.torque_N_m, len(run.case.arm.joints))[0]
    force = torque / (stage.geometry.n * stage.joint.planet_count * stage.geometry.r_s)
    static = stage.backlash_m + force / stage.mesh_stiffness_N_per_m
    top = float(np.abs(run.theta_dot[:, 0]).max())
    return {"static_um": MICRO * static, "mesh_Hz": RING_CYCLES * top / (2 * np.pi)}


def braking(run: Course) -> dict[str, JsonValue]:
    """Time [s] when the shoulder's torque first turns negative, as ``brakes_s``; None for never."""
    return {"brakes_s": signals.first_below(run.time, run.torque[:, 0], 0.0)}


_GREY = "Grey: between all starts (shoulder)."
_PER_PLANET = "Force per planet, without its damper."
FIGURES = {
    8: LawFigure(CONSTANT, "x_sp", "x_sp1 [µm]", TORQUE_S, MICRO, numbers=statics),
    9: LawFigure(CONSTANT, "F_sp", "F_sp1 [N]", TORQUE_S, more=_PER_PLANET),
    11: LawFigure(PD, "torque", "T [N m]", WHOLE_S, 1.0, _GREY, braking, bands=True),
    12: LawFigure(PD, "x_sp", "x_sp1 [µm]", WHOLE_S, MICRO, _GREY, braking, bands=True),
    13: LawFigure(PD, "F_sp", "F_sp1 [N]", WHOLE_S, 1.0, _GREY, braking, bands=True),
    14: LawFigure(
        *(PD, "theta_ddot", "θ_1'' [rad/s²]", TRANSIENT_S),
        more="Grey: between all starts.",
        bands=True,
        elbow=False,
    ),
}


def over_laws(shelf: Shelf, number: int, overlay: Overlay | None = None) -> Plate:
    """The plate of one of FIGURES, by its number; overlay: draws more into every panel."""
    shown = FIGURES[number]
    runs = shelf.laws(number, shown.source, LOW_ZETA)
    bands = shelf.bands(LOW_ZETA, number) if shown.bands else {}
    own = runs[INTEGRAL]
    caption = conditions(own, shelf.seed, shown.more)
    drawing = Drawing(_svg(shown, runs, bands, overlay), caption)
    return Plate(number, [drawing], LOW_ZETA, shelf.seed, shown.numbers(own))


def _svg(
    shown: LawFigure,
    runs: Mapping[Law, Course],
    bands: Mapping[Law, Between],
    overlay: Overlay | None,
) -> str:
    """Windows below each other, laws side by side, a scale per row, enlarged parts shaded; svg."""
    figure, grid = new_figure(len(shown.windows), len(runs), 1.9)
    for column, (law, run) in enumerate(runs.items()):
        grid[0, column].set_title(LAW_NAMES[law])
        grid[-1, column].set_xlabel("time [s]")
        if law in bands:
            time, found, starts = bands[law]
            low, high = (shown.scale * np.array(values) for values in found[shown.quantity])
            name = f"between all {starts} starts"
            grid[0, column].fill_between(
                time, low, high, color=ALL_STARTS, linewidth=0.4, label=name
            )
        values = shown.scale * np.atleast_2d(getattr(run, shown.quantity).T)
        joints = values if shown.elbow else values[:1]
        for axes, window in zip(grid[:, column], shown.windows, strict=True):
            part = signals.window(run.time, *window)
            for joint, (own, colour) in enumerate(zip(joints, COLOURS, strict=False), start=1):
                name = f"joint {joint}, one start" if len(joints) > 1 else "shoulder, one start"
                line(axes, run.time[part], own[part], name, colour)
            axes.set(ylabel=shown.label, xlim=window)
            if not run.time[part].size:
                not_reached(axes)
            axes.locator_params(axis="x", nbins=5)
            if overlay is not None:
                overlay(axes, window)
        for zoom in shown.windows[1:]:
            grid[0, column].axvspan(*zoom, color=SHADE, alpha=0.35, linewidth=0)
    same_scale(grid)
    if len(grid[0, 0].get_legend_handles_labels()[1]) > 1:
        legend(figure, grid[0, 0])
    return to_svg(figure)


def figure_14(shelf: Shelf) -> Plate:
    """The plate of Fig. 14: shoulder acceleration in 1.2 s, rigid arms, how many are severe."""
    own = drawn(PD, Cell(INTEGRAL, LOW_ZETA), shelf.seed)
    rigid = shelf.courses({level: rigid_arm(own, level) for level in RIGID_STYLES}, 14)

    def overlay(axes: Axes, window: tuple[float, float]) -> None:
        for level, run in rigid.items():
            part, name = signals.window(run.time, *window), f"rigid, {level}"
            axes.plot(
                run.time[part], run.theta_ddot[part, 0], RIGID_STYLES[level], color="k", label=name
            )

    thirds = {law: Third.of(known[PD]) for law, known in shelf.known(LOW_ZETA).items()}
    severe: dict[str, JsonValue] = {  # of the starts that have a third fluctuation
        LAW_NAMES[law]: [int(one.of_branch(severe=True).sum()), one.sizes.size]
        for law, one in thirds.items()
    }
    plate = over_laws(shelf, 14, overlay)
    return replace(plate, numbers={"limit": SEVERE, "severe": severe})

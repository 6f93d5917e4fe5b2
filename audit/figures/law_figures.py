"""Figures 8, 9 and 11 to 14: one quantity of a run in time, by every law of the mesh phase."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from pydantic import JsonValue

from crosscheck import signals
from crosscheck.audit.experiments.experiments import CONSTANT, PD, SHORT_S, PaperExperiment
from crosscheck.audit.experiments.paper_conditions import INTEGRAL, Condition
from crosscheck.audit.experiments.samples import judge_third_fluctuation
from crosscheck.audit.experiments.torque import RING_CYCLES
from crosscheck.audit.experiments.variant import COUPLED, rigid_arm
from crosscheck.audit.figures.figure_data import (
    LOW_ZETA,
    Drawing,
    FigureData,
    PaperFigure,
    make_start_variant,
)
from crosscheck.audit.figures.plotting import (
    MICRO,
    Curve,
    Panel,
    describe_run,
    draw_panels,
)
from crosscheck.audit.measures.run_signals import RunSignals
from crosscheck.audit.measures.stage import paper_stage
from crosscheck.audit.measures.thresholds import SEVERE
from crosscheck.audit.page.chapter import DRAWN_NAMES
from crosscheck.models.experiment.scenario import ConstantDrive, expand_to_joints
from crosscheck.report.fragments import COLOURS

# Windows [s]; of the side change and the third fluctuation a few periods of what happens there.
TORQUE_S = ((0.0, 0.5), (0.0, 0.01))
SIDE_S, THIRD_S = (0.345, 0.385), (1.10, 1.11)
WHOLE_S = ((0.0, 3.0), SIDE_S, THIRD_S)
TRANSIENT_S = ((0.0, SHORT_S), (0.0, 0.02), SIDE_S, THIRD_S)
BAND_BINS = 300  # over a whole run: one of three panels has so many points of the page's width
RIGID_STYLES = {COUPLED: "--", "links": ":"}
Numbers = Mapping[str, JsonValue]


class LawFigure(NamedTuple):
    """A figure of one quantity of a Course times ``scale``; windows: of the rows [s], first wide.

    scale: the factor from SI units to the drawn one; more: said below the drawing; numbers: for the
    figure's words, of a run by INTEGRAL. Without ``elbow`` the shoulder alone is drawn.
    """

    experiment: PaperExperiment
    quantity: str
    label: str
    windows: tuple[tuple[float, float], ...]
    scale: float = 1.0
    more: str = ""
    numbers: Callable[[RunSignals], Numbers] = lambda run: {}
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


_PER_PLANET = "Force per planet, without its damper."
FIGURES = {
    8: LawFigure(CONSTANT, "x_sp", "x_sp1 [µm]", TORQUE_S, MICRO, numbers=static_numbers),
    9: LawFigure(CONSTANT, "F_sp", "F_sp1 [N]", TORQUE_S, more=_PER_PLANET),
    11: LawFigure(PD, "torque", "T [N m]", WHOLE_S),
    12: LawFigure(PD, "x_sp", "x_sp1 [µm]", WHOLE_S, MICRO, numbers=braking_numbers),
    13: LawFigure(PD, "F_sp", "F_sp1 [N]", WHOLE_S),
    14: LawFigure(PD, "theta_ddot", "θ_1'' [rad/s²]", TRANSIENT_S, elbow=False),
}


def draw_law_figure(
    data: FigureData, number: int, rigid: Mapping[str, RunSignals] | None = None
) -> PaperFigure:
    """The plate of one of FIGURES, by its number; rigid: arms whose acceleration is drawn as well.

    Windows stand below each other, laws side by side; enlarged parts are shaded.
    """
    law_figure = FIGURES[number]
    (runs,) = data.courses_by_law(number, law_figure.experiment)
    whole, *zooms = law_figure.windows
    top = [
        _draw_window(law_figure, run, rigid or {}, whole)._replace(shaded=zooms)
        for run in runs.values()
    ]
    below = [
        [_draw_window(law_figure, run, rigid or {}, zoom) for run in runs.values()]
        for zoom in zooms
    ]
    caption = describe_run(runs[INTEGRAL], data.seed, law_figure.more)
    drawing = Drawing(draw_panels(1.9, "time [s]", top, *below, by_law=True), caption)
    return PaperFigure(number, [drawing], LOW_ZETA, data.seed, law_figure.numbers(runs[INTEGRAL]))


def _draw_window(
    law_figure: LawFigure,
    run: RunSignals,
    rigid: Mapping[str, RunSignals],
    window: tuple[float, float],
) -> Panel:
    """The figure's quantity in a window [s] of a run, a curve a joint."""
    part = signals.window(run.time, *window)
    joints = law_figure.scale * np.atleast_2d(getattr(run, law_figure.quantity).T)
    both = law_figure.elbow and len(joints) > 1
    names = ("joint 1, one start", "joint 2, one start") if both else ("shoulder, one start",)
    curves = [
        Curve(run.time[part], values[part], colour, name, width=1.0, bins=BAND_BINS)
        for values, name, colour in zip(joints, names, COLOURS, strict=False)
    ]
    for level, arm in rigid.items():
        inside = signals.window(arm.time, *window)
        acceleration = arm.theta_ddot[inside, 0]
        label, style = f"rigid, {level}", RIGID_STYLES[level]
        curves.append(Curve(arm.time[inside], acceleration, "k", label, style))
    return Panel(curves, {"ylabel": law_figure.label, "xlim": window})


def draw_figure_14(data: FigureData) -> PaperFigure:
    """The plate of Fig. 14: shoulder acceleration in 1.2 s, rigid arms, how many are severe."""
    variant = make_start_variant(PD, Condition(INTEGRAL, LOW_ZETA), data.seed)
    rigid = data.load_courses({level: rigid_arm(variant, level) for level in RIGID_STYLES}, 14)
    severe: dict[str, JsonValue] = {}  # of the starts that have a third fluctuation
    for law, sample in data.samples_by_law(PD).items():
        answer = judge_third_fluctuation(sample)
        severe[DRAWN_NAMES[law]] = [answer.yes, len(answer.values)]
    figure = draw_law_figure(data, 14, rigid)
    return replace(figure, numbers={"limit": SEVERE, "severe": severe})

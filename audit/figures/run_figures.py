"""Figures 6 to 15: joint angles and speeds beside rigid arms, and runs by every law of the mesh."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from pydantic import JsonValue, TypeAdapter

from crosscheck import signals
from crosscheck.audit.claims import study_plan
from crosscheck.audit.experiments import experiments as run
from crosscheck.audit.experiments.paper_conditions import INTEGRAL, Condition
from crosscheck.audit.experiments.samples import judge_third_fluctuation
from crosscheck.audit.experiments.torque import RING_CYCLES
from crosscheck.audit.experiments.variant import COUPLED, Variant, rigid_arm, rigid_model
from crosscheck.audit.figures import figure_data
from crosscheck.audit.figures.figure_data import (
    FIGURES_FILE,
    LOW_ZETA,
    ZETA,
    Drawing,
    FigureData,
    PaperFigure,
)
from crosscheck.audit.figures.plotting import MICRO, Curve, Panel, describe_run, draw_panels
from crosscheck.audit.measures.run_signals import RunSignals
from crosscheck.audit.measures.stage import paper_stage
from crosscheck.audit.measures.thresholds import SEVERE
from crosscheck.audit.page.chapter import DRAWN_NAMES
from crosscheck.models.experiment.scenario import ConstantDrive, expand_to_joints
from crosscheck.models.files import read_toml
from crosscheck.registry import RIGID_LEVELS
from crosscheck.report.fragments import COLOURS

SMOOTH_RECORD = 20  # 0.2 ms: for angles and speeds, which have nothing at mesh frequencies
SMALLEST, SMALLEST_RAD = 1e-9, 1e-8  # of what is drawn on a logarithmic scale: Figs. 6 and 7; 15
GAINS = (1000.0, 400.0)  # P and D of Section 3.2
# Fig. 10's, with the other of GAINS; the text gives none but these.
PROPORTIONAL, DERIVATIVE = (500.0, 1000.0, 2000.0), (200.0, 400.0, 800.0)
GAIN_STEP_S = 5e-5  # enough for angles that are drawn
TARGET_RAD = np.pi / 6
BAND_BINS = 300  # over a whole run: one of three panels has so many points of the page's width
RIGID_STYLES = {COUPLED: "--", "links": ":"}
Numbers = Mapping[str, JsonValue]


def draw_deviations(data: FigureData, number: int, quantity: str, label: str) -> PaperFigure:
    """The plate of how far a joint quantity of the detailed arm is off that of every rigid one."""
    variants = {"geared": make_smooth_variant(data, run.CONSTANT)}
    variants |= {level: make_rigid_variant("constant-torque", level) for level in RIGID_LEVELS}
    runs = data.load_courses(variants, number)
    geared = runs.pop("geared")
    values = getattr(geared, quantity)
    gaps = {level: values - getattr(rigid, quantity) for level, rigid in runs.items()}
    curves = [
        Curve(geared.time, gap[:, joint], colour, f"{level}, joint {joint + 1}", style)
        for (level, gap), colour in zip(gaps.items(), COLOURS, strict=False)
        for joint, style in enumerate(("-", "--"))
    ]
    caption = describe_run(geared, data.seed, "Δ: detailed less rigid, one curve per rigid arm.")
    drawing = Drawing(draw_both_scales(3.0, curves, label, SMALLEST), caption)
    largest = {level: np.abs(gap).max(axis=0).tolist() for level, gap in gaps.items()}
    return PaperFigure(number, [drawing], ZETA, data.seed, {"largest": largest})


def draw_both_scales(height: float, curves: Sequence[Curve], label: str, smallest: float) -> str:
    """Differences over time, and their magnitudes from the smallest on, logarithmic; as svg."""
    sizes = [curve._replace(y=np.maximum(np.abs(curve.y), smallest)) for curve in curves]
    magnitudes = Panel(sizes, {"ylabel": "|{}| {}".format(*label.split())}, log=True)
    return draw_panels(height, "time [s]", [Panel(curves, {"ylabel": label}), magnitudes])


def draw_figure_15(data: FigureData) -> PaperFigure:
    """The plate of Fig. 15: the shoulder angle's error when both joints go back and forth."""
    runs = data.load_courses(
        {b: make_smooth_variant(data, run.BACK(b)) for b in study_plan.FULL.back}, 15
    )
    variant = make_rigid_variant("back-and-forth", COUPLED)
    rigid = data.load_courses({"rigid": variant}, 15)["rigid"]
    curves = [
        Curve(rigid.time, each.theta[:, 0] - rigid.theta[:, 0], colour, f"b {b:g} µm")
        for (b, each), colour in zip(runs.items(), COLOURS, strict=False)
    ]
    more = "b as in the legend; Δ: detailed less rigid (coupled)."
    caption = describe_run(runs[run.DEFAULT_B_UM], data.seed, more)
    drawing = Drawing(draw_both_scales(2.8, curves, "Δθ_1 [rad]", SMALLEST_RAD), caption)
    return PaperFigure(15, [drawing], ZETA, data.seed)


def make_smooth_variant(data: FigureData, experiment: run.PaperExperiment) -> Variant:
    """The drawn start of an experiment as the gears are, recorded seldom."""
    condition = Condition(INTEGRAL, ZETA)
    return figure_data.make_start_variant(experiment, condition, data.seed, SMOOTH_RECORD)


def make_rigid_variant(scenario: str, level: str) -> Variant:
    """The variant of a rigid arm at a level, recorded on the grid of the smooth runs."""
    return Variant(scenario, model=rigid_model(level), record_every=SMOOTH_RECORD)


def draw_figure_10(data: FigureData) -> PaperFigure:
    """The plate of Fig. 10: P varies in (a), (b), D in (c), (d); shoulder and elbow."""
    paper, variants = make_smooth_variant(data, run.PD), {}
    for gains in [*((p, GAINS[1]) for p in PROPORTIONAL), *((GAINS[0], d) for d in DERIVATIVE)]:
        settings = (
            f"scenario.step_s={GAIN_STEP_S!r}",
            f"scenario.drive.proportional_N_m_per_rad={gains[0]!r}",
            f"scenario.drive.derivative_N_m_s_per_rad={gains[1]!r}",
        )
        variants[gains] = replace(paper, settings=settings)
    runs = data.load_courses(variants, 10)
    names, rows = iter("abcd"), list[list[Panel]]()
    for varied, letter in enumerate("PD"):
        fixed = GAINS[1 - varied]
        chosen = {g[varied]: each for g, each in runs.items() if g[1 - varied] == fixed}
        rows.append([])
        for joint, name in enumerate(("shoulder", "elbow")):
            curves = [
                Curve(each.time, np.degrees(each.theta[:, joint]), colour, f"{letter} = {gain:g}")
                for (gain, each), colour in zip(chosen.items(), COLOURS, strict=False)
            ]
            ends = next(iter(chosen.values())).time[[0, -1]]
            target = Curve(ends, np.degrees([TARGET_RAD] * 2), "k", None, ":", 0.6)
            title = f"({next(names)}) {name}, {'DP'[varied]} = {fixed:g}"
            rows[-1].append(Panel([*curves, target], {"ylabel": "angle [deg]", "title": title}))
    caption = describe_run(runs[GAINS], data.seed, "Other gains as in the legend.")
    drawing = Drawing(draw_panels(2.3, "time [s]", *rows), caption)
    return PaperFigure(10, [drawing], ZETA, data.seed)


class LawFigure(NamedTuple):
    """A figure of one quantity of a run, as in the file; without ``elbow`` the shoulder's alone."""

    experiment: str
    quantity: str
    label: str
    windows: tuple[tuple[float, float], ...]
    scale: float = 1.0
    more: str = ""
    numbers: str = ""
    elbow: bool = True


def static_numbers(run: RunSignals) -> Numbers:
    """The displacement [um] by statics, and the largest frequency [Hz] at which teeth pass."""
    stage, drive = paper_stage(run.case.arm), run.case.scenario.drive
    assert isinstance(drive, ConstantDrive)
    torque = expand_to_joints(drive.torque_N_m, len(run.case.arm.joints))[0]
    force = torque / (stage.geometry.n * stage.joint.planet_count * stage.geometry.r_s)
    static = stage.backlash_m + force / stage.mesh_stiffness_N_per_m
    top = float(np.abs(run.theta_dot[:, 0]).max())
    return {"static_um": MICRO * static, "mesh_Hz": RING_CYCLES * top / (2 * np.pi)}


def braking_numbers(run: RunSignals) -> Numbers:
    """Time [s] when the shoulder's torque first turns negative, as ``brakes_s``; None for never."""
    return {"brakes_s": signals.crossing_time_below(run.time, run.torque[:, 0], 0.0)}


NUMBERS: dict[str, Callable[[RunSignals], Numbers]] = {
    "": lambda run: {},
    "static": static_numbers,
    "braking": braking_numbers,
}
FIGURES = TypeAdapter(dict[int, LawFigure]).validate_python(read_toml(FIGURES_FILE)["laws"])


def draw_law_figure(
    data: FigureData, number: int, rigid: Mapping[str, RunSignals] | None = None
) -> PaperFigure:
    """The plate of one of FIGURES, by its number; rigid: arms whose acceleration is drawn as well.

    Windows stand below each other, laws side by side; enlarged parts are shaded.
    """
    law_figure = FIGURES[number]
    (runs,) = data.courses_by_law(number, run.EXPERIMENTS[law_figure.experiment])
    rows = [
        [_draw_window(law_figure, each, rigid or {}, window) for each in runs.values()]
        for window in law_figure.windows
    ]
    rows[0] = [panel._replace(shaded=law_figure.windows[1:]) for panel in rows[0]]
    caption = describe_run(runs[INTEGRAL], data.seed, law_figure.more)
    drawing = Drawing(draw_panels(1.9, "time [s]", *rows, by_law=True), caption)
    numbers = NUMBERS[law_figure.numbers](runs[INTEGRAL])
    return PaperFigure(number, [drawing], LOW_ZETA, data.seed, numbers)


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
    variant = figure_data.make_start_variant(run.PD, Condition(INTEGRAL, LOW_ZETA), data.seed)
    rigid = data.load_courses({level: rigid_arm(variant, level) for level in RIGID_STYLES}, 14)
    severe: dict[str, JsonValue] = {}  # of the starts that have a third fluctuation
    for law, sample in data.samples_by_law(run.PD).items():
        answer = judge_third_fluctuation(sample)
        severe[DRAWN_NAMES[law]] = [answer.yes, len(answer.values)]
    figure = draw_law_figure(data, 14, rigid)
    return replace(figure, numbers={"limit": SEVERE, "severe": severe})

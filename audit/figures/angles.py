"""Figures 6, 7, 10 and 15: joint angles and speeds beside rigid arms, and with other gains."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from crosscheck.audit.experiments.experiments import BACK, CONSTANT, DEFAULT_B_UM, PD
from crosscheck.audit.experiments.paper_conditions import INTEGRAL, Condition
from crosscheck.audit.experiments.variant import COUPLED
from crosscheck.audit.figures.figure_data import (
    SMOOTH_RECORD,
    ZETA,
    Drawing,
    FigureData,
    PaperFigure,
    make_rigid_variant,
    make_start_variant,
)
from crosscheck.audit.figures.plotting import Curve, Panel, describe_run, draw_panels
from crosscheck.audit.measures.run_signals import RunSignals
from crosscheck.registry import RIGID_LEVELS
from crosscheck.report.fragments import COLOURS

SMALLEST, SMALLEST_RAD = 1e-9, 1e-8  # of what is drawn on a logarithmic scale: Figs. 6 and 7; 15
PROPORTIONAL = (500.0, 1000.0, 2000.0)  # Fig. 10, with D = 400; only 1000 is the paper's
DERIVATIVE = (200.0, 400.0, 800.0)  # with P = 1000; only 400 is the paper's
GAINS = (1000.0, 400.0)  # Section 3.2
GAIN_STEP_S = 5e-5  # enough for angles that are drawn
TARGET_RAD = np.pi / 6


def draw_deviations(
    data: FigureData, number: int, quantity: str, symbol: str, unit: str
) -> PaperFigure:
    """The plate of how far a joint quantity of the detailed arm is off that of every rigid one.

    Drawn on a plain scale, and on a logarithmic one.
    """
    geared_variant = make_start_variant(
        CONSTANT, Condition(INTEGRAL, ZETA), data.seed, SMOOTH_RECORD
    )
    levels = {level: make_rigid_variant("constant-torque", level) for level in RIGID_LEVELS}
    runs = data.load_courses({"geared": geared_variant, **levels}, number)
    geared = runs.pop("geared")
    plain, sizes = list[Curve](), list[Curve]()
    largest = {}
    for (level, rigid), colour in zip(runs.items(), COLOURS, strict=False):
        gap = getattr(geared, quantity) - getattr(rigid, quantity)
        largest[level] = np.abs(gap).max(axis=0).tolist()
        for joint, style in enumerate(("-", "--")):
            size = np.maximum(np.abs(gap[:, joint]), SMALLEST)
            label = f"{level}, joint {joint + 1}"
            plain.append(Curve(geared.time, gap[:, joint], colour, label, style))
            sizes.append(Curve(geared.time, size, colour, label, style))
    caption = describe_run(geared, data.seed, "Δ: detailed less rigid, one curve per rigid arm.")
    drawing = Drawing(_draw_both_scales(3.0, plain, sizes, symbol, unit), caption)
    return PaperFigure(number, [drawing], ZETA, data.seed, {"largest": largest})


def _draw_both_scales(
    height: float, plain: list[Curve], sizes: list[Curve], symbol: str, unit: str
) -> str:
    """Differences over time, and their magnitudes on a logarithmic scale, as svg."""
    magnitudes = Panel(sizes, {"ylabel": f"|{symbol}| [{unit}]"}, log=True)
    return draw_panels(
        height, "time [s]", [Panel(plain, {"ylabel": f"{symbol} [{unit}]"}), magnitudes]
    )


def draw_figure_15(data: FigureData) -> PaperFigure:
    """The plate of Fig. 15: the shoulder angle's error when both joints go back and forth."""
    condition = Condition(INTEGRAL, ZETA)
    variants = {
        b: make_start_variant(BACK(b), condition, data.seed, SMOOTH_RECORD) for b in data.plan.back
    }
    rigid_arm = {"rigid": make_rigid_variant("back-and-forth", COUPLED)}
    runs = data.load_courses(variants, 15)
    rigid = data.load_courses(rigid_arm, 15)["rigid"]
    plain, sizes = list[Curve](), list[Curve]()
    for (b, run), colour in zip(runs.items(), COLOURS, strict=False):
        error = run.theta[:, 0] - rigid.theta[:, 0]
        size = np.maximum(np.abs(error), SMALLEST_RAD)
        plain.append(Curve(rigid.time, error, colour, f"b {b:g} µm"))
        sizes.append(Curve(rigid.time, size, colour, width=0.8))
    more = "b as in the legend; Δ: detailed less rigid (coupled)."
    caption = describe_run(runs[DEFAULT_B_UM], data.seed, more)
    svg = _draw_both_scales(2.8, plain, sizes, "Δθ_1", "rad")
    return PaperFigure(15, [Drawing(svg, caption)], ZETA, data.seed)


def draw_figure_10(data: FigureData) -> PaperFigure:
    """The plate of Fig. 10: joint angles under PD control with several gains."""
    paper = make_start_variant(PD, Condition(INTEGRAL, ZETA), data.seed, SMOOTH_RECORD)
    gains = [*((p, GAINS[1]) for p in PROPORTIONAL), *((GAINS[0], d) for d in DERIVATIVE)]
    variants = {}
    for gain in gains:
        proportional, derivative = gain
        settings = (
            f"scenario.step_s={GAIN_STEP_S!r}",
            f"scenario.drive.proportional_N_m_per_rad={proportional!r}",
            f"scenario.drive.derivative_N_m_s_per_rad={derivative!r}",
        )
        variants[gain] = replace(paper, settings=settings)
    runs = data.load_courses(variants, 10)
    caption = describe_run(runs[GAINS], data.seed, "Other gains as in the legend.")
    return PaperFigure(10, [Drawing(_draw_gains(runs), caption)], ZETA, data.seed)


def _draw_gains(runs: Mapping[tuple[float, float], RunSignals]) -> str:
    """Joint angles as svg: (a), (b): P varies, shoulder and elbow; (c), (d): D varies."""
    names, rows = iter("abcd"), list[list[Panel]]()
    for varied, letter in enumerate("PD"):
        fixed = GAINS[1 - varied]
        chosen = {gain[varied]: run for gain, run in runs.items() if gain[1 - varied] == fixed}
        row = list[Panel]()
        for joint, name in enumerate(("shoulder", "elbow")):
            curves = [
                Curve(run.time, np.degrees(run.theta[:, joint]), colour, f"{letter} = {gain:g}")
                for (gain, run), colour in zip(chosen.items(), COLOURS, strict=False)
            ]
            run = next(iter(chosen.values()))
            target = Curve(run.time[[0, -1]], np.degrees([TARGET_RAD] * 2), "k", None, ":", 0.6)
            title = f"({next(names)}) {name}, {'DP'[varied]} = {fixed:g}"
            row.append(Panel([*curves, target], {"ylabel": "angle [deg]", "title": title}))
        rows.append(row)
    return draw_panels(2.3, "time [s]", *rows)

"""Figures 6 to 9 and 15: torques that no controller sets, constant or back and forth."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from crosscheck.audit.experiments.cells import INTEGRAL, Cell
from crosscheck.audit.experiments.experiments import BACK, CONSTANT, DEFAULT_B_UM
from crosscheck.audit.experiments.torque import RING_CYCLES
from crosscheck.audit.figures.plate import Drawing, Plate
from crosscheck.audit.figures.runs import LOW_ZETA, SMOOTH_RECORD, ZETA, drawn, rigid_run
from crosscheck.audit.figures.shelf import Shelf
from crosscheck.audit.figures.views import MICRO, Strip, conditions, law_figure
from crosscheck.audit.measures.course import Course
from crosscheck.audit.measures.rigid import COUPLED
from crosscheck.audit.measures.stage import paper_stage
from crosscheck.models.experiment.scenario import ConstantDrive, per_joint
from crosscheck.registry import RIGID_LEVELS
from crosscheck.report.fragments import COLOURS
from crosscheck.report.plots.figures import legend, new_figure, to_svg

SMALLEST = 1e-9  # of what is drawn on a logarithmic scale
FIRST_S, ALL_S = (0.0, 0.01), (0.0, 0.5)
SMALLEST_RAD = 1e-8  # of what is drawn


def deviations(shelf: Shelf, number: int, quantity: str, symbol: str, unit: str) -> Plate:
    """What a joint quantity of the detailed arm is off that of every rigid one."""
    own = drawn(CONSTANT, Cell(INTEGRAL, ZETA), shelf.seed, SMOOTH_RECORD)
    levels = {level: rigid_run("constant-torque", level) for level in RIGID_LEVELS}
    runs = shelf.courses([own, *levels.values()], number)
    geared = runs[own]
    gaps = {
        level: getattr(geared, quantity) - getattr(runs[variant], quantity)
        for level, variant in levels.items()
    }
    caption = conditions(geared, shelf.seed, "Δ: detailed less rigid, one curve per rigid arm.")
    drawing = Drawing(_deviation_svg(geared.time, gaps, symbol, unit), caption)
    largest = {level: np.abs(gap).max(axis=0).tolist() for level, gap in gaps.items()}
    return Plate(number, [drawing], ZETA, shelf.seed, {"largest": largest})


def _deviation_svg(time: np.ndarray, gaps: Mapping[str, np.ndarray], symbol: str, unit: str) -> str:
    """On a plain scale against every level that lacks inertia; all on a logarithmic one."""
    figure, grid = new_figure(1, 2, 3.0)
    left, right = grid[0]
    for (level, gap), colour in zip(gaps.items(), COLOURS, strict=False):
        for joint, style in enumerate(("-", "--")):
            size = np.maximum(np.abs(gap[:, joint]), SMALLEST)
            right.plot(time, size, style, color=colour, label=f"{level}, joint {joint + 1}")
            left.plot(time, gap[:, joint], style, color=colour)
    left.set(xlabel="time [s]", ylabel=f"{symbol} [{unit}]")
    right.set(xlabel="time [s]", ylabel=f"|{symbol}| [{unit}]", yscale="log")
    legend(figure, right)
    return to_svg(figure)


def figure_8(shelf: Shelf) -> Plate:
    """x_sp1 under constant torque."""
    runs = shelf.laws(8, CONSTANT, LOW_ZETA)
    strips = [Strip("x_sp1 [µm]", "x_sp", window, MICRO) for window in (ALL_S, FIRST_S)]
    drawing = Drawing(law_figure(runs, strips), conditions(runs[INTEGRAL], shelf.seed))
    return Plate(8, [drawing], LOW_ZETA, shelf.seed, statics(runs[INTEGRAL]))


def statics(run: Course) -> dict[str, float]:
    """Where statics have the displacement [um], and the teeth's largest frequency [Hz]."""
    stage, drive = paper_stage(run.case.arm), run.case.scenario.drive
    assert isinstance(drive, ConstantDrive)
    torque = per_joint(drive.torque_N_m, len(run.case.arm.joints))[0]
    force = torque / (stage.geometry.n * stage.joint.planet_count * stage.geometry.r_s)
    static = stage.backlash_m + force / stage.mesh_stiffness_N_per_m
    top = float(np.abs(run.theta_dot[:, 0]).max())
    return {"static_um": MICRO * static, "mesh_Hz": RING_CYCLES * top / (2 * np.pi)}


def figure_9(shelf: Shelf) -> Plate:
    """F_sp1 under constant torque."""
    runs = shelf.laws(9, CONSTANT, LOW_ZETA)
    strips = [Strip("F_sp1 [N]", "F_sp", window) for window in (ALL_S, FIRST_S)]
    caption = conditions(runs[INTEGRAL], shelf.seed, "Force per planet, without its damper.")
    return Plate(9, [Drawing(law_figure(runs, strips), caption)], LOW_ZETA, shelf.seed)


def figure_15(shelf: Shelf) -> Plate:
    """Error of the shoulder angle when both joints go back and forth."""
    cell = Cell(INTEGRAL, ZETA)
    variants = {b: drawn(BACK(b), cell, shelf.seed, SMOOTH_RECORD) for b in shelf.plan.back}
    baseline = rigid_run("back-and-forth", COUPLED)
    runs = shelf.courses([*variants.values(), baseline], 15)
    rigid = runs[baseline]
    errors = {b: runs[one].theta[:, 0] - rigid.theta[:, 0] for b, one in variants.items()}
    more = "b as in the legend; Δ: detailed less rigid (coupled)."
    caption = conditions(runs[variants[DEFAULT_B_UM]], shelf.seed, more)
    return Plate(15, [Drawing(_svg(rigid.time, errors), caption)], ZETA, shelf.seed)


def _svg(time: np.ndarray, errors: Mapping[float, np.ndarray]) -> str:
    figure, grid = new_figure(1, 2, 2.8)
    for (b, error), colour in zip(errors.items(), COLOURS, strict=False):
        grid[0, 0].plot(time, error, color=colour, label=f"b {b:g} µm")
        size = np.maximum(np.abs(error), SMALLEST_RAD)
        grid[0, 1].plot(time, size, color=colour, linewidth=0.8)
    grid[0, 0].set(xlabel="time [s]", ylabel="Δθ_1 [rad]")
    grid[0, 1].set(xlabel="time [s]", ylabel="|Δθ_1| [rad]", yscale="log")
    legend(figure, grid[0, 0])
    return to_svg(figure)

"""The page's second chapter: the words that the others use, with pictures."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle, Polygon

from crosscheck.audit.experiments import ensembles, paper_conditions, torque
from crosscheck.audit.experiments.variant import Variant
from crosscheck.audit.figures.plotting import LAW_COLOURS
from crosscheck.audit.measures import rigid, run_signals, stage
from crosscheck.audit.page.chapter import AuditChapter
from crosscheck.audit.page.context import AuditContext
from crosscheck.audit.page.labels import LAW_MEANINGS, LAW_NAMES
from crosscheck.audit.page.text import render_template, to_markup
from crosscheck.models.arm.arm import Planetary
from crosscheck.models.loading import load_arm
from crosscheck.report.fragments import COLOURS
from crosscheck.report.plots.figures import draw_legend, make_figure, to_svg
from crosscheck.view.mesh_geometry import MeshGeometry, Wheel, mesh_geometry, teeth

MILLI = 1e3
SUN, PLANET, RING, CARRIER = COLOURS[0], COLOURS[1], COLOURS[5], COLOURS[2]
ID, TITLE = "terms", "The arm, and the words of this page"
TURN = 2 * np.pi


def build_chapter(context: AuditContext) -> AuditChapter:
    """The chapter on the stage, terms and phase laws."""
    tooth_counts = count_teeth(context)
    most = {
        "most_by_angle": float(tooth_counts.angle.max()),
        "most_by_clock": float(tooth_counts.clock.max()),
    }
    page = render_template(
        "front/terms",
        backwards=bool(((tooth_counts.clock_rate < 0) & (tooth_counts.rate > 0)).any()),
        stage_svg=to_markup(
            draw_stage(stage.paper_stage(load_arm(paper_conditions.LABELLED)).joint)
        ),
        passed_svg=to_markup(draw_tooth_counts(tooth_counts)),
        names=LAW_NAMES,
        meanings=LAW_MEANINGS,
        first=ensembles.FIRST,
        alike=ensembles.ALIKE,
        **most,
    )
    records = [{"id": "terms/teeth-passed", **most}]
    return AuditChapter(ID, TITLE, page, records, render_template("front/terms-outcome"))


class ToothCounts(NamedTuple):
    """The teeth that pass the shoulder's mesh, (times,): how many, and how many a second.

    angle, rate: as they pass, z_r theta and its rate; clock, clock_rate: z_r theta' t and its rate.
    """

    time: np.ndarray
    angle: np.ndarray
    rate: np.ndarray
    clock: np.ndarray
    clock_rate: np.ndarray


def count_teeth(context: AuditContext) -> ToothCounts:
    """The teeth passed in the rigid arm's PD run, which has no vibration. Raises Diverged."""
    variant = context.scale.cut(rigid.rigid_arm(Variant()))
    run = run_signals.extract_signals(
        context.study.run_variants([variant], "teeth that pass")[variant]
    )
    time, factor = run.time, torque.RING_CYCLES / TURN
    theta, speed, acceleration = (
        signal[:, 0] for signal in (run.theta, run.theta_dot, run.theta_ddot)
    )
    return ToothCounts(
        time,
        factor * theta,
        factor * speed,
        factor * speed * time,
        factor * (speed + acceleration * time),
    )


def draw_stage(joint: Planetary) -> str:
    """A stage seen along its axis: sun, planets on their carrier, ring, meshes marked; svg."""
    inner, outer = mesh_geometry(joint, "sun"), mesh_geometry(joint, "ring")
    figure, grid = make_figure(1, 1, 4.2)
    axes = grid[0, 0]
    _draw_gear(axes, inner, inner.wheel, SUN, 1.0)
    _draw_gear(axes, outer, outer.wheel, RING, 1.0)
    for turn in np.exp(2j * np.pi * np.arange(joint.planet_count) / joint.planet_count):
        _draw_gear(axes, inner, inner.planet, PLANET, turn)
        centre = turn * inner.planet.centre * MILLI
        axes.plot([0, centre.real], [0, centre.imag], color=CARRIER, lw=5, solid_capstyle="round")
        for mesh in (inner, outer):
            at = turn * mesh.pitch_point * MILLI
            axes.plot(at.real, at.imag, "o", ms=8, mfc="none", mec="k", mew=1.4)
    _draw_labels(axes, inner, outer)
    axes.set_aspect("equal")
    axes.axis("off")
    return to_svg(figure)


def _draw_gear(axes: Axes, mesh: MeshGeometry, wheel: Wheel, colour: str, turn: complex) -> None:
    """Draw all teeth of a wheel and the circle below them, turned about the sun's axis."""
    outline = teeth(mesh, wheel, 0)[0] - wheel.centre
    for angle in np.exp(2j * np.pi * np.arange(wheel.teeth) / wheel.teeth):
        points = MILLI * turn * (wheel.centre + angle * outline)
        xy = np.column_stack([points.real, points.imag])
        axes.add_patch(Polygon(xy, closed=True, fc=colour, ec="none", alpha=0.55))
    centre = MILLI * turn * wheel.centre
    foot = MILLI * wheel.radii[1]
    axes.add_patch(
        Circle((centre.real, centre.imag), foot, fill=not wheel.internal, fc=colour, ec=colour,
               alpha=0.25)
    )  # fmt: skip


def _draw_labels(axes: Axes, inner: MeshGeometry, outer: MeshGeometry) -> None:
    """Draw the names, and what each mesh's displacement and force are called."""
    planet = MILLI * inner.planet.centre
    reach = MILLI * outer.wheel.radii[1]
    for x, y, name, colour in (
        (-14, 0, "sun", SUN),
        (planet.real, 16, "planet", PLANET),
        (-0.95 * planet.real, 0, "carrier\n(next link)", CARRIER),
        (0, reach + 8, "ring (previous body)", RING),
    ):
        axes.text(x, y, name, color=colour, ha="center", va="center", fontweight="bold")
    for mesh, name in ((inner, "sun mesh:\nx_sp, F_sp"), (outer, "ring mesh:\nx_pr, F_pr")):
        at = MILLI * mesh.pitch_point
        axes.annotate(
            name, (at.real, at.imag), (reach + 34, 60 if mesh is inner else -60),
            arrowprops={"arrowstyle": "->"}, ha="center",
        )  # fmt: skip
    axes.set(xlim=(-reach - 12, reach + 66), ylim=(-reach - 12, reach + 18))


def draw_tooth_counts(tooth_counts: ToothCounts) -> str:
    """How many teeth have passed, and how fast: counted, and by the paper's formula; svg."""
    figure, grid = make_figure(1, 2, 2.6)
    counted, by_clock = LAW_COLOURS[paper_conditions.LAWS[2]], LAW_COLOURS[paper_conditions.LAWS[0]]
    for axes, integral, clock in (
        (grid[0, 0], tooth_counts.angle, tooth_counts.clock),
        (grid[0, 1], tooth_counts.rate, tooth_counts.clock_rate),
    ):
        axes.plot(tooth_counts.time, integral, color=counted, label="teeth that pass: z_r θ")
        axes.plot(tooth_counts.time, clock, color=by_clock, label="the paper's formula: z_r θ' t")
        axes.set_xlabel("time [s]")
    grid[0, 0].set_ylabel("teeth passed [1]")
    grid[0, 1].set_ylabel("teeth per second [1/s]")
    draw_legend(figure, grid[0, 0])
    return to_svg(figure)

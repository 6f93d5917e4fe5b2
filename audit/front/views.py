"""The pictures of the page's beginning."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle, Polygon

from crosscheck.audit.experiments.cells import LAWS
from crosscheck.audit.figures.views import LAW_COLOURS
from crosscheck.audit.front.findings import Thirds
from crosscheck.audit.front.terms import TeethPassed
from crosscheck.audit.measures.thresholds import SEVERE
from crosscheck.audit.page.words import LAW_NAMES
from crosscheck.audit.phase.clock import RUN_WINDOW_S, Clocks
from crosscheck.audit.phase.page.views import within
from crosscheck.models.arm.arm import Planetary
from crosscheck.report.figures import legend, log_y, new_figure, to_svg
from crosscheck.report.fragments import COLOURS
from crosscheck.view.mesh_geometry import MeshGeometry, Wheel, mesh_geometry, teeth

MILLI = 1e3
PAPER_THIRD = 300.0  # rad/s^2, Section 3.2
FAINTEST = 0.1  # rad/s^2: smaller fluctuations are drawn there
PLANET_NAMES = {"free": "planets free", "lumped": "planets lumped"}
SUN, PLANET, RING, CARRIER = COLOURS[0], COLOURS[1], COLOURS[5], COLOURS[2]


def clock_svg(found: Clocks) -> str:
    """Runs from rest: one start's acceleration for every clock, and what every start reaches."""
    figure, grid = new_figure(2, len(found.laws), 2.2)
    for (above, below), one in zip(grid.T, found.laws, strict=True):
        for place, (delayed, colour) in enumerate(zip(one.delays, COLOURS, strict=False)):
            band, label = (
                within(delayed.shoulder, *RUN_WINDOW_S),
                f"clock starts at {delayed.clock_s:g} s",
            )
            above.fill_between(band.time_s, band.low, band.high, color=colour, label=label, lw=0.6)
            above.collections[-1].set_zorder(3 - place / 10)  # the wildest behind
            sizes = [size for size in delayed.vibration_rad_per_s2 if size is not None]
            below.plot(np.full(len(sizes), place), sizes, "o", ms=4, color=colour, mfc="none")
        above.set(title=LAW_NAMES[one.law], xlabel="time since the start [s]")
        below.set_xticks(range(len(one.delays)), [f"{one.clock_s:g}" for one in one.delays])
        below.set(xlabel="clock at the start [s]", xlim=(-0.5, len(one.delays) - 0.5))
        below.margins(y=0.1)  # no ring cut in half
        log_y(below)
    grid[0, 0].set_ylabel("acceleration [rad/s²]")
    grid[1, 0].set_ylabel("vibration [rad/s²]")
    for row in grid:
        _one_scale(row)
    legend(figure, grid[0, 0])
    return to_svg(figure)


def _one_scale(row: np.ndarray) -> None:
    """For axes that are all of one kind: without numbers there is no logarithmic one."""
    if len({axes.get_yscale() for axes in row}) > 1:
        return
    low, high = (pick([axes.get_ylim()[end] for axes in row]) for end, pick in ((0, min), (1, max)))
    for axes in row:
        axes.set_ylim(low, high)


def third_svg(found: Thirds) -> str:
    """A dot for every start, a row for every law and way of the planets."""
    figure, grid = new_figure(1, 1, 3.2)
    axes = grid[0, 0]
    names = []
    for row, strip in enumerate(found.strips):
        sizes, share = np.sort(strip.third.sizes), strip.third.share
        apart = row + 0.28 * np.sin(2.4 * np.arange(sizes.size))  # so that dots show one by one
        colour = LAW_COLOURS[strip.cell.law]
        fill = colour if strip.cell.planets == "free" else "white"
        axes.plot(np.maximum(sizes, FAINTEST), apart, "o", ms=4.5, mec=colour, mfc=fill)
        if share is not None:
            said = f" {share.yes} of {share.of} severe"
            axes.text(1.0, row, said, va="center", transform=axes.get_yaxis_transform())
        names.append(f"{LAW_NAMES[strip.cell.law]}, {PLANET_NAMES[strip.cell.planets]}")
    axes.axvline(SEVERE, color="k", lw=0.7, ls="--", label=f"counted as severe ({SEVERE:g})")
    axes.axvline(PAPER_THIRD, color="k", lw=0.7, ls=":", label=f"the paper's ({PAPER_THIRD:g})")
    axes.set_yticks(range(len(names)), names)
    axes.set(xscale="log", xlabel="third fluctuation [rad/s²]", ylim=(len(names) - 0.5, -0.5))
    legend(figure, axes)
    return to_svg(figure)


def stage_svg(joint: Planetary) -> str:
    """A stage seen along its axis: sun, three planets on their carrier, ring; its meshes marked."""
    inner, outer = mesh_geometry(joint, "sun"), mesh_geometry(joint, "ring")
    figure, grid = new_figure(1, 1, 4.2)
    axes = grid[0, 0]
    _gear(axes, inner, inner.wheel, SUN, 1.0)
    _gear(axes, outer, outer.wheel, RING, 1.0)
    for turn in np.exp(2j * np.pi * np.arange(joint.planet_count) / joint.planet_count):
        _gear(axes, inner, inner.planet, PLANET, turn)
        centre = turn * inner.planet.centre * MILLI
        axes.plot([0, centre.real], [0, centre.imag], color=CARRIER, lw=5, solid_capstyle="round")
        for mesh in (inner, outer):
            at = turn * mesh.pitch_point * MILLI
            axes.plot(at.real, at.imag, "o", ms=8, mfc="none", mec="k", mew=1.4)
    _words(axes, inner, outer)
    axes.set_aspect("equal")
    axes.axis("off")
    return to_svg(figure)


def _gear(axes: Axes, mesh: MeshGeometry, wheel: Wheel, colour: str, turn: complex) -> None:
    """All teeth of a wheel and the circle that they stand on, turned about the sun's axis."""
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


def _words(axes: Axes, inner: MeshGeometry, outer: MeshGeometry) -> None:
    """Names, and what each mesh's displacement and force are called."""
    planet = MILLI * inner.planet.centre
    reach = MILLI * outer.wheel.radii[1]
    for x, y, text, colour in (
        (-14, 0, "sun", SUN),
        (planet.real, 16, "planet", PLANET),
        (-0.95 * planet.real, 0, "carrier\n(next link)", CARRIER),
        (0, reach + 8, "ring (previous body)", RING),
    ):
        axes.text(x, y, text, color=colour, ha="center", va="center", fontweight="bold")
    for mesh, name in ((inner, "sun mesh:\nx_sp, F_sp"), (outer, "ring mesh:\nx_pr, F_pr")):
        at = MILLI * mesh.pitch_point
        axes.annotate(
            name, (at.real, at.imag), (reach + 34, 60 if mesh is inner else -60),
            arrowprops={"arrowstyle": "->"}, ha="center",
        )  # fmt: skip
    axes.set(xlim=(-reach - 12, reach + 66), ylim=(-reach - 12, reach + 18))


def teeth_passed_svg(found: TeethPassed) -> str:
    """How many teeth have passed, and how fast they pass: counted, and by the paper's formula."""
    figure, grid = new_figure(1, 2, 2.6)
    counted, by_clock = LAW_COLOURS[LAWS[2]], LAW_COLOURS[LAWS[0]]
    for axes, integral, clock in (
        (grid[0, 0], found.angle, found.clock),
        (grid[0, 1], found.rate, found.clock_rate),
    ):
        axes.plot(found.time, integral, color=counted, label="teeth that pass: z_r θ")
        axes.plot(found.time, clock, color=by_clock, label="the paper's formula: z_r θ' t")
        axes.set_xlabel("time [s]")
    grid[0, 0].set_ylabel("teeth passed [1]")
    grid[0, 1].set_ylabel("teeth per second [1/s]")
    legend(figure, grid[0, 0])
    return to_svg(figure)

"""Drawings of docs/explanation/equations.md, of an arm: `python -m tools.drawings`."""

from __future__ import annotations

import io
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Annulus, Arc, Circle, FancyArrowPatch, Polygon

from crosscheck.models.arm.arm import Planetary
from crosscheck.models.loading import load_arm
from crosscheck.output import write_files
from crosscheck.view.mesh_geometry import (
    SIDES,
    THICKNESS,
    MeshGeometry,
    Side,
    Wheel,
    mesh_geometry,
    tooth,
)

DOCS = Path(__file__).parents[1] / "docs" / "explanation"
ARM = "paper-labelled"
STYLE: dict[Any, Any] = {
    "svg.hashsalt": "geararm-crosscheck",
    "font.size": 10,
    "mathtext.fontset": "cm",
}
WHEEL, PLANET, ACTION, CARRIER = "#1f5fa8", "#b5651d", "#b3202a", "#3c7a3c"
DISPLACEMENT = {
    "sun": r"$x_{sp} = r_s\,\theta_s - r_p\,\theta_p - r_{cp}\,\theta_c$",
    "ring": r"$x_{pr} = r_p\,\theta_p - r_{cp}\,\theta_c$",
}
NOTES = (
    "dashed: pitch circles; solid: base circles; dash-dotted: line of action;"
    " dotted: common tangent of the pitch circles; backlash drawn larger than it is"
)
MILLI = 1e3
Points = Sequence[complex] | np.ndarray


class Window(NamedTuple):
    """What of the plane is shown [mm]."""

    left: float
    right: float
    low: float
    high: float


STAGES = {"sun": Window(-52, 158, -74, 80), "ring": Window(-18, 174, -68, 73)}
SHOWN_TEETH = {"sun": 40, "ring": 14}  # of the central wheel, on either side of the pitch point
NEAR = 11.5  # half the width of what is shown of the teeth [mm]
CONTACT_WORDS = {  # text -> place [mm] from the pitch point
    "sun": {"sun": (-7.6, -1.9), "planet": (6.5, 2.0)},
    "ring": {"ring": (7.6, -2.2), "planet": (-6.8, 2.0)},
}


def write_drawings() -> None:
    """Draw both meshes anew. Raises InputError."""
    write_files({DOCS / f"{side}-mesh.svg": draw_mesh(side) for side in SIDES})


def draw_mesh(side: Side) -> str:
    """The SVG of a mesh: the whole stage on the left, its teeth on the right."""
    joint = load_arm(ARM).joints[0]
    assert isinstance(joint, Planetary)
    geometry = mesh_geometry(joint, side)
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(10.4, 5.0), layout="constrained")
        whole, near = figure.subplots(1, 2, width_ratios=(1.45, 1))
        _draw_stage(whole, geometry)
        _draw_contact(near, geometry)
        figure.suptitle(rf"{DISPLACEMENT[side]},   $r_{{cp}} = r_c\cos\alpha$")
        figure.supxlabel(NOTES, fontsize=8)
        stream = io.StringIO()
        figure.savefig(stream, format="svg", metadata={"Date": None, "Creator": None})
    return stream.getvalue()


def push_direction(geometry: MeshGeometry) -> complex:
    """Unit vector of a positive F on the planet, along the line of action.

    Forward, and away from the sun or inwards from the ring.
    """
    outward = math.sin(geometry.pressure_angle_rad)
    forward = math.cos(geometry.pressure_angle_rad)
    return complex(outward if geometry.side == "sun" else -outward, forward)


def tangent_point(geometry: MeshGeometry, wheel: Wheel) -> complex:
    """The point at which the line of action touches a wheel's base circle."""
    push = push_direction(geometry)
    along = (np.conj(push) * (wheel.centre - geometry.pitch_point)).real
    return complex(geometry.pitch_point + along * push)


def outline_teeth(geometry: MeshGeometry, wheel: Wheel, beside: int) -> list[np.ndarray]:
    """Outlines of the tooth that carries and of so many on either side of it, (points,) each.

    The carrying flank goes through the pitch point.
    """
    at = float(np.angle(geometry.pitch_point - wheel.centre))
    # The wheel's flank looks forward, the planet's back; a planet counts round its own centre.
    forward = wheel is geometry.wheel
    counter_clockwise = forward if abs(at) < 1 else not forward
    thickness = 2 * math.pi / wheel.teeth * THICKNESS
    other = at - thickness if counter_clockwise else at + thickness
    outline = tooth(wheel, min(at, other), max(at, other))
    turns = 2 * math.pi / wheel.teeth * np.arange(-beside, beside + 1)
    return [wheel.centre + np.exp(1j * turn) * outline for turn in turns]


def _draw_stage(axes: Axes, geometry: MeshGeometry) -> None:
    """Both wheels, the line of centres, the line of action and the angles counted positive."""
    _set_frame(axes, STAGES[geometry.side])
    _draw_wheel(axes, geometry, geometry.wheel, SHOWN_TEETH[geometry.side], WHEEL)
    _draw_wheel(axes, geometry, geometry.planet, geometry.planet.teeth // 2, PLANET)
    _draw_line(axes, (0j, geometry.planet.centre), CARRIER, "-", 2.5)
    _draw_line_of_action(axes, geometry, 1.2)
    _draw_radius(axes, geometry, geometry.planet, PLANET, "$r_p$")
    if geometry.side == "sun":
        _draw_radius(axes, geometry, geometry.wheel, WHEEL, "$r_s$")
    _draw_arrow(axes, geometry.pitch_point, 33 / MILLI * push_direction(geometry), ACTION)
    for at, colour in ((0j, WHEEL), (geometry.planet.centre, PLANET)):
        _draw_dot(axes, at, colour)
    _draw_dot(axes, geometry.pitch_point, "black")
    _draw_angles(axes, geometry)
    _write_stage_names(axes, geometry)


def _draw_angles(axes: Axes, geometry: MeshGeometry) -> None:
    """theta_s and theta_c counter-clockwise, theta_p against them."""
    sun, planet = geometry.wheel, geometry.planet
    if geometry.side == "sun":
        _draw_turn(axes, 0j, 0.55 * sun.base_radius, (100, 200), WHEEL, r"$\theta_s$")
        _draw_turn(axes, 0j, 0.85 * planet.centre.real, (3, 27), CARRIER, r"$\theta_c$")
    else:
        _draw_turn(axes, 0j, 0.3 * planet.centre.real, (8, 70), CARRIER, r"$\theta_c$")
    _draw_turn(axes, planet.centre, 0.5 * planet.base_radius, (310, 210), PLANET, r"$\theta_p$")


def _write_stage_names(axes: Axes, geometry: MeshGeometry) -> None:
    """Names of the wheels and the carrier."""
    planet, at = geometry.planet, geometry.pitch_point
    _draw_word(axes, planet.centre + (12 + 26j) / MILLI, "planet", PLANET)
    _draw_word(axes, planet.centre * 0.62 - 6j / MILLI, "carrier, $r_c$", CARRIER)
    _draw_word(axes, at + 38 / MILLI * push_direction(geometry), "$x, F > 0$", ACTION)
    if geometry.side == "sun":
        _draw_word(axes, -10j / MILLI, "sun", WHEEL)
    else:
        _draw_word(axes, -8j / MILLI, "joint", WHEEL)
        _draw_word(axes, at + (14 + 0j) / MILLI, "ring", WHEEL)


def _draw_wheel(
    axes: Axes, geometry: MeshGeometry, wheel: Wheel, beside: int, colour: str, alpha: float = 0.2
) -> None:
    """Teeth, what they stand on, pitch and base circle."""
    foot, x = wheel.radii[1] * MILLI, wheel.centre.real * MILLI
    body = Annulus((x, 0), foot + 8, 8) if wheel.internal else Circle((x, 0), foot)
    body.set(facecolor=colour, edgecolor="none", alpha=alpha)
    axes.add_patch(body)
    for single in outline_teeth(geometry, wheel, min(beside, (wheel.teeth - 1) // 2)):
        axes.add_patch(Polygon(_xy(single), closed=True, fc=colour, ec="none", alpha=alpha))
    for radius, style in ((wheel.pitch_radius, "--"), (wheel.base_radius, "-")):
        circle = Circle((x, 0), radius * MILLI, fill=False, ec=colour, ls=style, lw=0.9)
        axes.add_patch(circle)


def _draw_radius(axes: Axes, geometry: MeshGeometry, wheel: Wheel, colour: str, text: str) -> None:
    """From a wheel's centre to where the line of action touches its base circle."""
    end = tangent_point(geometry, wheel)
    _draw_line(axes, (wheel.centre, end), colour, "-", 1.0)
    _draw_dot(axes, end, ACTION)
    _draw_word(axes, 0.55 * end + 0.45 * wheel.centre, text, colour)


def _draw_contact(axes: Axes, geometry: MeshGeometry) -> None:
    """The teeth at the pitch point, the pressure angle, and the forces on both wheels."""
    at = geometry.pitch_point
    _set_frame(axes, Window(at.real * MILLI - NEAR, at.real * MILLI + NEAR, -NEAR, NEAR))
    for wheel, colour in ((geometry.wheel, WHEEL), (geometry.planet, PLANET)):
        _draw_wheel(axes, geometry, wheel, 2, colour, 0.35)
    _draw_line(axes, (at - 11j / MILLI, at + 11j / MILLI), "0.3", ":", 1.2)
    _draw_line_of_action(axes, geometry, 2.0)
    for sign, colour, name in ((1, PLANET, "planet"), (-1, WHEEL, geometry.side)):
        along = 6.0 / MILLI * sign * push_direction(geometry)
        _draw_arrow(axes, at, along, colour)
        force = "$F$" if sign > 0 else "$-F$"
        aside = -1 if geometry.side == "sun" else 1
        _draw_word(axes, at + along + sign * aside * 4.6 / MILLI, f"{force} on the {name}", colour)
    for text, (x, y) in CONTACT_WORDS[geometry.side].items():
        _draw_word(axes, at + complex(x, y) / MILLI, text, PLANET if text == "planet" else WHEEL)
    _draw_pressure_angle(axes, geometry)
    _draw_dot(axes, at, "black")


def _draw_pressure_angle(axes: Axes, geometry: MeshGeometry) -> None:
    """alpha between the common tangent and the line of action."""
    at = geometry.pitch_point * MILLI
    bounds = sorted((90.0, float(np.degrees(np.angle(push_direction(geometry))))))
    axes.add_patch(Arc((at.real, at.imag), 19, 19, theta1=bounds[0], theta2=bounds[1], color="0.2"))
    middle = at + 9.5 * np.exp(1j * np.radians(np.mean(bounds)))
    _draw_word(axes, middle / MILLI, r"$\alpha$", "0.2")


def _draw_line_of_action(axes: Axes, geometry: MeshGeometry, part: float) -> None:
    """Through the pitch point, so many times as far as the farther tangent point either way."""
    at = geometry.pitch_point
    points = [tangent_point(geometry, wheel) - at for wheel in (geometry.wheel, geometry.planet)]
    reach = part * max(abs(point) for point in points) * push_direction(geometry)
    _draw_line(axes, (at - reach, at + reach), ACTION, "-.", 1.1)


def _set_frame(axes: Axes, window: Window) -> None:
    axes.set(xlim=(window.left, window.right), ylim=(window.low, window.high), aspect="equal")
    axes.axis("off")


def _xy(points: Points) -> np.ndarray:
    """Points [m] as columns x, y [mm]."""
    plane = np.asarray(points) * MILLI
    return np.column_stack([plane.real, plane.imag])


def _draw_line(axes: Axes, points: Points, colour: str, style: str, width: float) -> None:
    axes.plot(*_xy(points).T, color=colour, ls=style, lw=width)


def _draw_dot(axes: Axes, at: complex, colour: str) -> None:
    axes.plot(*_xy([at]).T, "o", color=colour, ms=4)


def _draw_word(axes: Axes, at: complex, text: str, colour: str) -> None:
    x, y = _xy([at])[0]
    box = {"facecolor": "white", "edgecolor": "none", "alpha": 0.75, "pad": 1.0}
    axes.text(x, y, text, color=colour, ha="center", va="center", bbox=box)


def _draw_arrow(axes: Axes, start: complex, along: complex, colour: str) -> None:
    tail, head = ((float(x), float(y)) for x, y in _xy([start, start + along]))
    arrow = FancyArrowPatch(tail, head, color=colour, lw=2.2, zorder=4, shrinkA=0, shrinkB=0)
    arrow.set_arrowstyle("-|>")
    arrow.set_mutation_scale(15)
    axes.add_patch(arrow)


def _draw_turn(
    axes: Axes, centre: complex, radius: float, degrees: tuple[int, int], colour: str, text: str
) -> None:
    """An arc with an arrow at its end, from one direction to the other."""
    directions = np.exp(1j * np.radians(np.linspace(*degrees, 60)))
    points = centre + radius * directions
    _draw_line(axes, points[:-2], colour, "-", 1.6)
    tail, head = ((float(x), float(y)) for x, y in _xy(points[[-4, -1]]))
    axes.add_patch(FancyArrowPatch(tail, head, arrowstyle="-|>", mutation_scale=14, color=colour))
    _draw_word(axes, centre + radius * directions[22], text, colour)


if __name__ == "__main__":
    write_drawings()

"""A scheme of an arm, drawn from its file: links and gears to scale as far as both can be seen."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from html import escape

from crosscheck.models.arm.arm import Arm, Joint, Planetary, describe_arm

WIDTH, HEIGHT, MARGIN = 460.0, 260.0, 44.0
FIRST_RAD, BEND_RAD = 0.62, 0.95  # of the first link, and of each joint, to and fro
LEAST_RING, MOST_RING, LEAST_MOTOR = 15.0, 40.0, 6.0  # radii, to be seen whole


def draw_scheme(arm: Arm) -> str:
    """The scheme of an arm as an <svg>, in the page's own colours, with a text alternative."""
    points, heading = [0j], FIRST_RAD
    for place, link in enumerate(arm.links):
        points.append(points[-1] + link.length_m * complex(math.cos(heading), math.sin(heading)))
        heading += BEND_RAD * (-1 if place % 2 == 0 else 1)
    left, low = min(p.real for p in points), min(p.imag for p in points)
    wide, high = max(p.real for p in points) - left, max(p.imag for p in points) - low
    scale = min((WIDTH - 2 * MARGIN) / max(wide, 1e-9), (HEIGHT - 2 * MARGIN) / max(high, 1e-9))
    at = [
        complex(MARGIN + scale * (p.real - left), HEIGHT - MARGIN - scale * (p.imag - low))
        for p in points
    ]
    parts = [_draw_base(at[0]), *(_draw_link(*ends) for ends in itertools.pairwise(at))]
    for joint, here in zip(arm.joints, at, strict=False):
        parts += _draw_joint(joint, here, scale)
    if arm.payload_mass_kg:
        parts.append(_draw_circle(at[-1], 7, "payload"))
    description = escape(". ".join(describe_arm(arm)))
    return (
        f'<svg class="scheme" viewBox="0 0 {WIDTH:g} {HEIGHT:g}" role="img"'
        f' aria-label="{description}">'
        f"{''.join(parts)}</svg>"
    )


def _draw_base(at: complex) -> str:
    strokes = "".join(f"M{at.real - 18 + 9 * n:.1f} {at.imag + 20:.1f}l-7 8" for n in range(5))
    return f'<path class="base" d="M{at.real:.1f} {at.imag:.1f}v20m-20 0h40{strokes}" fill="none"/>'


def _draw_link(start: complex, end: complex) -> str:
    return (
        f'<line class="link" x1="{start.real:.1f}" y1="{start.imag:.1f}" x2="{end.real:.1f}"'
        f' y2="{end.imag:.1f}"/>'
    )


def _draw_joint(joint: Joint, at: complex, scale: float) -> Iterator[str]:
    """Circles of a joint: a motor, or its gears' pitch circles, as large as can be seen whole."""
    if not isinstance(joint, Planetary):
        yield _draw_circle(at, LEAST_MOTOR, "motor")
        return
    ring = joint.module_m * joint.ring_teeth / 2 * scale
    unit = min(max(ring, LEAST_RING), MOST_RING) / joint.ring_teeth  # half a module, on the picture
    yield _draw_circle(at, unit * joint.ring_teeth, "ring")
    for planet in range(joint.planet_count):
        angle = 2 * math.pi * planet / joint.planet_count + math.pi / 2
        away = unit * (joint.sun_teeth + joint.planet_teeth)
        centre = at + away * complex(math.cos(angle), -math.sin(angle))
        yield _draw_circle(centre, unit * joint.planet_teeth, "planet")
    yield _draw_circle(at, unit * joint.sun_teeth, "sun")


def _draw_circle(at: complex, radius: float, name: str) -> str:
    return f'<circle class="{name}" cx="{at.real:.1f}" cy="{at.imag:.1f}" r="{radius:.1f}"/>'

"""A scheme of an arm or a robot, drawn from its file.

An arm's links and gears are to scale as far as both can be seen; a robot's links are rods.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator, Sequence
from html import escape

import numpy as np

from crosscheck.models.arm.arm import Arm, Joint, Planetary
from crosscheck.models.robot.robot import BASE, Robot
from crosscheck.view.rods import find_rod_ends, find_upward

WIDTH, HEIGHT, MARGIN, SIDE = 460.0, 260.0, 44.0, 110.0  # the last for labels
FIRST_RAD, BEND_RAD = 0.62, 0.95  # angle of the first link, and of each joint, to and fro
AZIMUTH_RAD, RISE_RAD = 0.6, 0.35  # direction from which a robot is seen
LARGEST_LEAN = 0.9  # x component of the upward direction above which y defines the direction across
LETTER_WIDTH, CLEARANCE = 8.5, 8.0  # of labels: a letter, and what they are away from lines
LETTER_HEIGHT, HEIGHTS = 11.0, ((-4, 15), (-22, 33))  # and where they are, from their joint
MOST_LETTERS = 14  # of a joint's name
LEAST_RING, MOST_RING, LEAST_MOTOR = 15.0, 40.0, 6.0  # radii, to be seen whole


def draw_arm(arm: Arm) -> str:
    """The scheme of a bent arm as an <svg>, in the page's own colours, with a text alternative."""
    points, heading = [0j], FIRST_RAD
    for place, link in enumerate(arm.links):
        points.append(points[-1] + link.length_m * complex(math.cos(heading), math.sin(heading)))
        heading += BEND_RAD * (-1 if place % 2 == 0 else 1)
    at, scale = _fit_points(points)
    parts = [_draw_base(at[0]), *(_draw_link(*ends) for ends in itertools.pairwise(at))]
    for joint, here in zip(arm.joints, at, strict=False):
        parts += _draw_joint(joint, here, scale)
    if arm.payload_mass_kg:
        parts.append(_draw_circle(at[-1], 7, "payload"))
    return _make_picture(parts, arm.described)


def draw_robot(robot: Robot) -> str:
    """The scheme of a robot with all coordinates zero, seen from the side and a little above."""
    poses, joints = {BASE: (np.eye(3), np.zeros(3))}, []
    for number, joint in enumerate(robot.joints):
        rotation, position = poses[joint.parent]
        place = position + rotation @ joint.placement.position
        poses[number] = (rotation @ joint.placement.rotation, place)
        joints.append(place)
    rods = []
    for number, ends in find_rod_ends(robot).items():
        rotation, position = poses[number]
        rods += [(position, position + rotation @ end) for end in ends]
    view = _face_viewer(find_upward(robot))
    shown = np.array([np.zeros(3), *joints, *sum(rods, ())]) @ view.T
    at, _ = _fit_points([complex(right, up) for right, up in shown])
    feet, joint_points, rod_points = at[0], at[1 : len(joints) + 1], at[len(joints) + 1 :]
    parts = [_draw_base(feet), *map(_draw_link, rod_points[::2], rod_points[1::2])]
    obstacles = list(zip(rod_points[::2], rod_points[1::2], strict=True))
    obstacles += [(each, each) for each in joint_points]
    for joint, here in zip(robot.joints, joint_points, strict=True):
        kind = "motor" if joint.kind == "revolute" else "slide"
        parts.append(_draw_circle(here, LEAST_MOTOR, kind))
        is_long = len(joint.name) > MOST_LETTERS
        text = f"{joint.name[: MOST_LETTERS - 1]}…" if is_long else joint.name
        place = _place_label(width := len(text) * LETTER_WIDTH, here, obstacles)
        obstacles += [(place - rise, place - rise + width) for rise in (0j, LETTER_HEIGHT * 1j)]
        parts.append(f'<text x="{place.real:.1f}" y="{place.imag:.1f}">{escape(text)}</text>')
    return _make_picture(parts, repr(robot).splitlines())


def _place_label(
    width: float, point: complex, obstacles: Sequence[tuple[complex, complex]]
) -> complex:
    """The left end of a label beside a point, on the first side that is clear, or the clearest.

    obstacles: ends of lines, which are one of a point.
    """
    sides = (min(point.real + 10, WIDTH - width), max(point.real - 10 - width, 0.0))
    near, far = ([complex(x, point.imag + y) for x in sides for y in ys] for ys in HEIGHTS)
    places = near + far

    def measure(place: complex) -> float:
        middle = place + complex(0, -LETTER_HEIGHT / 2)
        ahead = np.linspace(middle, middle + width, 5)
        return min(_measure_distance(each, *end) for each in ahead for end in obstacles)

    return next((each for each in places if measure(each) >= CLEARANCE), max(places, key=measure))


def _measure_distance(point: complex, start: complex, end: complex) -> float:
    """The distance of a point from a line between two ends."""
    along = end - start
    part = ((point - start) * along.conjugate()).real / abs(along) ** 2 if along else 0.0
    return abs(point - start - min(max(part, 0.0), 1.0) * along)


def _face_viewer(upward: np.ndarray) -> np.ndarray:
    """Rows (2, 3): the directions to the right and up on the picture, in the base's frame."""
    other = np.eye(3)[0] if abs(upward[0]) <= LARGEST_LEAN else np.eye(3)[1]
    across = other - (other @ upward) * upward
    across /= np.linalg.norm(across)
    beside = np.cross(upward, across)
    right = math.cos(AZIMUTH_RAD) * across + math.sin(AZIMUTH_RAD) * beside
    towards = np.cross(right, upward)
    up = math.cos(RISE_RAD) * upward - math.sin(RISE_RAD) * towards
    return np.stack([right, up])


def _fit_points(points: Sequence[complex]) -> tuple[list[complex], float]:
    """Points in the middle, within the picture's margins, y downwards; and the scale of lengths."""
    left, low = min(p.real for p in points), min(p.imag for p in points)
    wide, high = max(p.real for p in points) - left, max(p.imag for p in points) - low
    scale = min((WIDTH - 2 * SIDE) / max(wide, 1e-9), (HEIGHT - 2 * MARGIN) / max(high, 1e-9))
    base, corner = complex(left + wide / 2, low), complex(WIDTH / 2, HEIGHT - MARGIN)
    return [corner + scale * (p - base).conjugate() for p in points], scale


def _make_picture(parts: Iterable[str], lines: Iterable[str]) -> str:
    box, label = f"0 0 {WIDTH:g} {HEIGHT:g}", escape(". ".join(lines))
    head = f'<svg class="scheme" viewBox="{box}" role="img" aria-label="{label}">'
    return f"{head}{''.join(parts)}</svg>"


def _draw_base(at: complex) -> str:
    strokes = "".join(f"M{at.real - 18 + 9 * n:.1f} {at.imag + 20:.1f}l-7 8" for n in range(5))
    return f'<path class="base" d="M{at.real:.1f} {at.imag:.1f}v20m-20 0h40{strokes}" fill="none"/>'


def _draw_link(start: complex, end: complex) -> str:
    ends = f'x1="{start.real:.1f}" y1="{start.imag:.1f}" x2="{end.real:.1f}" y2="{end.imag:.1f}"'
    return f'<line class="link" {ends}/>'


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

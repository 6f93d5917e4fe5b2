"""Gears of a stage as outlines, where they stand, and one mesh with its gap drawn larger.

Points are complex numbers [m]; a stage's frame is that of the body its ring is fixed to, at rest
at zero angles, x along the first planet.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from crosscheck.analytic.paper.kinematics import stage_geometry
from crosscheck.models.arm.arm import Planetary
from crosscheck.view.mesh_geometry import THICKNESS, Side, Wheel, mesh_geometry, tooth

GAP = 0.07  # drawn half clearance of a mesh, over a pitch
TEETH_BESIDE = 2  # teeth on either side of the one in contact


def outline(wheel: Wheel) -> np.ndarray:
    """Outline of a wheel round its own centre, (points,) [m], the first tooth's middle on x."""
    pitch = 2 * math.pi / wheel.teeth
    half = THICKNESS * pitch / 2
    single = np.roll(tooth(wheel, -half, half), 1)  # one tooth from foot to foot
    turns = np.exp(1j * pitch * np.arange(wheel.teeth))
    return np.asarray(turns[:, None] * single).ravel()


@dataclass(frozen=True)
class Assembly:
    """Angles of a stage's gears at zero joint angles, so that every tooth meets a gap [rad].

    planets: where each is on the carrier; spins: of the planets, (planets,); ring: of the ring;
    the sun has a tooth on x.
    """

    planets: np.ndarray
    spins: np.ndarray
    ring: float


def gear_assembly(joint: Planetary) -> Assembly:
    """The angles of a stage's gears if its planets are equally spaced."""
    sun, planet, ring = joint.sun_teeth, joint.planet_teeth, joint.ring_teeth
    at = 2 * math.pi * np.arange(joint.planet_count) / joint.planet_count
    # A planet's tooth is half a pitch from the sun's, counted along the pitch circles.
    spins = at + math.pi - 2 * math.pi * (0.5 - sun * at / (2 * math.pi)) / planet
    outward = -planet * spins[0] / (2 * math.pi)  # pitches from a tooth of the first planet to x
    return Assembly(at, spins, -2 * math.pi * (0.5 + outward) / ring)


def gear_angles(
    joint: Planetary, carrier: np.ndarray, x_sp: np.ndarray, x_pr: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Angles of sun (times,) and planets (times, planets) by Eqs. 2 and 3, in the stage's frame.

    carrier (times,) [rad]; x_sp, x_pr (times, planets) [m]: planets counted as one have one column,
    and all turn together. A planet's angle is that of its turning, counter-clockwise.
    """
    radii = stage_geometry(joint)
    arc = radii.r_cp * carrier
    sun = (x_sp[:, 0] + x_pr[:, 0] + 2 * arc) / radii.r_s
    clockwise = (x_pr + arc[:, None]) / radii.r_p
    return sun, -np.broadcast_to(clockwise, (carrier.size, joint.planet_count))


@dataclass(frozen=True)
class CloseUp:
    """A mesh at its pitch point, x along the line of centres, its gap ``factor`` times larger.

    wheel, planet: outlines of rim and teeth of sun or ring, and of a planet at x = 0; centre: the
    planet's axis; turn_per_m: how far a displacement of the mesh turns the drawn planet,
    counter-clockwise [rad/m].
    """

    factor: float
    wheel: list[np.ndarray]
    planet: list[np.ndarray]
    centre: complex
    turn_per_m: float


def make_close_up(joint: Planetary, side: Side, largest_m: float) -> CloseUp:
    """The close-up of the first planet's mesh with sun or ring.

    largest_m: the displacement [m] that the drawing of a mesh without clearance is scaled by.
    """
    geometry = mesh_geometry(joint, side)
    pitch = math.pi * joint.module_m
    backlash_m = (joint.sun_mesh if side == "sun" else joint.ring_mesh).planet_mesh(0).backlash_m
    along = math.cos(geometry.pressure_angle_rad)
    factor = GAP * pitch * along / (backlash_m or largest_m or joint.module_m)
    clearance = factor * backlash_m / along  # along the pitch circle, on either side
    return CloseUp(
        factor,
        list(_teeth(geometry.wheel, clearance, pitch, geometry.pitch_point, forward=False)),
        list(_teeth(geometry.planet, clearance, pitch, geometry.pitch_point, forward=True)),
        complex(geometry.planet.centre - geometry.pitch_point),
        (factor if side == "sun" else -factor) / geometry.planet.base_radius,
    )


def _teeth(
    wheel: Wheel, clearance: float, pitch: float, origin: complex, forward: bool
) -> Iterator[np.ndarray]:
    """Closed outlines of the rim and of teeth, from the origin.

    forward: whether the tooth at the origin lies on y > 0.
    """
    at = float(np.angle(origin - wheel.centre))
    sign = 1.0 if abs(at) < 1 else -1.0  # a step along +y turns the wheel so
    ends = np.array([clearance / 2, pitch / 2 - clearance / 2]) * (1 if forward else -1)
    low, high = sorted(at + sign * ends / wheel.pitch_radius)
    single = tooth(wheel, float(low), float(high))
    foot, turn = wheel.radii[1], 2 * math.pi / wheel.teeth
    span = np.exp(1j * (at + turn * (TEETH_BESIDE + 0.8) * np.linspace(-1, 1, 24)))
    depth = math.copysign(2 * wheel.pitch_radius / wheel.teeth, foot - wheel.pitch_radius)
    body = np.concatenate([foot * span, (foot + depth) * span[::-1]])
    yield np.asarray(wheel.centre + body - origin)
    for number in range(-TEETH_BESIDE, TEETH_BESIDE + 1):
        yield np.asarray(wheel.centre + np.exp(1j * turn * number) * single - origin)

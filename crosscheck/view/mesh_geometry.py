"""The plane geometry of one mesh, for drawings of it: circles, line of action, involute teeth.

Points of the plane are complex numbers [m] in the frame of the central wheel's axis, x along the
line of centres, angles counter-clockwise. The planet is the one on the carrier's x axis.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from crosscheck.models.arm.arm import Planetary

Side = Literal["sun", "ring"]
SIDES: tuple[Side, Side] = ("sun", "ring")
# Thickness of a tooth over the pitch; the missing part is the backlash, far larger than real.
THICKNESS = 0.46
FLANK_POINTS = 9


@dataclass(frozen=True)
class Wheel:
    """A gear: centre, pitch and base radius [m], teeth; internal: teeth inwards."""

    centre: complex
    pitch_radius: float
    base_radius: float
    teeth: int
    internal: bool = False

    @property
    def radii(self) -> tuple[float, float]:
        """Radii of a tooth's tip and root [m]: one and 1.25 modules from the pitch circle."""
        module = 2 * self.pitch_radius / self.teeth
        out = -1 if self.internal else 1
        return self.pitch_radius + out * module, self.pitch_radius - 1.25 * out * module


@dataclass(frozen=True)
class MeshGeometry:
    """The central wheel and the planet in contact at the pitch point, x and F positive."""

    side: Side
    wheel: Wheel
    planet: Wheel
    pressure_angle_rad: float

    @property
    def pitch_point(self) -> complex:
        """The point at which the pitch circles touch, on the line of centres."""
        return complex(self.wheel.pitch_radius, 0.0)


def mesh_geometry(joint: Planetary, side: Side) -> MeshGeometry:
    """The mesh of a planet with sun or ring, from the joint's own numbers."""
    alpha = math.radians(joint.pressure_angle_deg)

    def wheel(teeth: int, centre: complex = 0j, internal: bool = False) -> Wheel:
        pitch = joint.module_m * teeth / 2
        return Wheel(centre, pitch, pitch * math.cos(alpha), teeth, internal)

    carrier = joint.module_m * (joint.sun_teeth + joint.planet_teeth) / 2
    sun, ring = wheel(joint.sun_teeth), wheel(joint.ring_teeth, internal=True)
    planet = wheel(joint.planet_teeth, complex(carrier, 0.0))
    return MeshGeometry(side, sun if side == "sun" else ring, planet, alpha)


def flank(wheel: Wheel, at: float, counter_clockwise: bool) -> np.ndarray:
    """Points (n,) from foot to end of the involute through the pitch circle at ``at`` [rad]."""
    end, foot = wheel.radii
    radii = np.linspace(max(foot, wheel.base_radius), max(end, wheel.base_radius), FLANK_POINTS)
    angle, at_pitch = (np.arccos(wheel.base_radius / r) for r in (radii, wheel.pitch_radius))
    narrowing = (np.tan(angle) - angle) - (np.tan(at_pitch) - at_pitch)
    sign = -1 if counter_clockwise != wheel.internal else 1
    return np.asarray(radii * np.exp(1j * (at + sign * narrowing)))


def tooth(wheel: Wheel, clockwise: float, counter_clockwise: float) -> np.ndarray:
    """Closed outline between two flanks at these angles [rad], round the wheel's own centre."""
    first, last = flank(wheel, clockwise, False), flank(wheel, counter_clockwise, True)
    foot = wheel.radii[1]
    feet = foot * np.exp(1j * np.angle([last[0], first[0]]))
    return np.concatenate([first, last[::-1], feet])

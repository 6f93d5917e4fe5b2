"""A planetary stage drawn: involute flanks of all its gears, turned with the carrier.

Points of the plane are complex numbers, in modules, about the stage's axis. Nothing here knows a
formula of mesh phases: where two flanks touch is searched on the curves as drawn.
"""

import cmath
import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

from scipy.optimize import brentq, minimize_scalar

HEIGHT = 0.4  # modules about the pitch circle that a flank is drawn: no undercut reaches it
TRAVEL = 0.1  # tooth pitches about the pitch point that a contact is followed
TURN = 2 * math.pi
FINE = {"xatol": 1e-12}


@dataclass(frozen=True)
class Flank:
    """An involute about its gear's axis; hand 1: its angle grows with the radius."""

    base_radius: float
    foot: float
    hand: int

    def point(self, string: float) -> complex:
        """End of the string unwound by an angle."""
        corner = cmath.rect(self.base_radius, self.foot + self.hand * string)
        return corner * (1 - 1j * self.hand * string)

    def angle_at(self, radius: float) -> float:
        """Polar angle where the involute passes a radius."""
        string = math.sqrt(max((radius / self.base_radius) ** 2 - 1, 0.0))
        return self.foot + self.hand * (string - math.atan(string))


@dataclass(frozen=True)
class Gear:
    """Standard teeth: half a pitch thick on the pitch circle, tooth 0 centred at angle zero.

    inner: teeth point inwards.
    """

    teeth: int
    pressure_angle: float
    inner: bool = False

    @property
    def pitch(self) -> float:
        """Angle from tooth to tooth."""
        return TURN / self.teeth

    @property
    def pitch_radius(self) -> float:
        """In modules."""
        return self.teeth / 2

    @property
    def base_radius(self) -> float:
        """Of the circle from which the string of the involute unwinds."""
        return self.pitch_radius * math.cos(self.pressure_angle)

    def flank(self, forward: bool) -> Flank:
        """Of tooth 0, that which looks counter-clockwise (forward), or the other."""
        at_pitch = self.pitch / 4 if forward else -self.pitch / 4
        hand = 1 if forward == self.inner else -1
        string = math.tan(self.pressure_angle)
        foot = at_pitch - hand * (string - math.atan(string))
        return Flank(self.base_radius, foot, hand)

    def strings(self) -> tuple[float, float]:
        """Unwound angles at both ends of a drawn flank."""
        ends = (self.pitch_radius - HEIGHT, self.pitch_radius + HEIGHT)
        low, high = (math.sqrt(max((r / self.base_radius) ** 2 - 1, 0.0)) for r in ends)
        return low, high


@dataclass(frozen=True)
class Touch:
    """Where two flanks are nearest: the point, and the angle about the planet that parts them."""

    point: complex
    gap: float


@dataclass(frozen=True)
class Stage:
    """A stage with its ring held, drawn in the frame of its carrier.

    Points of a contact are given with the planet's centre on the x axis. At carrier angle zero,
    tooth 0 of the ring is centred at ``ring_at``. Every planet's flank is laid against the ring's
    at a pitch point, the sun's against the first planet's; whether the flanks then touch elsewhere,
    and the other planets fit the sun, shows.

    places: angle of every planet on the carrier.
    """

    sun_teeth: int
    planet_teeth: int
    places: tuple[float, ...]
    pressure_angle: float
    ring_at: float = 0.0

    @cached_property
    def sun(self) -> Gear:
        """Turns forward faster than the carrier."""
        return Gear(self.sun_teeth, self.pressure_angle)

    @cached_property
    def planet(self) -> Gear:
        """Turns back on the carrier."""
        return Gear(self.planet_teeth, self.pressure_angle)

    @cached_property
    def ring(self) -> Gear:
        """Stands still."""
        return Gear(self.sun_teeth + 2 * self.planet_teeth, self.pressure_angle, inner=True)

    def sun_passages(self) -> list[float]:
        """Of every planet a carrier angle at which its contact with the sun is at the pitch point.

        The sun drives, forward.
        """
        starts = map(self._sun_start, range(len(self.places)))
        return [self._passage(self.sun_touch, start, n) for n, start in enumerate(starts)]

    def ring_passages(self) -> list[float]:
        """The same of every planet's contact with the ring."""
        starts = map(self._ring_start, range(len(self.places)))
        return [self._passage(self.ring_touch, start, n) for n, start in enumerate(starts)]

    def sun_touch(self, planet: int, carrier: float) -> Touch:
        """Of the sun's flank that looks forward with the planet's before it."""
        turned = self._sun_at - self.places[planet] + carrier * self.ring.teeth / self.sun.teeth
        return self._touch(self.sun, turned, self._planet_turned(planet, carrier), ahead=True)

    def ring_touch(self, planet: int, carrier: float) -> Touch:
        """Of the ring's flank that looks forward with the planet's before it."""
        turned = self.ring_at - self.places[planet] - carrier
        return self._touch(self.ring, turned, self._planet_turned(planet, carrier), ahead=False)

    def _ring_start(self, planet: int) -> float:
        """Carrier angle that brings the planet to a flank of the ring at its pitch radius."""
        return self.ring_at + self.ring.pitch / 4 - self.places[planet]

    def _sun_start(self, planet: int) -> float:
        """Carrier angle that brings a flank of the sun to the planet, at its pitch radius."""
        behind = self.places[planet] - self._sun_at - self.sun.pitch / 4
        return _nearest(behind, self.sun.pitch) * self.sun.teeth / self.ring.teeth

    def _planet_turned(self, planet: int, carrier: float) -> float:
        """Angle of tooth 0 from the line of centres, away from the stage's axis."""
        # Its flank that looks clockwise, a quarter pitch back, is at the ring's pitch point.
        past = carrier - self._ring_start(planet)
        return self.planet.pitch / 4 - past * self.ring.teeth / self.planet.teeth

    @cached_property
    def _sun_at(self) -> float:
        """Angle of its tooth 0 at carrier angle zero."""
        # Towards the sun, half a turn round, the planet shows the flank that looks the other way.
        short = math.pi - self._planet_turned(0, 0.0) - self.planet.pitch / 4
        carrier = -_nearest(short, self.planet.pitch) * self.planet.teeth / self.ring.teeth
        return -self.sun.pitch / 4 - carrier * self.ring.teeth / self.sun.teeth

    def _touch(self, wheel: Gear, turned: float, planet_turned: float, ahead: bool) -> Touch:
        """Nearest points of the wheel's flank at the line of centres and the planet's flank.

        ahead: that flank of the planet which looks counter-clockwise about its own centre.
        """
        flank, met = wheel.flank(True), self.planet.flank(ahead)
        at_line = _nearest(turned + wheel.pitch / 4, wheel.pitch) - wheel.pitch / 4
        centre = self.sun.pitch_radius + self.planet.pitch_radius

        def gap(string: float) -> float:
            off = flank.point(string) * cmath.rect(1, at_line) - centre
            apart = cmath.phase(off) - met.angle_at(abs(off)) - planet_turned
            return _nearest(apart, self.planet.pitch) * (1 if ahead else -1)

        found = minimize_scalar(gap, bounds=wheel.strings(), method="bounded", options=FINE)
        return Touch(flank.point(found.x) * cmath.rect(1, at_line), float(found.fun))

    def _passage(self, touch: Callable[[int, float], Touch], start: float, planet: int) -> float:
        """Carrier angle about a start at which the point of contact crosses the line of centres."""
        way = TRAVEL * self.ring.pitch
        return float(brentq(lambda at: touch(planet, at).point.imag, start - way, start + way))


def equal_places(planets: int) -> tuple[float, ...]:
    """Angles of so many planets, equally spaced."""
    return tuple(TURN * planet / planets for planet in range(planets))


def _nearest(angle: float, period: float) -> float:
    """The angle, whole periods off, that is nearest to zero."""
    return angle - period * round(angle / period)

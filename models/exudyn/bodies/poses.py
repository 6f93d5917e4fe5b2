"""The geared arm as separate bodies in the plane, and generalized coordinates as their poses.

Frames: x, y in the plane, the ground's origin at the shoulder; angles are absolute, about z,
counter-clockwise. The origin of every body lies on the axis of its own revolute joint: a link's on
the joint that drives it, a gear's at its centre. At zero all bodies' x axes are parallel. Points of
the plane are complex numbers.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, NamedTuple

import numpy as np

from crosscheck.models.arm.arm import Arm, Link, Planetary
from crosscheck.models.arm.layout import MESHES, Layout

Gear = Literal["sun", "planet", "carrier"]
GROUND = -1


class Part(NamedTuple):
    """A rigid piece of a body: mass [kg], centre of mass on the x axis [m], inertia about it."""

    mass: float
    x: float
    inertia: float


class RigidBody(NamedTuple):
    """Parts in one frame, and the joint: the frame's origin sits on a point [m] of another body."""

    parts: tuple[Part, ...]
    seat_body: int
    seat: complex


class StageBodies(NamedTuple):
    """Numbers of one joint's bodies; ``previous`` carries ring or motor and may be GROUND.

    driven: what the motor turns, the sun; of a direct joint, which has no planets, the link.
    """

    previous: int
    link: int
    driven: int
    planets: tuple[int, ...]


def pitch_radius(joint: Planetary, teeth: int) -> float:
    """Radius [m] of a wheel of the joint where it rolls without sliding."""
    return joint.module_m * teeth / 2


def build_stages(arm: Arm) -> list[StageBodies]:
    """Numbers of every joint's bodies, counted joint by joint: link, then any sun and planets."""
    stages, previous, number = [], GROUND, 0
    for joint in arm.joints:
        link, driven = number, number
        if isinstance(joint, Planetary):
            driven += 1
        number = driven + 1 + joint.planet_count
        stages.append(StageBodies(previous, link, driven, tuple(range(driven + 1, number))))
        previous = link
    return stages


def body_count(arm: Arm) -> int:
    """Number of bodies that move."""
    last = build_stages(arm)[-1]
    return last.driven + 1 + len(last.planets)


def build_bodies(arm: Arm) -> list[RigidBody]:
    """Every moving body of the arm, in the order of ``build_stages``."""
    bodies = []
    for place, (stage, joint) in enumerate(zip(build_stages(arm), arm.joints, strict=True)):
        axis = ring_seat(arm, place) + 0j
        bodies.append(RigidBody(link_parts(arm, place), stage.previous, axis))
        if isinstance(joint, Planetary):
            sun = (Part(joint.sun_mass_kg, 0.0, gear_inertia(joint, "sun")),)
            planet = (Part(joint.planet_mass_kg, 0.0, gear_inertia(joint, "planet")),)
            bodies.append(RigidBody(sun, stage.previous, axis))
            bodies += [RigidBody(planet, stage.link, seat) for seat in planet_seats(joint)]
    return bodies


def ring_seat(arm: Arm, place: int) -> float:
    """How far along its body's x axis a joint's ring or motor is centred [m]: 0 on the ground."""
    return arm.links[place - 1].length_m if place else 0.0


def planet_seats(joint: Planetary) -> list[complex]:
    """Centres of the planets on their carrier [m], the first on its x axis."""
    radius = pitch_radius(joint, joint.sun_teeth) + pitch_radius(joint, joint.planet_teeth)
    turns = np.arange(joint.planet_count) / joint.planet_count
    return [complex(seat) for seat in radius * np.exp(2j * np.pi * turns)]


def link_parts(arm: Arm, place: int) -> tuple[Part, ...]:
    """Parts of a link's body: the link, its carrier or rotor, and what its far end carries.

    That is the next joint's ring or motor, or the payload.
    """
    joint, end = arm.joints[place], arm.links[place].length_m
    if isinstance(joint, Planetary):
        hub = Part(joint.carrier_mass_kg, 0.0, gear_inertia(joint, "carrier"))
    else:
        hub = Part(0.0, 0.0, joint.rotor_inertia_kg_m2)
    tip = Part(arm.payload_mass_kg, end, 0.0)
    if place + 1 < len(arm.joints):
        outer = arm.joints[place + 1]
        if isinstance(outer, Planetary):
            tip = Part(outer.ring_mass_kg, end, outer.ring_inertia_kg_m2)
        else:
            tip = Part(outer.motor_mass_kg, end, 0.0)
    return _bare_link(arm.links[place]), hub, tip


def _bare_link(link: Link) -> Part:
    mass, inertia = link.mass_kg, link.inertia_kg_m2
    if link.cross_section_m2 is not None and link.density_kg_per_m3 is not None:
        mass = link.length_m * link.cross_section_m2 * link.density_kg_per_m3
        inertia = mass * link.length_m**2 / 12
    assert mass is not None
    assert inertia is not None
    return Part(mass, link.com_m, inertia)


def gear_inertia(joint: Planetary, gear: Gear) -> float:
    """Inertia J [kg m^2], or the M [kg] given instead times the square of ``base_radius``."""
    inertia, mass = _inertia_and_mass(joint, gear)
    if mass is not None:
        return mass * base_radius(joint, gear) ** 2
    assert inertia is not None
    return inertia


def equivalent_mass(joint: Planetary, gear: Gear) -> float:
    """Equivalent mass M [kg], or J [kg m^2] given instead over the square of ``base_radius``."""
    inertia, mass = _inertia_and_mass(joint, gear)
    if inertia is not None:
        return inertia / base_radius(joint, gear) ** 2
    assert mass is not None
    return mass


def _inertia_and_mass(joint: Planetary, gear: Gear) -> tuple[float | None, float | None]:
    """J [kg m^2] and M [kg] of a gear as the arm gives them: one of them, the other None."""
    return getattr(joint, f"{gear}_inertia_kg_m2"), getattr(joint, f"{gear}_equivalent_mass_kg")


def base_radius(joint: Planetary, gear: Gear) -> float:
    """Base radius of a gear [m]; of the carrier r_c cos(alpha)."""
    teeth = {"sun": joint.sun_teeth, "planet": joint.planet_teeth}
    pitch = pitch_radius(joint, teeth.get(gear, joint.sun_teeth + joint.planet_teeth))
    return pitch * float(np.cos(np.radians(joint.pressure_angle_deg)))


def angle_matrix(arm: Arm, layout: Layout) -> np.ndarray:
    """Matrix that gives the bodies' absolute angles by the coordinates, shape (bodies, n).

    Eqs. 2 and 3 give the wheels' angles relative to the previous link, planets against the carrier:
    r_p theta_p = x_pr + r_cp theta_c and r_s theta_s = x_sp + r_p theta_p + r_cp theta_c.
    """
    turns, unit = np.zeros((body_count(arm), len(layout))), np.eye(len(layout))
    for place, (stage, joint) in enumerate(zip(build_stages(arm), arm.joints, strict=True)):
        base = turns[stage.previous] if place else np.zeros(len(layout))
        theta = unit[layout.at("theta", place)]
        turns[stage.link] = base + theta
        if isinstance(joint, Planetary):
            r_s, r_p = base_radius(joint, "sun"), base_radius(joint, "planet")
            x_sp, x_pr = (
                np.array([layout.displacement(mesh, place, p) for p in range(joint.planet_count)])
                for mesh in MESHES
            )
            along_planets = x_pr + (r_s + r_p) * theta
            turns[list(stage.planets)] = base - along_planets / r_p
            along_sun = x_sp[0] + along_planets[0] + (r_s + r_p) * theta  # by any of the planets
            turns[stage.driven] = base + along_sun / r_s
    return turns


def coordinate_matrix(arm: Arm, layout: Layout) -> np.ndarray:
    """Matrix that gives the coordinates by absolute angles, (n, bodies); mean of lumped planets.

    Solved for by hand: a pseudo-inverse leaves of a link's small acceleration what rounding of the
    gears' large ones does.
    """
    unit = np.eye(body_count(arm))
    paper = np.zeros((len(layout), len(unit)))
    for place, (stage, joint) in enumerate(zip(build_stages(arm), arm.joints, strict=True)):
        base = unit[stage.previous] if place else np.zeros(len(unit))
        theta = unit[stage.link] - base
        paper[layout.at("theta", place)] = theta
        if isinstance(joint, Planetary):
            r_s, r_p = base_radius(joint, "sun"), base_radius(joint, "planet")
            turning = unit[list(stage.planets)]
            planet_angles = turning if layout.free else turning.mean(axis=0, keepdims=True)
            along_planets, carried = r_p * (base - planet_angles), (r_s + r_p) * theta
            paper[ring_places(layout, place)] = along_planets - carried
            along_sun = r_s * (unit[stage.driven] - base)
            if layout.free:
                paper[layout.at("x_s", place)] = along_sun - 2 * carried
            else:
                paper[layout.at("x_sp", place)] = along_sun - along_planets[0] - carried
    return paper


def ring_places(layout: Layout, place: int) -> list[int]:
    """Places of a joint's x_pr: one of lumped planets, or one for each; joints count from 0."""
    entries = enumerate(layout.coordinates)
    return [k for k, c in entries if c.meaning == "x_pr" and c.joint == place + 1]


def lever_matrix(bodies: Sequence[RigidBody], links: Sequence[int]) -> np.ndarray:
    """Complex levers L [m], (bodies, links): a body's origin is sum L exp(i angle of the link)."""
    levers = np.zeros((len(bodies), len(links)), dtype=complex)
    for number, body in enumerate(bodies):
        if body.seat_body != GROUND:
            levers[number] = levers[body.seat_body]
            levers[number, links.index(body.seat_body)] += body.seat
    return levers


class PoseMap:
    """q, v, a of a geared arm's layout as poses of all bodies, and the way back.

    Poses, velocities and accelerations of the bodies have shape (3 bodies,): x, y [m] and angle
    [rad] of body after body.
    """

    def __init__(self, arm: Arm, layout: Layout) -> None:
        self.links = [stage.link for stage in build_stages(arm)]
        self.turns = angle_matrix(arm, layout)
        self.levers = lever_matrix(build_bodies(arm), self.links)
        self._coordinate_matrix = coordinate_matrix(arm, layout)

    def pose(self, q: np.ndarray) -> np.ndarray:
        """Poses of all bodies at coordinates q (n,), shape (3 bodies,)."""
        return _stack_poses(self.levers @ self._directions(q), self.turns @ q)

    def velocity(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Velocities of all bodies at q and rates v, shape (3 bodies,)."""
        spin = self.turns @ v
        return _stack_poses(self.levers @ (1j * spin[self.links] * self._directions(q)), spin)

    def acceleration(self, q: np.ndarray, v: np.ndarray, a: np.ndarray) -> np.ndarray:
        """Accelerations of all bodies at q, rates v and accelerations a, shape (3 bodies,)."""
        spin, turning = (self.turns @ v)[self.links], self.turns @ a
        swing = (1j * turning[self.links] - spin**2) * self._directions(q)
        return _stack_poses(self.levers @ swing, turning)

    def jacobian(self, q: np.ndarray) -> np.ndarray:
        """Derivative of ``pose``, shape (3 bodies, n)."""
        swing = 1j * self._directions(q)[:, None] * self.turns[self.links]
        return _stack_poses(self.levers @ swing, self.turns)

    def coordinates(self, turning: np.ndarray) -> np.ndarray:
        """q (n,) from the bodies' angles (bodies,), or its rates or accelerations from theirs."""
        return self._coordinate_matrix @ turning

    def _directions(self, q: np.ndarray) -> np.ndarray:
        return np.exp(1j * (self.turns @ q)[self.links])


def _stack_poses(at: np.ndarray, angle: np.ndarray) -> np.ndarray:
    return np.stack([at.real, at.imag, angle], axis=1).reshape(-1, *angle.shape[1:])

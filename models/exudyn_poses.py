"""The geared arm as separate bodies in the plane, and the paper's coordinates as their poses.

Frames: x, y in the plane, the ground's origin at the shoulder; angles are absolute, about z,
counter-clockwise. The origin of every body lies on the axis of its own revolute joint: a link's on
the joint that drives it, a gear's at its centre. At zero all bodies' x axes are parallel. Points of
the plane are complex numbers.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from models.arm import Arm, Joint

GROUND = -1
MOVES_ALIKE = 1e-9  # of the largest; what a linear solve leaves between equal planets is 1e-12


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


class Stage(NamedTuple):
    """Numbers of one joint's bodies; ``previous`` carries the ring and may be GROUND."""

    previous: int
    link: int
    sun: int
    planets: tuple[int, ...]


def pitch_radius(joint: Joint, teeth: int) -> float:
    """Radius [m] of a wheel of the joint where it rolls without sliding."""
    return joint.module_m * teeth / 2


def stages_of(arm: Arm) -> list[Stage]:
    """Bodies are counted joint by joint: link, sun, planets."""
    stages, previous, first = [], GROUND, 0
    for joint in arm.joints:
        after = first + 2 + joint.planet_count
        stages.append(Stage(previous, first, first + 1, tuple(range(first + 2, after))))
        previous, first = first, after
    return stages


def bodies_of(arm: Arm) -> list[RigidBody]:
    """Every moving body of the arm, in the order of ``stages_of``."""
    bodies = []
    for place, (stage, joint) in enumerate(zip(stages_of(arm), arm.joints, strict=True)):
        axis = ring_seat(arm, place) + 0j
        sun = (Part(joint.sun_mass_kg, 0.0, _gear_inertia(joint, "sun")),)
        planet = (Part(joint.planet_mass_kg, 0.0, _gear_inertia(joint, "planet")),)
        bodies.append(RigidBody(link_parts(arm, place), stage.previous, axis))
        bodies.append(RigidBody(sun, stage.previous, axis))
        bodies += [RigidBody(planet, stage.link, seat) for seat in planet_seats(joint)]
    return bodies


def ring_seat(arm: Arm, place: int) -> float:
    """How far along its body's x axis a joint's ring is centred [m]: 0 on the ground."""
    return arm.links[place - 1].length_m if place else 0.0


def planet_seats(joint: Joint) -> list[complex]:
    """Centres of the planets on their carrier [m], the first on its x axis."""
    radius = pitch_radius(joint, joint.sun_teeth) + pitch_radius(joint, joint.planet_teeth)
    turns = np.arange(joint.planet_count) / joint.planet_count
    return [complex(seat) for seat in radius * np.exp(2j * np.pi * turns)]


def link_parts(arm: Arm, place: int) -> tuple[Part, ...]:
    """Rod and carrier, and at the far end the next joint's ring or the payload."""
    link, joint = arm.links[place], arm.joints[place]
    rod = link.length_m * link.cross_section_m2 * link.density_kg_per_m3
    end = Part(arm.payload_mass_kg, link.length_m, 0.0)
    if place + 1 < len(arm.joints):
        outer = arm.joints[place + 1]
        end = Part(outer.ring_mass_kg, link.length_m, outer.ring_inertia_kg_m2)
    return (
        Part(rod, link.com_m, rod * link.length_m**2 / 12),
        Part(joint.carrier_mass_kg, 0.0, _gear_inertia(joint, "carrier")),
        end,
    )


def _gear_inertia(joint: Joint, gear: str) -> float:
    """J = M r^2, r the base radius, of the carrier r_c cos(alpha)."""
    teeth, mass = {
        "sun": (joint.sun_teeth, joint.sun_equivalent_mass_kg),
        "planet": (joint.planet_teeth, joint.planet_equivalent_mass_kg),
        "carrier": (joint.sun_teeth + joint.planet_teeth, joint.carrier_equivalent_mass_kg),
    }[gear]
    return mass * (pitch_radius(joint, teeth) * _cosine(joint)) ** 2


def _cosine(joint: Joint) -> float:
    return float(np.cos(np.radians(joint.pressure_angle_deg)))


def turns_of(arm: Arm) -> np.ndarray:
    """Absolute angles of the bodies over the paper's coordinates, shape (bodies, 3 joints).

    Eqs. 2 and 3 give the wheels' angles relative to the previous link, planets against the carrier:
    r_p theta_p = x_pr + r_cp theta_c and r_s theta_s = x_sp + r_p theta_p + r_cp theta_c.
    """
    stages = stages_of(arm)
    turns = np.zeros((stages[-1].planets[-1] + 1, 3 * len(stages)))
    x_sp, x_pr, theta = np.eye(3 * len(stages)).reshape(-1, 3, 3 * len(stages)).swapaxes(0, 1)
    for place, (stage, joint) in enumerate(zip(stages, arm.joints, strict=True)):
        r_s, r_p = (
            pitch_radius(joint, teeth) * _cosine(joint)
            for teeth in (joint.sun_teeth, joint.planet_teeth)
        )
        base = turns[stage.previous] if place else np.zeros(3 * len(stages))
        along_planet = x_pr[place] + (r_s + r_p) * theta[place]
        turns[stage.link] = base + theta[place]
        turns[list(stage.planets)] = base - along_planet / r_p
        turns[stage.sun] = base + (x_sp[place] + along_planet + (r_s + r_p) * theta[place]) / r_s
    return turns


def levers_of(bodies: Sequence[RigidBody], links: Sequence[int]) -> np.ndarray:
    """Complex levers L [m], (bodies, links): a body's origin is sum L exp(i angle of the link)."""
    levers = np.zeros((len(bodies), len(links)), dtype=complex)
    for number, body in enumerate(bodies):
        if body.seat_body != GROUND:
            levers[number] = levers[body.seat_body]
            levers[number, links.index(body.seat_body)] += body.seat
    return levers


class PoseMap:
    """The paper's q, v, a as poses of all bodies, and the way back.

    Poses, velocities and accelerations of the bodies have shape (3 bodies,): x, y [m] and angle
    [rad] of body after body.
    """

    def __init__(self, arm: Arm) -> None:
        self.links = [stage.link for stage in stages_of(arm)]
        self.turns = turns_of(arm)
        self.levers = levers_of(bodies_of(arm), self.links)
        self._back = np.linalg.pinv(self.turns)  # the mean over the planets of a stage

    def pose(self, q: np.ndarray) -> np.ndarray:
        """Where the bodies are."""
        return _flat(self.levers @ self._directions(q), self.turns @ q)

    def velocity(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """How they move at rates v."""
        spin = self.turns @ v
        return _flat(self.levers @ (1j * spin[self.links] * self._directions(q)), spin)

    def acceleration(self, q: np.ndarray, v: np.ndarray, a: np.ndarray) -> np.ndarray:
        """How they accelerate at rates v and accelerations a."""
        spin, turning = (self.turns @ v)[self.links], self.turns @ a
        swing = (1j * turning[self.links] - spin**2) * self._directions(q)
        return _flat(self.levers @ swing, turning)

    def jacobian(self, q: np.ndarray) -> np.ndarray:
        """Derivative of ``pose``, shape (3 bodies, n)."""
        swing = 1j * self._directions(q)[:, None] * self.turns[self.links]
        return _flat(self.levers @ swing, self.turns)

    def paper(self, turning: np.ndarray) -> np.ndarray:
        """The paper's coordinates (n,) of angles, or their rates or accelerations, (bodies,).

        Raises ArithmeticError if planets of one stage differ.
        """
        paper = self._back @ turning
        if not np.allclose(self.turns @ paper, turning, rtol=0, atol=MOVES_ALIKE * _size(turning)):
            raise ArithmeticError("equal planets do not move alike")
        return paper

    def _directions(self, q: np.ndarray) -> np.ndarray:
        return np.exp(1j * (self.turns @ q)[self.links])


def _flat(at: np.ndarray, angle: np.ndarray) -> np.ndarray:
    return np.stack([at.real, at.imag, angle], axis=1).reshape(-1, *angle.shape[1:])


def _size(values: np.ndarray) -> float:
    return float(abs(values).max())

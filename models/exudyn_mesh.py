"""Gear meshes for the Exudyn tree: the force law, compiled, and the numbers it needs per mesh.

Seen from the carrier every planet turns about a fixed axis, so the belts along the two lines of
action give, with w the rotation of the central wheel and p that of the planet, both relative to
the carrier, and R and r the base radii,

    external mesh with the sun:   x = R w + r p
    internal mesh with the ring:  x = R w - r p

x > 0 when the teeth press on the side that drives the carrier forward. One law covers both, with a
signed planet radius. (Eq. n) refers to the paper the arm is taken from.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, NamedTuple

import numpy as np
from numba import njit

from models.arm import Mesh, Planetary
from models.exudyn_tree_stiffness import Curve, constant, curve_of, stiffness_at
from models.switches import Switches

Side = Literal["sun", "ring"]
Gear = Literal["sun", "planet", "carrier"]
EPSILON = float(np.finfo(float).eps)
ROUNDINGS = 10  # in a deflection: sums of three products, and maps of coordinates before


class MeshLaw(NamedTuple):
    """One mesh in SI units; ``array`` lays it out for the compiled functions in this order.

    wheel_radius, planet_radius: base radii of the deflection above, the latter negative for the
    ring. damping [N s/m]: of this one mesh, 1/N of the stage's. phase_rate: radians of mesh phase
    per radian of joint angle. clock_phase, smooth and damped_in_contact_only are switches, 1.0 or
    0.0. curve: the stiffness.
    """

    wheel_radius: float
    planet_radius: float
    tooth_error: float
    backlash: float
    damping: float
    sharpness: float
    phase_rate: float
    phase_offset: float
    clock_phase: float
    smooth: float
    damped_in_contact_only: float
    curve: Curve

    @property
    def array(self) -> np.ndarray:
        """The fields as float64, those of the curve from place CURVE on."""
        return np.concatenate([self[:CURVE], self.curve.array])


_FIELDS = {name: place for place, name in enumerate(MeshLaw._fields)}
WHEEL_RADIUS, PLANET_RADIUS = _FIELDS["wheel_radius"], _FIELDS["planet_radius"]
ERROR, BACKLASH = _FIELDS["tooth_error"], _FIELDS["backlash"]
DAMPING, SHARPNESS = _FIELDS["damping"], _FIELDS["sharpness"]
RATE, OFFSET = _FIELDS["phase_rate"], _FIELDS["phase_offset"]
BY_CLOCK, SMOOTH = _FIELDS["clock_phase"], _FIELDS["smooth"]
CONTACT_ONLY, CURVE = _FIELDS["damped_in_contact_only"], _FIELDS["curve"]


def base_radius(joint: Planetary, teeth: int) -> float:
    """Radius [m] of the circle the involutes of a wheel with this many teeth unwind from."""
    return joint.module_m * teeth / 2 * float(np.cos(np.radians(joint.pressure_angle_deg)))


def inertia(joint: Planetary, gear: Gear) -> float:
    """J [kg m^2] of a gear or the carrier, as given or M r^2."""
    mass, given, radius = _gear(joint, gear)
    if given is not None:
        return given
    assert mass is not None
    return mass * radius**2


def equivalent_mass(joint: Planetary, gear: Gear) -> float:
    """M [kg] of a gear or the carrier, as given or J / r^2."""
    mass, given, radius = _gear(joint, gear)
    if mass is not None:
        return mass
    assert given is not None
    return given / radius**2


def _gear(joint: Planetary, gear: Gear) -> tuple[float | None, float | None, float]:
    """M or J, whichever is given, and r [m], of the carrier r_c cos(alpha)."""
    mass, given, teeth = {
        "sun": (joint.sun_equivalent_mass_kg, joint.sun_inertia_kg_m2, joint.sun_teeth),
        "planet": (joint.planet_equivalent_mass_kg, joint.planet_inertia_kg_m2, joint.planet_teeth),
        "carrier": (
            joint.carrier_equivalent_mass_kg,
            joint.carrier_inertia_kg_m2,
            joint.sun_teeth + joint.planet_teeth,
        ),
    }[gear]
    return mass, given, base_radius(joint, teeth)


def mesh_law(joint: Planetary, chosen: Switches, side: Side) -> MeshLaw:
    """The law of each of the joint's equal meshes on one side of the planets."""
    sun = side == "sun"
    mesh = joint.sun_mesh if sun else joint.ring_mesh
    planet_radius, curve = base_radius(joint, joint.planet_teeth), curve_of(mesh.stiffness)
    return MeshLaw(
        wheel_radius=base_radius(joint, joint.sun_teeth if sun else joint.ring_teeth),
        planet_radius=planet_radius if sun else -planet_radius,
        tooth_error=mesh.tooth_error_m,
        backlash=mesh.backlash_m,
        damping=_stage_damping(joint, side, mesh, curve.mean) / joint.planet_count,
        sharpness=mesh.tanh_sharpness_per_m,
        phase_rate=_phase_rate(joint, chosen, side),
        phase_offset=mesh.phase_rad,
        clock_phase=float(chosen.phase == "omega_t"),
        smooth=float(chosen.dead_zone == "tanh"),
        damped_in_contact_only=float(chosen.damping == "contact"),
        curve=curve,
    )


def stiffest(law: MeshLaw) -> MeshLaw:
    """The linear law that bounds this one: in contact everywhere, at its largest stiffness."""
    return _linear(law, law.curve.largest)


def mean_spring(law: MeshLaw) -> MeshLaw:
    """The law's mean stiffness alone: in contact everywhere, undamped."""
    return _linear(law, law.curve.mean)._replace(damping=0.0)


def _linear(law: MeshLaw, stiffness: float) -> MeshLaw:
    return law._replace(
        curve=constant(stiffness),
        tooth_error=0.0,
        backlash=0.0,
        smooth=0.0,
        damped_in_contact_only=0.0,
    )


def _stage_damping(joint: Planetary, side: Side, mesh: Mesh, stiffness: float) -> float:
    """Damping [N s/m] of all N meshes of one side together: 2 zeta sqrt(N k_m * mass)."""
    planets = joint.planet_count
    sun_mass, planet_mass = equivalent_mass(joint, "sun"), equivalent_mass(joint, "planet")
    mass = sun_mass if side == "sun" else planets * planet_mass
    if mesh.damping_N_s_per_m is not None:
        return mesh.damping_N_s_per_m
    assert mesh.damping_ratio is not None
    return 2 * mesh.damping_ratio * float(np.sqrt(planets * stiffness * mass))


def _phase_rate(joint: Planetary, chosen: Switches, side: Side) -> float:
    """Teeth passing one planet per radian of the carrier: z_r on both sides, but for Eq. 13."""
    if side == "sun" or chosen.ring_rate == "corrected":
        return float(joint.ring_teeth)
    planet = base_radius(joint, joint.planet_teeth)
    carrier = base_radius(joint, joint.sun_teeth + joint.planet_teeth)  # r_c cos(alpha)
    return joint.planet_teeth * (carrier / planet - 1)


@njit(cache=True)
def clearance(x: float, b: float) -> float:
    """Eq. 5: f_k [m] of a deflection x [m] in a clearance 2 b [m]."""
    if x > b:
        return x - b
    if x <= -b:
        return x + b
    return 0.0


@njit(cache=True)
def smooth_clearance(x: float, b: float, sharpness: float) -> float:
    """Eq. 6: f_k [m] with tanh corners of the given sharpness [1/m]."""
    upper, lower = np.tanh(sharpness * (x - b)), np.tanh(sharpness * (x + b))
    return x + x / 2 * (upper - lower) - b / 2 * (upper + lower)


@njit(cache=True)
def variation(law: np.ndarray, t: float, theta: float, theta_dot: float) -> tuple[float, float]:
    """k [N/m] and sin(phi) at time t [s], joint angle [rad] and rate [rad/s] (Eqs. 8, 14)."""
    angle = theta_dot * t if law[BY_CLOCK] else theta
    phase = law[RATE] * angle + law[OFFSET]
    sine = np.sin(phase)
    return stiffness_at(law, CURVE, phase, sine), sine


@njit(cache=True)
def elastic_force(law: np.ndarray, x: float, stiffness: float, sine: float) -> float:
    """Spring force [N] along the line of action (Eqs. 4, 8, 14, 15)."""
    gap = x - law[ERROR] * sine
    if law[SMOOTH]:
        travel = smooth_clearance(gap, law[BACKLASH], law[SHARPNESS])
    else:
        travel = clearance(gap, law[BACKLASH])
    return stiffness * travel


@njit(cache=True)
def damping_force(law: np.ndarray, x: float, x_dot: float, sine: float) -> float:
    """Damper force [N] along the line of action."""
    if law[CONTACT_ONLY] and abs(x - law[ERROR] * sine) <= law[BACKLASH]:
        return 0.0
    return law[DAMPING] * x_dot


@njit(cache=True)
def mesh_force(
    law: np.ndarray,
    stiffness: float,
    sine: float,
    wheel: float,
    planet: float,
    carrier: float,
    wheel_dot: float,
    planet_dot: float,
    carrier_dot: float,
) -> float:
    """Force [N] of one mesh along its line of action, spring and damper.

    stiffness and sine: of ``variation``. wheel and carrier turn relative to the previous link,
    planet relative to the carrier, rad and rad/s.
    """
    x = law[WHEEL_RADIUS] * (wheel - carrier) + law[PLANET_RADIUS] * planet
    x_dot = law[WHEEL_RADIUS] * (wheel_dot - carrier_dot) + law[PLANET_RADIUS] * planet_dot
    return elastic_force(law, x, stiffness, sine) + damping_force(law, x, x_dot, sine)


@njit(cache=True)
def elastic_forces(
    law: np.ndarray, t: np.ndarray, x: np.ndarray, theta: np.ndarray, theta_dot: np.ndarray
) -> np.ndarray:
    """Spring forces [N], shape (times, planets), along a trajectory.

    t, theta, theta_dot of shape (times,); x [m] of shape (times, planets).
    """
    forces = np.empty_like(x)
    for row in range(len(t)):
        stiffness, sine = variation(law, t[row], theta[row], theta_dot[row])
        for planet in range(x.shape[1]):
            forces[row, planet] = elastic_force(law, x[row, planet], stiffness, sine)
    return forces


class Stage(NamedTuple):
    """Places of one joint's bodies among the tree coordinates.

    driven: what the motor turns, the sun; of a direct joint, which has no planets, the link.
    """

    link: int
    driven: int
    planets: tuple[int, ...]

    @property
    def after(self) -> int:
        """The place after its last body."""
        return max((self.driven, *self.planets)) + 1


class GearStage(NamedTuple):
    """A geared joint, counted from 0, its bodies, a planet's inertia [kg m^2] and its mesh laws."""

    joint: int
    bodies: Stage
    planet_inertia: float
    sun: MeshLaw
    ring: MeshLaw


def gear_stage(place: int, bodies: Stage, joint: Planetary, chosen: Switches) -> GearStage:
    """What is known of a geared joint, the place-th from 0."""
    sun, ring = mesh_law(joint, chosen, "sun"), mesh_law(joint, chosen, "ring")
    return GearStage(place, bodies, inertia(joint, "planet"), sun, ring)


class Gearing(NamedTuple):
    """All gear stages of an arm as flat arrays, one row per geared joint.

    sun_laws, ring_laws (stages, longest law): MeshLaw.array, zeros behind it; places (stages, 4):
    tree coordinates of link, sun and first planet, and the one after the last planet.
    """

    sun_laws: np.ndarray
    ring_laws: np.ndarray
    places: np.ndarray


def gearing(gears: Sequence[GearStage]) -> Gearing:
    """The stages with their laws."""
    stages = [gear.bodies for gear in gears]
    places = [(s.link, s.driven, s.planets[0], s.planets[-1] + 1) for s in stages]
    return Gearing(
        _rows([gear.sun.array for gear in gears]),
        _rows([gear.ring.array for gear in gears]),
        np.array(places, dtype=np.int64).reshape(-1, 4),
    )


def _rows(arrays: Sequence[np.ndarray]) -> np.ndarray:
    rows = np.zeros((len(arrays), max((array.size for array in arrays), default=0)))
    for row, array in zip(rows, arrays, strict=True):
        row[: array.size] = array
    return rows


@njit(cache=True)
def add_sun_mesh(
    law: np.ndarray,
    stiffness: float,
    sine: float,
    q: np.ndarray,
    q_t: np.ndarray,
    link: int,
    sun: int,
    planet: int,
    forces: np.ndarray,
) -> None:
    """Spring and damper of one sun-planet mesh, onto the forces [N m] of the three it couples."""
    pull = mesh_force(
        law, stiffness, sine, q[sun], q[planet], q[link], q_t[sun], q_t[planet], q_t[link]
    )
    forces[link] += law[WHEEL_RADIUS] * pull
    forces[sun] -= law[WHEEL_RADIUS] * pull
    forces[planet] -= law[PLANET_RADIUS] * pull


@njit(cache=True)
def add_ring_mesh(
    law: np.ndarray,
    stiffness: float,
    sine: float,
    q: np.ndarray,
    q_t: np.ndarray,
    link: int,
    planet: int,
    forces: np.ndarray,
) -> None:
    """One ring-planet mesh, as ``add_sun_mesh``: the ring rests on the previous link."""
    pull = mesh_force(law, stiffness, sine, 0.0, q[planet], q[link], 0.0, q_t[planet], q_t[link])
    forces[link] += law[WHEEL_RADIUS] * pull
    forces[planet] -= law[PLANET_RADIUS] * pull


@njit(cache=True)
def add_meshes(
    gears: Gearing, t: float, q: np.ndarray, q_t: np.ndarray, forces: np.ndarray
) -> None:
    """Every mesh spring of the arm at time t [s], onto the forces [N m] of the tree coordinates."""
    for stage in range(len(gears.places)):
        link, sun, first, after = gears.places[stage]
        of_sun, of_ring = gears.sun_laws[stage], gears.ring_laws[stage]
        sun_stiffness, sun_sine = variation(of_sun, t, q[link], q_t[link])
        ring_stiffness, ring_sine = variation(of_ring, t, q[link], q_t[link])
        for planet in range(first, after):
            add_sun_mesh(of_sun, sun_stiffness, sun_sine, q, q_t, link, sun, planet, forces)
            add_ring_mesh(of_ring, ring_stiffness, ring_sine, q, q_t, link, planet, forces)


def deflection(law: MeshLaw, stage: Stage, q: np.ndarray, with_sun: bool) -> np.ndarray:
    """x [m] of a stage's meshes with sun or ring, shape (times, planets), from (times, bodies).

    Linear: angles give displacements, and their rates the displacements' rates.
    """
    wheel = q[:, stage.driven] if with_sun else 0.0
    turn = law.wheel_radius * (wheel - q[:, stage.link])
    return turn[:, None] + law.planet_radius * q[:, list(stage.planets)]


def torque_rounding(law: MeshLaw, stage: Stage, q: np.ndarray, q_t: np.ndarray) -> float:
    """What roundings of a linear law's deflection and rate may change on a planet [N m].

    q, q_t: tree coordinates and rates (bodies,), all planets alike.
    """

    def path(turned: np.ndarray) -> float:  # what a deflection is the small difference of
        link, wheel, planet = abs(turned[[stage.link, stage.driven, stage.planets[0]]])
        return law.wheel_radius * float(link + wheel) + abs(law.planet_radius) * float(planet)

    force = law.curve.mean * path(q) + law.damping * path(q_t)
    return ROUNDINGS * EPSILON * abs(law.planet_radius) * force

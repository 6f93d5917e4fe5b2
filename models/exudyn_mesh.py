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

from typing import Literal, NamedTuple

import numpy as np
from numba import njit

from models.arm import Joint
from models.exudyn_engine import UserFunction
from models.switches import Switches

Side = Literal["sun", "ring"]


class MeshLaw(NamedTuple):
    """One mesh in SI units; ``array`` lays it out for the compiled functions in this order.

    wheel_radius, planet_radius: base radii of the deflection above, the latter negative for the
    ring. damping [N s/m]: of this one mesh, 1/N of the stage's. phase_rate: radians of mesh phase
    per radian of joint angle. The last three are switches, 1.0 or 0.0.
    """

    wheel_radius: float
    planet_radius: float
    stiffness: float
    stiffness_amplitude: float
    tooth_error: float
    backlash: float
    damping: float
    sharpness: float
    phase_rate: float
    phase_offset: float
    clock_phase: float
    smooth: float
    damped_in_contact_only: float

    @property
    def array(self) -> np.ndarray:
        """The fields as float64, shape (13,)."""
        return np.array(self)


_FIELDS = {name: place for place, name in enumerate(MeshLaw._fields)}
WHEEL_RADIUS, PLANET_RADIUS = _FIELDS["wheel_radius"], _FIELDS["planet_radius"]
K_M, K_A = _FIELDS["stiffness"], _FIELDS["stiffness_amplitude"]
ERROR, BACKLASH = _FIELDS["tooth_error"], _FIELDS["backlash"]
DAMPING, SHARPNESS = _FIELDS["damping"], _FIELDS["sharpness"]
RATE, OFFSET = _FIELDS["phase_rate"], _FIELDS["phase_offset"]
BY_CLOCK, SMOOTH = _FIELDS["clock_phase"], _FIELDS["smooth"]
CONTACT_ONLY = _FIELDS["damped_in_contact_only"]


def base_radius(joint: Joint, teeth: int) -> float:
    """Radius [m] of the circle the involutes of a wheel with this many teeth unwind from."""
    return joint.module_m * teeth / 2 * float(np.cos(np.radians(joint.pressure_angle_deg)))


def mesh_law(joint: Joint, chosen: Switches, side: Side) -> MeshLaw:
    """The law of each of the joint's equal meshes on one side of the planets."""
    sun = side == "sun"
    planet_radius = base_radius(joint, joint.planet_teeth)
    return MeshLaw(
        wheel_radius=base_radius(joint, joint.sun_teeth if sun else joint.ring_teeth),
        planet_radius=planet_radius if sun else -planet_radius,
        stiffness=joint.mesh_stiffness_N_per_m,
        stiffness_amplitude=joint.mesh_stiffness_amplitude_N_per_m,
        tooth_error=joint.tooth_error_m,
        backlash=joint.backlash_m,
        damping=_stage_damping(joint, side) / joint.planet_count,
        sharpness=joint.tanh_sharpness_per_m,
        phase_rate=_phase_rate(joint, chosen, side),
        phase_offset=0.0 if sun else joint.ring_mesh_phase_rad,
        clock_phase=float(chosen.phase == "omega_t"),
        smooth=float(chosen.dead_zone == "tanh"),
        damped_in_contact_only=float(chosen.damping == "contact"),
    )


def stiffest(law: MeshLaw) -> MeshLaw:
    """The linear law that bounds this one: in contact everywhere, at its largest stiffness."""
    return law._replace(
        stiffness=law.stiffness + law.stiffness_amplitude,
        stiffness_amplitude=0.0,
        tooth_error=0.0,
        backlash=0.0,
        smooth=0.0,
        damped_in_contact_only=0.0,
    )


def mean_spring(law: MeshLaw) -> MeshLaw:
    """The law's mean stiffness alone: in contact everywhere, undamped."""
    return stiffest(law)._replace(stiffness=law.stiffness, damping=0.0)


def _stage_damping(joint: Joint, side: Side) -> float:
    """Damping [N s/m] of all N meshes of one side together: 2 zeta sqrt(N k_m * mass)."""
    planets, stiffness = joint.planet_count, joint.mesh_stiffness_N_per_m
    sun_mass, planet_mass = joint.sun_equivalent_mass_kg, joint.planet_equivalent_mass_kg
    direct = joint.sun_planet_damping_N_s_per_m
    mass = sun_mass
    if side == "ring":
        direct, mass = joint.planet_ring_damping_N_s_per_m, planets * planet_mass
    if direct is not None:
        return direct
    assert joint.damping_ratio is not None
    return 2 * joint.damping_ratio * float(np.sqrt(planets * stiffness * mass))


def _phase_rate(joint: Joint, chosen: Switches, side: Side) -> float:
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
def mesh_sine(law: np.ndarray, t: float, theta: float, theta_dot: float) -> float:
    """sin(phi) at time t [s], joint angle [rad] and rate [rad/s] (Eqs. 8, 14)."""
    angle = theta_dot * t if law[BY_CLOCK] else theta
    return np.sin(law[RATE] * angle + law[OFFSET])


@njit(cache=True)
def elastic_force(law: np.ndarray, x: float, sine: float) -> float:
    """Spring force [N] along the line of action (Eqs. 4, 8, 14, 15)."""
    gap = x - law[ERROR] * sine
    if law[SMOOTH]:
        travel = smooth_clearance(gap, law[BACKLASH], law[SHARPNESS])
    else:
        travel = clearance(gap, law[BACKLASH])
    return (law[K_M] + law[K_A] * sine) * travel


@njit(cache=True)
def damping_force(law: np.ndarray, x: float, x_dot: float, sine: float) -> float:
    """Damper force [N] along the line of action."""
    if law[CONTACT_ONLY] and abs(x - law[ERROR] * sine) <= law[BACKLASH]:
        return 0.0
    return law[DAMPING] * x_dot


@njit(cache=True)
def mesh_force(
    law: np.ndarray,
    t: float,
    wheel: float,
    planet: float,
    carrier: float,
    wheel_dot: float,
    planet_dot: float,
    carrier_dot: float,
) -> float:
    """Force [N] of one mesh along its line of action, spring and damper.

    wheel and carrier turn relative to the previous link, planet relative to the carrier, rad and
    rad/s. The carrier's angle is the joint angle.
    """
    x = law[WHEEL_RADIUS] * (wheel - carrier) + law[PLANET_RADIUS] * planet
    x_dot = law[WHEEL_RADIUS] * (wheel_dot - carrier_dot) + law[PLANET_RADIUS] * planet_dot
    sine = mesh_sine(law, t, carrier, carrier_dot)
    return elastic_force(law, x, sine) + damping_force(law, x, x_dot, sine)


@njit(cache=True)
def elastic_forces(
    law: np.ndarray, t: np.ndarray, x: np.ndarray, theta: np.ndarray, theta_dot: np.ndarray
) -> np.ndarray:
    """Spring forces [N], shape (times, planets), along a trajectory.

    t, theta, theta_dot of shape (times,); x [m] of shape (times, planets).
    """
    forces = np.empty_like(x)
    for row in range(len(t)):
        sine = mesh_sine(law, t[row], theta[row], theta_dot[row])
        for planet in range(x.shape[1]):
            forces[row, planet] = elastic_force(law, x[row, planet], sine)
    return forces


class Stage(NamedTuple):
    """Places of one joint's bodies among the tree coordinates."""

    link: int
    sun: int
    planets: tuple[int, ...]


# Entered directly, past numba's choice among signatures: saves 0.2 us of 1.8 us per connector call.
_mesh_force = mesh_force.compile("float64(float64[::1]" + 7 * ", float64" + ")")


def sun_mesh(
    law: MeshLaw, stage: Stage, planet: int, size: int, clock: list[float]
) -> UserFunction:
    """Connector of a sun-planet mesh, planet being the planet's tree coordinate, of ``size``.

    ``clock[0]`` [s] is added to the engine's time.
    """
    numbers, big, small = law.array, law.wheel_radius, law.planet_radius
    link, sun, forces = stage.link, stage.sun, [0.0] * size

    def force(_: object, t: float, _item: int, q: list[float], q_t: list[float]) -> list[float]:
        pull = _mesh_force(
            numbers, clock[0] + t, q[sun], q[planet], q[link], q_t[sun], q_t[planet], q_t[link]
        )
        forces[link] = big * pull
        forces[sun] = -big * pull
        forces[planet] = -small * pull
        return forces

    return force


def ring_mesh(
    law: MeshLaw, stage: Stage, planet: int, size: int, clock: list[float]
) -> UserFunction:
    """Connector of a ring-planet mesh, as ``sun_mesh``: the ring rests on the previous link."""
    numbers, big, small = law.array, law.wheel_radius, law.planet_radius
    link, forces = stage.link, [0.0] * size

    def force(_: object, t: float, _item: int, q: list[float], q_t: list[float]) -> list[float]:
        pull = _mesh_force(
            numbers, clock[0] + t, 0.0, q[planet], q[link], 0.0, q_t[planet], q_t[link]
        )
        forces[link] = big * pull
        forces[planet] = -small * pull
        return forces

    return force


def deflection(law: MeshLaw, stage: Stage, q: np.ndarray, with_sun: bool) -> np.ndarray:
    """x [m] of a stage's meshes with sun or ring, shape (times, planets), from (times, bodies)."""
    wheel = q[:, stage.sun] if with_sun else 0.0
    turn = law.wheel_radius * (wheel - q[:, stage.link])
    return turn[:, None] + law.planet_radius * q[:, list(stage.planets)]

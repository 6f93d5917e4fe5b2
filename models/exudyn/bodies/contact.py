"""Tooth contact of two gears of a planetary stage, found from where their bodies are.

A mesh looks at four bodies: planet, carrier, the body of the central wheel and the previous link.
From the poses it takes the line of centres, the pitch point on it, and through that the line of
action, inclined by the pressure angle to the common tangent. The teeth's deflection is what the two
gears have turned against the line of centres, along the line of action. The force pushes both gears
at the pitch point: ``side`` +1 is an external mesh (sun), -1 an internal one (ring).

x and F are positive where the central wheel pushes the planet, and so the carrier, forward; the
other flank takes the negative ones. Either way the teeth press the gears' centres apart (sun), or
the planet inwards (ring). Where the teeth's energy may do work on the joint's angle, by which their
stiffness and error vary, carrier and previous link also feel a torque and its reaction. Points of
the plane are complex numbers. (Eq. n) is the paper's.
"""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np
from numba import types

from crosscheck.models.arm.arm import Planetary
from crosscheck.models.arm.mesh import PlanetMesh
from crosscheck.models.experiment.scenario import Switches
from crosscheck.models.exudyn.bodies.poses import equivalent_mass, pitch_radius, planet_seats
from crosscheck.models.exudyn.bodies.stiffness import Spring, build_spring, slope_at, stiffness_at
from crosscheck.models.numba_cache import njit

Side = Literal["sun", "ring"]
PLANET, CARRIER, WHEEL, PREVIOUS = 0, 1, 2, -1  # bodies of a mesh; a ring's wheel is the previous


class ContactMesh(NamedTuple):
    """One planet's mesh in SI units.

    seat [m]: the wheel's centre on its body's x axis. direction [rad]: line of centres at zero.
    error, error_phase, runout: of e = runout + error sin(phase + error_phase). kind, mean, numbers:
    a Spring's. damping [N s/m]: of this one mesh. teeth: mesh phase over joint angle; offset [rad]:
    mesh phase at zero. by_clock, smooth, contact_only, conservative are switches, 1.0 or 0.0.
    """

    side: float
    wheel_pitch: float
    planet_pitch: float
    cosine: float
    sine: float
    seat: float
    direction: float
    error: float
    error_phase: float
    runout: float
    backlash: float
    damping: float
    sharpness: float
    teeth: float
    offset: float
    clock_phase: float
    smooth: float
    contact_only: float
    conservative: float
    kind: float
    mean: float
    numbers: np.ndarray


class PointMotion(NamedTuple):
    """A point [m, m/s] and the angle [rad, rad/s] of the body it belongs to."""

    position: complex
    velocity: complex
    angle: float
    spin: float


class ContactState(NamedTuple):
    """Deflection [m] and its rate, line of centres, levers [m] of the two bodies, phase [rad]."""

    x: float
    x_dot: float
    along: complex
    planet_lever: complex
    wheel_lever: complex
    phase: float


def build_contact_mesh(
    joint: Planetary, chosen: Switches, side: Side, ring_at: float, planet: int
) -> ContactMesh:
    """The mesh of a planet, counted from 0, with sun or ring.

    ring_at [m]: where the ring is centred on its body's x axis.
    """
    sun, alpha = side == "sun", np.radians(joint.pressure_angle_deg)
    mesh = (joint.sun_mesh if sun else joint.ring_mesh).planet_mesh(planet)
    spring, direction = build_spring(mesh.stiffness), float(np.angle(planet_seats(joint)[planet]))
    return ContactMesh(
        side=1.0 if sun else -1.0,
        wheel_pitch=pitch_radius(joint, joint.sun_teeth if sun else joint.ring_teeth),
        planet_pitch=pitch_radius(joint, joint.planet_teeth),
        cosine=float(np.cos(alpha)),
        sine=float(np.sin(alpha)),
        seat=0.0 if sun else ring_at,
        direction=direction,
        error=mesh.tooth_error_m,
        error_phase=mesh.tooth_error_phase_rad,
        runout=mesh.static_error_m,
        backlash=mesh.backlash_m,
        damping=mesh_damping(joint, side, mesh, spring),
        sharpness=mesh.tanh_sharpness_per_m,
        teeth=teeth_passing(joint, chosen, side),
        offset=teeth_passed(joint, side, direction) if mesh.phase_rad is None else mesh.phase_rad,
        clock_phase=float(chosen.phase == "omega_t"),
        smooth=float(chosen.dead_zone == "tanh"),
        contact_only=float(chosen.damping == "contact"),
        conservative=float(chosen.mesh_work == "conservative"),
        kind=spring.kind,
        mean=spring.mean,
        numbers=spring.numbers,
    )


def mesh_damping(joint: Planetary, side: Side, mesh: PlanetMesh, spring: Spring) -> float:
    """Damping [N s/m] of one mesh: an N-th of 2 zeta sqrt(N k_m M), M = M_s or N M_p."""
    count, given = joint.planet_count, mesh.damping_N_s_per_m
    if given is None:
        assert mesh.damping_ratio is not None
        mass = equivalent_mass(joint, "sun")
        if side == "ring":
            mass = count * equivalent_mass(joint, "planet")
        given = mesh.damping_ratio * 2 * float(np.sqrt(count * spring.mean * mass))
    return given / count


def teeth_passed(joint: Planetary, side: Side, direction: float) -> float:
    """Mesh phase [rad] at zero of a planet on a line of centres of this direction [rad].

    Every tooth of a wheel that passes the line of centres adds 2 pi; the sun's come from behind and
    the ring's from before, and at zero both wheels have turned by -direction against that line.
    Between the planet's two pitch points lies half a turn of its teeth, and from the flank that
    the sun pushes to the one that the ring pushes half a pitch less.
    """
    if side == "sun":
        passed = -joint.sun_teeth * direction
    else:
        passed = joint.ring_teeth * direction + (joint.planet_teeth - 1) % 2 * np.pi
        passed += joint.sun_mesh.planet_mesh(0).phase_rad or 0.0
    return float(passed % (2 * np.pi))


def teeth_passing(joint: Planetary, chosen: Switches, side: Side) -> float:
    """Radians of mesh phase per radian of the carrier (Eqs. 12, 13)."""
    if side == "ring" and chosen.ring_rate == "eq13":
        carrier_teeth = joint.sun_teeth + joint.planet_teeth  # r_c cos(alpha), in teeth
        return joint.planet_teeth * (carrier_teeth / joint.planet_teeth - 1)
    return float(joint.ring_teeth)


@njit(cache=True)
def dead_zone(gap: float, b: float) -> float:
    """Eq. 5: f_k [m], what of a deflection is beyond a clearance 2 b [m]."""
    return gap - min(max(gap, -b), b)


@njit(cache=True)
def rounded_dead_zone(gap: float, b: float, sharpness: float) -> float:
    """Eq. 6: f_k [m] with tanh corners of the given sharpness [1/m]."""
    above, below = gap - b, gap + b
    return gap + (above * np.tanh(sharpness * above) - below * np.tanh(sharpness * below)) / 2


@njit(cache=True)
def gap_of(mesh: ContactMesh, contact: ContactState) -> float:
    """Gap x - e [m] of a mesh (Eq. 14)."""
    return contact.x - mesh.runout - mesh.error * np.sin(contact.phase + mesh.error_phase)


@njit(cache=True)
def travel_of(mesh: ContactMesh, contact: ContactState) -> float:
    """f_k [m], how far the teeth are pressed together."""
    gap = gap_of(mesh, contact)
    if mesh.smooth:
        return rounded_dead_zone(gap, mesh.backlash, mesh.sharpness)
    return dead_zone(gap, mesh.backlash)


@njit(cache=True)
def elastic_force(mesh: ContactMesh, contact: ContactState) -> float:
    """Spring force [N] along the line of action (Eqs. 4, 8, 14, 15)."""
    stiffness = stiffness_at(mesh.kind, mesh.mean, mesh.numbers, contact.phase)
    return stiffness * travel_of(mesh, contact)


@njit(cache=True)
def damping_force(mesh: ContactMesh, contact: ContactState) -> float:
    """Damper force [N] along the line of action."""
    is_undamped = mesh.contact_only and dead_zone(gap_of(mesh, contact), mesh.backlash) == 0
    return 0.0 if is_undamped else mesh.damping * contact.x_dot


@njit(cache=True)
def carrier_torque(mesh: ContactMesh, contact: ContactState) -> float:
    """Torque [N m] on the carrier: what the spring's k f^2 / 2 loses per its angle, x held."""
    travel = travel_of(mesh, contact)
    stiffening = slope_at(mesh.kind, mesh.numbers, contact.phase) * travel**2 / 2
    closing = mesh.error * np.cos(contact.phase + mesh.error_phase)  # what the error takes of f
    return mesh.teeth * (closing * elastic_force(mesh, contact) - stiffening)


@njit(cache=True)
def motion(q: np.ndarray, q_t: np.ndarray, body: int) -> PointMotion:
    """Motion of a body's origin out of the poses and rates, (3 bodies,), of a mesh's bodies."""
    x, y, angle = 3 * body, 3 * body + 1, 3 * body + 2
    return PointMotion(complex(q[x], q[y]), complex(q_t[x], q_t[y]), q[angle], q_t[angle])


@njit(cache=True)
def point_motion(body: PointMotion, lever: complex) -> PointMotion:
    """Motion of the point of a body that lies at this lever [m], ground frame, from its origin."""
    return PointMotion(
        body.position + lever, body.velocity + 1j * body.spin * lever, body.angle, body.spin
    )


@njit(cache=True)
def line_rotation(line: complex, direction: float, carrier: float) -> float:
    """Rotation of the line of centres since zero [rad]; the carrier's angle counts full turns."""
    angle = np.arctan2(line.imag, line.real) - direction
    return angle + 2 * np.pi * np.round((carrier - angle) / (2 * np.pi))


@njit(cache=True)
def line_of_action(mesh: ContactMesh, along: complex, flank: float) -> complex:
    """Unit vector in which a force of this sign pushes the planet forward (or back: times it)."""
    tangent = 1j * along
    return mesh.cosine * tangent + np.sign(flank) * mesh.side * mesh.sine * along


@njit(cache=True)
def contact_state(mesh: ContactMesh, t: float, q: np.ndarray, q_t: np.ndarray) -> ContactState:
    """State of a mesh's contact at t [s] by its bodies' poses q and rates q_t, each (3 bodies,)."""
    planet, carrier = motion(q, q_t, PLANET), motion(q, q_t, CARRIER)
    body, previous = motion(q, q_t, WHEEL), motion(q, q_t, len(q) // 3 + PREVIOUS)
    wheel = point_motion(body, mesh.seat * np.exp(1j * body.angle))
    line = planet.position - wheel.position
    along = line / abs(line)
    turn = line_rotation(line, mesh.direction, carrier.angle)
    rolled = mesh.wheel_pitch * (wheel.angle - turn)
    x = mesh.cosine * (rolled + mesh.side * mesh.planet_pitch * (planet.angle - turn))
    pitch_point = wheel.position + mesh.wheel_pitch * along
    planet_lever, wheel_lever = pitch_point - planet.position, pitch_point - body.position
    slip = point_motion(body, wheel_lever).velocity - point_motion(planet, planet_lever).velocity
    x_dot = (np.conj(line_of_action(mesh, along, x)) * slip).real
    return ContactState(
        x, x_dot, along, planet_lever, wheel_lever, mesh_phase(mesh, t, carrier, previous)
    )


@njit(cache=True)
def mesh_phase(mesh: ContactMesh, t: float, carrier: PointMotion, previous: PointMotion) -> float:
    """The mesh phase [rad] (Eqs. 8, 14), from the angle or the rate of link against link."""
    angle = carrier.angle - previous.angle
    if mesh.clock_phase:
        angle = (carrier.spin - previous.spin) * t
    return mesh.teeth * angle + mesh.offset


@njit(cache=True)
def mesh_forces(mesh: ContactMesh, t: float, q: np.ndarray, q_t: np.ndarray) -> np.ndarray:
    """Forces [N] and torque [N m] about its origin on every body of a mesh, shape (3 bodies,)."""
    contact = contact_state(mesh, t, q, q_t)
    force = elastic_force(mesh, contact) + damping_force(mesh, contact)
    push = force * line_of_action(mesh, contact.along, force)
    forces = np.zeros(len(q))
    for body, lever, on in (
        (PLANET, contact.planet_lever, push),
        (WHEEL, contact.wheel_lever, -push),
    ):
        forces[3 * body] = on.real
        forces[3 * body + 1] = on.imag
        forces[3 * body + 2] = (np.conj(lever) * on).imag
    if mesh.conservative:
        torque = carrier_torque(mesh, contact)
        forces[3 * CARRIER + 2] += torque
        forces[3 * PREVIOUS + 2] -= torque
    return forces


# Entered directly, past numba's choice among signatures: saves two thirds of 13 us per call.
push_bodies = mesh_forces.compile(
    types.float64[::1](
        types.NamedTuple(
            [*[types.float64] * (len(ContactMesh._fields) - 1), types.float64[:, ::1]], ContactMesh
        ),
        types.float64,
        types.float64[::1],
        types.float64[::1],
    )
)


@njit(cache=True)
def readings(mesh: ContactMesh, t: np.ndarray, q: np.ndarray, q_t: np.ndarray) -> np.ndarray:
    """x [m], x' [m/s] and spring force [N], shape (3, times), along t, q and q_t (times, ...)."""
    read = np.empty((3, len(t)))
    for row in range(len(t)):
        contact = contact_state(mesh, t[row], q[row], q_t[row])
        read[0, row] = contact.x
        read[1, row] = contact.x_dot
        read[2, row] = elastic_force(mesh, contact)
    return read

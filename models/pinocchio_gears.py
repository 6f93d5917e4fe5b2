"""The geared arm in Pinocchio: links, suns and planets as bodies, pushed by contact forces.

The tree knows no mesh. Each tooth contact is a force at the pitch point, along the line of action,
on the planet, and its opposite on the sun or on the body that holds the ring. The tree's own joint
angles (link relative to link, planet relative to its carrier, sun relative to the previous link)
are mapped linearly to the paper's coordinates (Eqs. 2, 3, 20).
"""

from __future__ import annotations

from math import cos, pi, radians, sin, sqrt
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from models.arm import Arm, Joint
from models.drive import drive_data, joint_torque
from models.interface import STATE_ABILITIES, Model, gear_coordinates
from models.scenario import Scenario
from models.switches import Switches

# Over 1 + the largest acceleration [rad/s^2]. The planets of a stage get equal forces in frames
# turned against each other, so they differ by rounding: by 1e-13 of their acceleration for the
# paper's arm, and by 1e-8 rad/s^2 where contact forces of 1e6 N balance.
PLANET_TOLERANCE = 1e-6


class Stage(NamedTuple):
    """Bodies of one joint in the tree; 0 is the base. Body b turns by tree coordinate b - 1."""

    previous: int
    link: int
    planets: tuple[int, ...]
    sun: int


class Meshes(NamedTuple):
    """All meshes of the arm, as columns of shape (meshes,), each of a planet and a central gear.

    ``side`` is +1 where the central gear is the sun (external mesh), -1 where it is the ring.
    ``central`` is the body that carries the central gear's teeth. Radii [m] are base radii.
    """

    side: np.ndarray
    central: np.ndarray
    planet: np.ndarray
    link: np.ndarray
    central_radius: np.ndarray
    planet_radius: np.ndarray
    pitch: np.ndarray  # pitch point over centre distance, from the central gear
    cosine: np.ndarray  # of the pressure angle
    sine: np.ndarray
    rate: np.ndarray  # mesh phase over joint angle
    phase: np.ndarray
    stiffness: np.ndarray
    amplitude: np.ndarray
    error: np.ndarray
    backlash: np.ndarray
    sharpness: np.ndarray
    damping: np.ndarray


class PinocchioGears(Model):
    """2K-H joints with every gear a body; coordinates x_sp, x_pr [m] and theta [rad] per joint.

    ``bodies`` are the bodies' names, the base first, then as the tree counts them. In every body's
    frame, z is its axis; at zero angles x points along the links.
    """

    name = "pinocchio:gears"
    abilities = frozenset(STATE_ABILITIES)

    def __init__(
        self, arm: Arm, scenario: Scenario, chosen_switches: Switches | None = None
    ) -> None:
        super().__init__(arm, scenario, chosen_switches)
        self.coordinates = gear_coordinates(len(arm.joints))
        self._drive = drive_data(scenario, len(arm.joints))
        self._tree, self._stages = _build(arm)
        self.bodies = tuple(self._tree.names)
        self._data = self._tree.createData()
        if not self._tree.check(self._data):
            raise RuntimeError(f"{self.name}: joints of the tree are not in depth-first order")
        self._meshes = _meshes(arm, self._stages, self.switches)
        self._to_tree = _to_tree(arm, self._stages)
        self._links = [stage.link - 1 for stage in self._stages]
        self._suns = [stage.sun - 1 for stage in self._stages]
        self._ratios = np.array([1 + j.ring_teeth / j.sun_teeth for j in arm.joints])

    def mass_matrix(self, q: np.ndarray) -> np.ndarray:
        """M(q), shape (n, n): the tree's, seen along the paper's coordinates."""
        upper = np.triu(pin.crba(self._tree, self._data, self._to_tree @ q))
        return self._to_tree.T @ (upper + np.triu(upper, 1).T) @ self._to_tree

    def bias(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Coriolis and centrifugal force, shape (n,)."""
        angles, rates = self._to_tree @ q, self._to_tree @ v
        return self._to_tree.T @ pin.nle(self._tree, self._data, angles, rates)

    def generalized_force(self, t: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Drive and contact forces at time t [s], shape (n,); on x [N], on theta [N m]."""
        angles, rates = self._to_tree @ q, self._to_tree @ v
        contacts = self._local_forces(self.contact_wrenches(t, q, v))
        still = np.zeros(self._tree.nv)
        # At rest and without gravity, what the joints must hold is what the contacts exert.
        held = pin.rnea(self._tree, self._data, angles, still, still, contacts)
        return self._to_tree.T @ (self._motor_torques(t, angles, rates) - held)

    def acceleration(self, t: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """q'' at time t [s], shape (n,), by the articulated body algorithm on the whole tree.

        Raises ArithmeticError if the planets of a stage do not move alike.
        """
        angles, rates = self._to_tree @ q, self._to_tree @ v
        contacts = self._local_forces(self.contact_wrenches(t, q, v))
        torques = self._motor_torques(t, angles, rates)
        return self.from_tree(pin.aba(self._tree, self._data, angles, rates, torques, contacts))

    def to_tree(self, q: np.ndarray) -> np.ndarray:
        """Joint angles of the tree [rad], or their derivatives, from the paper's coordinates."""
        return self._to_tree @ q

    def from_tree(self, angles: np.ndarray) -> np.ndarray:
        """The paper's coordinates, or their derivatives, from the tree's joint angles.

        Raises ArithmeticError if the planets of a stage differ by more than rounding.
        """
        allowed = PLANET_TOLERANCE * (1 + np.abs(angles).max())
        coordinates = []
        for joint, stage in zip(self.arm.joints, self._stages, strict=True):
            planets = angles[np.array(stage.planets) - 1]
            if np.ptp(planets) > allowed:
                raise ArithmeticError(f"{self.name}: planets of one stage move differently")
            theta = angles[stage.link - 1]
            sun, planet = angles[stage.sun - 1] - theta, planets.mean()
            r_s, r_p, r_r = _base_radii(joint)
            # Approach of the teeth, as the carrier sees it: sun on planet, ring on planet.
            coordinates += [r_s * sun + r_p * planet, -r_r * theta - r_p * planet, theta]
        return np.array(coordinates)

    def contact_wrenches(self, t: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Sum of the contact forces on each of ``bodies``, damping included, shape (bodies, 3).

        Columns: force along the base's x and y [N], moment about the body's own joint [N m].
        """
        angles, rates = self._to_tree @ q, self._to_tree @ v
        force = self._mesh_forces(t, angles, rates)
        origins = self.body_positions(q)
        mesh = self._meshes
        centre = origins[mesh.link]
        line = origins[mesh.planet] - centre
        contact = centre + mesh.pitch[:, None] * line
        push = force[:, None] * _line_of_action(mesh, line, np.sign(force))
        wrenches = np.zeros((self._tree.njoints, 3))
        for body, sign in ((mesh.planet, 1.0), (mesh.central, -1.0)):
            arm = contact - origins[body]
            moment = arm[:, 0] * push[:, 1] - arm[:, 1] * push[:, 0]
            np.add.at(wrenches, body, sign * np.column_stack((push, moment)))
        return wrenches

    def body_positions(self, q: np.ndarray) -> np.ndarray:
        """x and y [m] of each body's own joint in the base's frame, shape (bodies, 2)."""
        pin.forwardKinematics(self._tree, self._data, self._to_tree @ q)
        return np.array([pose.translation[:2] for pose in self._data.oMi])

    def _mesh_forces(self, t: float, angles: np.ndarray, rates: np.ndarray) -> np.ndarray:
        """Force [N] of every mesh, elastic and damping, positive if the central gear pushes.

        It is k f_k(x - e) + d x', with k = k_m + k_a sin(phi) and e = E sin(phi).
        """
        mesh = self._meshes
        wave = np.sin(self._mesh_phases(t, angles, rates))
        gap = _approach(mesh, angles) - mesh.error * wave
        damping = mesh.damping
        if self.switches.damping == "contact":
            damping = np.where(np.abs(gap) > mesh.backlash, damping, 0.0)
        law = _exact_dead_zone if self.switches.dead_zone == "exact" else _tanh_dead_zone
        elastic = (mesh.stiffness + mesh.amplitude * wave) * law(mesh, gap)
        return elastic + damping * _approach(mesh, rates)

    def _mesh_phases(self, t: float, angles: np.ndarray, rates: np.ndarray) -> np.ndarray:
        """phi [rad] of every mesh: meshing rate times joint angle, or times joint rate and time."""
        mesh = self._meshes
        turned = angles if self.switches.phase == "angle" else rates * t
        return mesh.rate * turned[mesh.link - 1] + mesh.phase

    def _motor_torques(self, t: float, angles: np.ndarray, rates: np.ndarray) -> np.ndarray:
        """Joint torques of the tree [N m]: the motor turns the sun against the previous link."""
        law, gains, table_time, table_torque = self._drive
        theta, theta_dot = angles[self._links], rates[self._links]
        torques = np.zeros(self._tree.nv)
        for i, sun in enumerate(self._suns):
            state = theta[i], theta_dot[i]
            output = joint_torque(law, gains[i], table_time, table_torque[i], t, *state)
            torques[sun] = output / self._ratios[i]
        return torques

    def _local_forces(self, wrenches: np.ndarray) -> pin.StdVec_Force:
        """Spatial forces in each body's own frame, whose origin is its joint."""
        forces = pin.StdVec_Force()
        for pose, (x, y, moment) in zip(self._data.oMi, wrenches, strict=True):
            linear = pose.rotation.T @ np.array([x, y, 0.0])
            forces.append(pin.Force(linear, np.array([0.0, 0.0, moment])))
        return forces


def _approach(mesh: Meshes, angles: np.ndarray) -> np.ndarray:
    """How far the teeth of every mesh have come together [m], from angles of the tree (or rates).

    Seen from the carrier, both gears unwind their base circles along the line of action: against
    each other in an external mesh, after each other in an internal one.
    """
    central = np.where(mesh.side > 0, angles[mesh.central - 1], 0.0) - angles[mesh.link - 1]
    return mesh.central_radius * central + mesh.side * mesh.planet_radius * angles[mesh.planet - 1]


def _line_of_action(mesh: Meshes, line: np.ndarray, sign: np.ndarray) -> np.ndarray:
    """Unit vectors along which a positive force acts on the planet, shape (meshes, 2).

    line (meshes, 2) runs from the central gear's axis to the planet's. The pressure angle tilts
    the push on either flank so that it drives the teeth out of mesh: the planet away from the sun,
    but away from the ring towards the axis.
    """
    outward = line / np.hypot(line[:, 0], line[:, 1])[:, None]
    tangent = np.column_stack((-outward[:, 1], outward[:, 0]))
    return mesh.cosine[:, None] * tangent + (sign * mesh.side * mesh.sine)[:, None] * outward


def _exact_dead_zone(mesh: Meshes, x: np.ndarray) -> np.ndarray:
    """Eq. 5: what of x [m] reaches beyond the play."""
    return x - np.clip(x, -mesh.backlash, mesh.backlash)


def _tanh_dead_zone(mesh: Meshes, x: np.ndarray) -> np.ndarray:
    """Eq. 6, as printed."""
    b = mesh.backlash
    left, right = np.tanh(mesh.sharpness * (x - b)), np.tanh(mesh.sharpness * (x + b))
    return x + x / 2 * (left - right) - b / 2 * (left + right)


def _build(arm: Arm) -> tuple[pin.Model, list[Stage]]:
    """The tree without gravity: all links, then each joint's gears from the tip inwards.

    In this order every subtree is complete before the next begins (depth-first).
    """
    tree = pin.Model()
    tree.gravity.linear = np.zeros(3)
    places = [0.0, *(link.length_m for link in arm.links)]
    for body, place in enumerate(places[:-1]):
        _add_body(tree, body, (place, 0.0), f"link_{body + 1}")
    for body, link in enumerate(arm.links, 1):
        mass = link.density_kg_per_m3 * link.cross_section_m2 * link.length_m
        _load(tree, body, link.com_m, mass, mass * link.length_m**2 / 12)
    _load(tree, len(arm.links), places[-1], arm.payload_mass_kg, 0.0)
    stages = [
        _add_gears(tree, arm.joints[number], number, places[number])
        for number in reversed(range(len(arm.joints)))
    ]
    return tree, stages[::-1]


def _add_gears(tree: pin.Model, joint: Joint, previous: int, place: float) -> Stage:
    """Carrier, planets, ring and sun of a joint at ``place`` [m] along the previous body."""
    link = previous + 1
    r_s, r_p, _ = _base_radii(joint)
    _load(
        tree, link, 0.0, joint.carrier_mass_kg, joint.carrier_equivalent_mass_kg * (r_s + r_p) ** 2
    )
    _load(tree, previous, place, joint.ring_mass_kg, joint.ring_inertia_kg_m2)
    radius = joint.module_m * (joint.sun_teeth + joint.planet_teeth) / 2
    planets: list[int] = []
    for turn in 2 * pi * np.arange(joint.planet_count) / joint.planet_count:
        centre = radius * cos(turn), radius * sin(turn)
        planets.append(_add_body(tree, link, centre, f"planet_{link}_{len(planets) + 1}"))
        _load(
            tree, planets[-1], 0.0, joint.planet_mass_kg, joint.planet_equivalent_mass_kg * r_p**2
        )
    sun = _add_body(tree, previous, (place, 0.0), f"sun_{link}")
    _load(tree, sun, 0.0, joint.sun_mass_kg, joint.sun_equivalent_mass_kg * r_s**2)
    return Stage(previous, link, tuple(planets), sun)


def _add_body(tree: pin.Model, parent: int, place: tuple[float, float], name: str) -> int:
    """A body turning about z at (x, y) [m] of its parent; returns its number."""
    placement = pin.SE3(np.eye(3), np.array([*place, 0.0]))
    return tree.addJoint(parent, pin.JointModelRZ(), placement, name)


def _load(tree: pin.Model, body: int, x: float, mass: float, inertia: float) -> None:
    """Add mass [kg] at x [m] of a body, with inertia [kg m^2] about z there.

    In the plane only the inertia about z matters.
    """
    added = pin.Inertia(mass, np.array([x, 0.0, 0.0]), np.diag([0.0, 0.0, inertia]))
    tree.appendBodyToJoint(body, added, pin.SE3.Identity())


def _to_tree(arm: Arm, stages: list[Stage]) -> np.ndarray:
    """Matrix from the paper's coordinates to the tree's angles, shape (angles, 3 joints).

    The sun turns by theta_s; the planet, by -theta_p in the previous body, turns by -theta_p -
    theta in its carrier. Eqs. 2 and 3 give r_p theta_p = x_pr + r_cp theta and r_s theta_s =
    x_sp + x_pr + 2 r_cp theta, with r_cp = r_s + r_p; ratios of radii are those of tooth numbers.
    """
    matrix = np.zeros((sum(2 + len(stage.planets) for stage in stages), 3 * len(stages)))
    for i, (joint, stage) in enumerate(zip(arm.joints, stages, strict=True)):
        r_s, r_p, _ = _base_radii(joint)
        columns = slice(3 * i, 3 * i + 3)
        matrix[stage.link - 1, columns] = 0, 0, 1
        matrix[stage.sun - 1, columns] = 1 / r_s, 1 / r_s, 1 + joint.ring_teeth / joint.sun_teeth
        for planet in stage.planets:
            matrix[planet - 1, columns] = 0, -1 / r_p, -joint.ring_teeth / joint.planet_teeth
    return matrix


def _meshes(arm: Arm, stages: list[Stage], chosen: Switches) -> Meshes:
    rows = [
        _mesh(joint, stage, planet, side, chosen)
        for joint, stage in zip(arm.joints, stages, strict=True)
        for planet in stage.planets
        for side in (+1, -1)
    ]
    return Meshes(**{field: np.array([row[field] for row in rows]) for field in Meshes._fields})


def _mesh(joint: Joint, stage: Stage, planet: int, side: int, chosen: Switches) -> dict[str, float]:
    """One mesh of a planet, with the sun (side +1) or the ring (side -1), by the field's name."""
    external = side > 0
    r_s, r_p, r_r = _base_radii(joint)
    teeth = joint.sun_teeth if external else joint.ring_teeth
    alpha = radians(joint.pressure_angle_deg)
    return {
        "side": side,
        "central": stage.sun if external else stage.previous,
        "planet": planet,
        "link": stage.link,
        "central_radius": r_s if external else r_r,
        "planet_radius": r_p,
        "pitch": teeth / (joint.sun_teeth + joint.planet_teeth),
        "cosine": cos(alpha),
        "sine": sin(alpha),
        "rate": _sun_mesh_rate(joint) if external else _ring_mesh_rate(joint, chosen),
        "phase": 0.0 if external else joint.ring_mesh_phase_rad,
        "stiffness": joint.mesh_stiffness_N_per_m,
        "amplitude": joint.mesh_stiffness_amplitude_N_per_m,
        "error": joint.tooth_error_m,
        "backlash": joint.backlash_m,
        "sharpness": joint.tanh_sharpness_per_m,
        "damping": _stage_damping(joint, external) / joint.planet_count,
    }


def _sun_mesh_rate(joint: Joint) -> int:
    """Teeth of the sun that pass a planet per turn of the link: z_s (z_r / z_s + 1 - 1)."""
    return joint.ring_teeth


def _ring_mesh_rate(joint: Joint, chosen: Switches) -> int:
    """Teeth of the ring that pass a planet per turn of the link; or what Eq. 13 has in its place.

    Eq. 13: z_p (r_cp / r_p - 1), and r_cp / r_p = (z_s + z_p) / z_p.
    """
    return joint.ring_teeth if chosen.ring_rate == "corrected" else joint.sun_teeth


def _stage_damping(joint: Joint, external: bool) -> float:
    """Damping [N s/m] of all sun-planet or all planet-ring meshes of a joint together.

    From a damping ratio: 2 zeta sqrt(k m) of all meshes' stiffness over the sun's, or all the
    planets', equivalent mass.
    """
    if joint.damping_ratio is None:
        given = (joint.planet_ring_damping_N_s_per_m, joint.sun_planet_damping_N_s_per_m)
        return given[external] or 0.0
    planets = joint.planet_count
    mass = joint.sun_equivalent_mass_kg if external else planets * joint.planet_equivalent_mass_kg
    return 2 * joint.damping_ratio * sqrt(planets * joint.mesh_stiffness_N_per_m * mass)


def _base_radii(joint: Joint) -> tuple[float, float, float]:
    """Base radii [m] of sun, planet and ring."""
    half = joint.module_m / 2 * cos(radians(joint.pressure_angle_deg))
    return half * joint.sun_teeth, half * joint.planet_teeth, half * joint.ring_teeth

"""The geared arm in Pinocchio: links, suns and planets as bodies, pushed by contact forces.

The tree knows no mesh. Each tooth contact is a force at the pitch point, along the line of action,
on the planet, and its opposite on the sun or on the body that holds the ring.
"""

from __future__ import annotations

from math import cos, radians, sin, sqrt
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from models.arm import Arm, Mesh, Planetary
from models.drive import drive_data, joint_torque
from models.interface import STATE_ABILITIES, Model
from models.layout import lumped_layout
from models.pinocchio_stiffness import MeshStiffness, curve_of, mesh_stiffness
from models.pinocchio_tree import (
    Stage,
    base_radii,
    build_tree,
    equivalent_masses,
    map_to_tree,
    sun_turns,
)
from models.scenario import Scenario
from models.switches import Switches

# Over 1 + the largest acceleration [rad/s^2]. The planets of a stage get equal forces in frames
# turned against each other, so they differ by rounding: by 1e-13 of their acceleration for the
# paper's arm, and by 1e-8 rad/s^2 where contact forces of 1e6 N balance.
PLANET_TOLERANCE = 1e-6
BODIES = ("central", "planet", "link")  # those fields of Meshes that are no numbers but bodies


class Contact(NamedTuple):
    """Where a planet of a joint touches its sun (side +1) or its ring (side -1)."""

    joint: Planetary
    stage: Stage
    planet: int
    side: int
    mesh: Mesh

    @property
    def external(self) -> bool:
        """Whether it is the sun's."""
        return self.side > 0


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
    error: np.ndarray
    backlash: np.ndarray
    sharpness: np.ndarray
    damping: np.ndarray


class PinocchioGears(Model):
    """2K-H joints with every gear a body; coordinates x_sp, x_pr [m] and theta [rad] of each.

    Joints without gears have theta alone, their motors are parts of the links beside them.

    ``bodies`` are the bodies' names, the base first, then as the tree counts them. In every body's
    frame, z is its axis; at zero angles x points along the links.
    """

    name = "pinocchio:gears"
    abilities = frozenset(STATE_ABILITIES)

    def __init__(
        self, arm: Arm, scenario: Scenario, chosen_switches: Switches | None = None
    ) -> None:
        super().__init__(arm, scenario, chosen_switches)
        self.layout = lumped_layout(arm)
        self._drive = drive_data(scenario, len(arm.joints))
        self._weightless, self._stages = build_tree(arm)
        self._tree = self._weightless.copy()
        self._tree.gravity.linear = np.array([*arm.gravity_m_per_s2, 0.0])
        self.bodies = tuple(self._tree.names)
        self._data = self._tree.createData()
        if not self._tree.check(self._data):
            raise RuntimeError(f"{self.name}: joints of the tree are not in depth-first order")
        contacts = _contacts(arm, self._stages)
        self._meshes = _meshes(contacts, self.switches)
        self._stiffness = _stiffness(contacts)
        self._to_tree = map_to_tree(arm, self._stages, self.layout)
        self._links = [stage.link - 1 for stage in self._stages]
        self._driven = [stage.driven - 1 for stage in self._stages]
        self._ratios = [sun_turns(j) if isinstance(j, Planetary) else 1.0 for j in arm.joints]
        self._friction = np.array([joint.friction_N_m_s_per_rad for joint in arm.joints])

    def mass_matrix(self, q: np.ndarray) -> np.ndarray:
        """M(q), shape (n, n): the tree's, seen along the paper's coordinates."""
        upper = np.triu(pin.crba(self._tree, self._data, self._to_tree @ q))
        return self._to_tree.T @ (upper + np.triu(upper, 1).T) @ self._to_tree

    def bias(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Coriolis and centrifugal force, shape (n,)."""
        angles, rates = self._to_tree @ q, self._to_tree @ v
        return self._to_tree.T @ pin.nle(self._weightless, self._data, angles, rates)

    def generalized_force(self, t: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Drive, contacts, friction and gravity at time t [s], (n,); on x [N], on theta [N m]."""
        angles, rates = self._to_tree @ q, self._to_tree @ v
        contacts = self._local_forces(self.contact_wrenches(t, q, v))
        still = np.zeros(self._tree.nv)
        # At rest, what the joints must hold is what contacts and weights exert.
        held = pin.rnea(self._tree, self._data, angles, still, still, contacts)
        return self._to_tree.T @ (self._joint_torques(t, angles, rates) - held)

    def acceleration(self, t: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """q'' at time t [s], shape (n,), by the articulated body algorithm on the whole tree.

        Raises ArithmeticError if the planets of a stage do not move alike.
        """
        angles, rates = self._to_tree @ q, self._to_tree @ v
        contacts = self._local_forces(self.contact_wrenches(t, q, v))
        torques = self._joint_torques(t, angles, rates)
        return self.from_tree(pin.aba(self._tree, self._data, angles, rates, torques, contacts))

    def to_tree(self, q: np.ndarray) -> np.ndarray:
        """Joint angles of the tree [rad], or their derivatives, from the paper's coordinates."""
        return self._to_tree @ q

    def from_tree(self, angles: np.ndarray) -> np.ndarray:
        """The paper's coordinates, or their derivatives, from the tree's joint angles.

        Raises ArithmeticError if the planets of a stage differ by more than rounding.
        """
        allowed = PLANET_TOLERANCE * (1 + np.abs(angles).max())
        coordinates: list[float] = []
        for joint, stage in zip(self.arm.joints, self._stages, strict=True):
            theta = angles[stage.link - 1]
            if not isinstance(joint, Planetary):
                coordinates.append(theta)
                continue
            planets = angles[np.array(stage.planets) - 1]
            if np.ptp(planets) > allowed:
                raise ArithmeticError(f"{self.name}: planets of one stage move differently")
            sun, planet = angles[stage.driven - 1] - theta, planets.mean()
            r_s, r_p, r_r = base_radii(joint)
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

        It is k f_k(x - e) + d x', with k of the phase phi and e = E sin(phi).
        """
        mesh = self._meshes
        phase = self._mesh_phases(t, angles, rates)
        gap = _approach(mesh, angles) - mesh.error * np.sin(phase)
        damping = mesh.damping
        if self.switches.damping == "contact":
            damping = np.where(np.abs(gap) > mesh.backlash, damping, 0.0)
        law = _exact_dead_zone if self.switches.dead_zone == "exact" else _tanh_dead_zone
        elastic = self._stiffness.at(phase) * law(mesh, gap)
        return elastic + damping * _approach(mesh, rates)

    def _mesh_phases(self, t: float, angles: np.ndarray, rates: np.ndarray) -> np.ndarray:
        """phi [rad] of every mesh: meshing rate times joint angle, or times joint rate and time."""
        mesh = self._meshes
        turned = angles if self.switches.phase == "angle" else rates * t
        return mesh.rate * turned[mesh.link - 1] + mesh.phase

    def _joint_torques(self, t: float, angles: np.ndarray, rates: np.ndarray) -> np.ndarray:
        """Joint torques of the tree [N m]: friction of every link on the previous one, and drive.

        The motor turns the sun, or the link if there are no gears, against the previous link.
        """
        law, gains, table_time, table_torque = self._drive
        theta, theta_dot = angles[self._links], rates[self._links]
        torques = np.zeros(self._tree.nv)
        torques[self._links] = -self._friction * theta_dot
        for i, driven in enumerate(self._driven):
            state = theta[i], theta_dot[i]
            output = joint_torque(law, gains[i], table_time, table_torque[i], t, *state)
            torques[driven] += output / self._ratios[i]
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


def _contacts(arm: Arm, stages: list[Stage]) -> list[Contact]:
    """All meshes of the arm, joint by joint and planet by planet."""
    return [
        Contact(joint, stage, planet, side, mesh)
        for joint, stage in zip(arm.joints, stages, strict=True)
        if isinstance(joint, Planetary)
        for planet in stage.planets
        for side, mesh in ((+1, joint.sun_mesh), (-1, joint.ring_mesh))
    ]


def _meshes(contacts: list[Contact], chosen: Switches) -> Meshes:
    rows = [_mesh(contact, chosen) for contact in contacts]
    return Meshes(
        **{
            field: np.array([row[field] for row in rows], dtype=int if field in BODIES else float)
            for field in Meshes._fields
        }
    )


def _mesh(contact: Contact, chosen: Switches) -> dict[str, float]:
    """The numbers of one mesh by the field's name."""
    joint, stage, planet, side, mesh = contact
    external = contact.external
    r_s, r_p, r_r = base_radii(joint)
    teeth = joint.sun_teeth if external else joint.ring_teeth
    alpha = radians(joint.pressure_angle_deg)
    return {
        "side": side,
        "central": stage.driven if external else stage.previous,
        "planet": planet,
        "link": stage.link,
        "central_radius": r_s if external else r_r,
        "planet_radius": r_p,
        "pitch": teeth / (joint.sun_teeth + joint.planet_teeth),
        "cosine": cos(alpha),
        "sine": sin(alpha),
        "rate": _sun_mesh_rate(joint) if external else _ring_mesh_rate(joint, chosen),
        "phase": mesh.phase_rad,
        "error": mesh.tooth_error_m,
        "backlash": mesh.backlash_m,
        "sharpness": mesh.tanh_sharpness_per_m,
        "damping": _stage_damping(contact) / joint.planet_count,
    }


def _stiffness(contacts: list[Contact]) -> MeshStiffness:
    return mesh_stiffness([contact.mesh.stiffness for contact in contacts])


def _sun_mesh_rate(joint: Planetary) -> int:
    """Teeth of the sun that pass a planet per turn of the link: z_s (z_r / z_s + 1 - 1)."""
    return joint.ring_teeth


def _ring_mesh_rate(joint: Planetary, chosen: Switches) -> int:
    """Teeth of the ring that pass a planet per turn of the link; or what Eq. 13 has in its place.

    Eq. 13: z_p (r_cp / r_p - 1), and r_cp / r_p = (z_s + z_p) / z_p.
    """
    return joint.ring_teeth if chosen.ring_rate == "corrected" else joint.sun_teeth


def _stage_damping(contact: Contact) -> float:
    """Damping [N s/m] of all contacts of its kind in a joint together.

    From a damping ratio: 2 zeta sqrt(k m) of all meshes' mean stiffness over the sun's, or all the
    planets', equivalent mass.
    """
    joint, mesh = contact.joint, contact.mesh
    if mesh.damping_ratio is None:
        return mesh.damping_N_s_per_m or 0.0
    sun, planet = equivalent_masses(joint)
    planets = joint.planet_count
    mass = sun if contact.external else planets * planet
    mean = curve_of(mesh.stiffness).mean
    return 2 * mesh.damping_ratio * sqrt(planets * mean * mass)

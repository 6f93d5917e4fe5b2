"""The geared arm in Pinocchio: links, suns and planets as bodies, pushed by contact forces.

The tree knows no mesh. Each tooth contact is a force at the pitch point, along the line of action,
on the planet, and its opposite on the sun or on the body that holds the ring. Every planet has a
body and two contacts of its own; the layout alone says whether they move as one.
"""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from crosscheck.models.arm.arm import Arm, Planetary
from crosscheck.models.arm.layout import geared_layout
from crosscheck.models.experiment.drive import drive_data, joint_torque
from crosscheck.models.experiment.scenario import Scenario, Switches
from crosscheck.models.interface import STATE_ABILITIES, Model
from crosscheck.models.pinocchio import tree
from crosscheck.models.pinocchio.meshes import Engagement, Meshes, MeshForces, find_contacts

# Over 1 + the largest acceleration [rad/s^2]. Lumped planets of a stage get equal forces in frames
# turned against each other, so they differ by rounding: by 1e-13 of their acceleration for the
# paper's arm, and by 1e-8 rad/s^2 where contact forces of 1e6 N balance.
PLANET_TOLERANCE = 1e-6


class PinocchioGears(Model):
    """2K-H joints with every gear a body; displacements [m] and theta [rad] of each.

    The displacements are x_sp and x_pr of lumped planets, x_s and every planet's x_pr of free ones.
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
        self.layout = geared_layout(arm, self.switches)
        self._drive = drive_data(scenario, len(arm.joints))
        self._weightless, self._stages = tree.build_tree(arm)
        self._tree = self._weightless.copy()
        self._tree.gravity.linear = np.array([*arm.gravity_m_per_s2, 0.0])
        self.bodies = tuple(self._tree.names)
        self._data = self._tree.createData()
        if not self._tree.check(self._data):
            raise RuntimeError(f"{self.name}: joints of the tree are not in depth-first order")
        geared = zip(arm.joints, self._stages, strict=True)
        contacts = find_contacts((j, stage) for j, stage in geared if isinstance(j, Planetary))
        self._mesh_law = MeshForces(contacts, self.switches)
        self._meshes = self._mesh_law.meshes
        self.to_tree = tree.map_to_tree(arm, self._stages, self.layout)
        self._links = [stage.link - 1 for stage in self._stages]
        self._driven = [stage.driven - 1 for stage in self._stages]
        self._ratios = [tree.sun_turns(j) if isinstance(j, Planetary) else 1.0 for j in arm.joints]
        self._friction = np.array([joint.friction_N_m_s_per_rad for joint in arm.joints])

    def mass_matrix(self, q: np.ndarray) -> np.ndarray:
        """M(q), shape (n, n): the tree's, seen along the layout's coordinates."""
        return self.to_tree.T @ pin.crba(self._tree, self._data, self.to_tree @ q) @ self.to_tree

    def bias(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Coriolis and centrifugal force, shape (n,)."""
        angles, rates = self.to_tree @ q, self.to_tree @ v
        return self.to_tree.T @ pin.nle(self._weightless, self._data, angles, rates)

    def generalized_force(self, t: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Drive, contacts, friction and gravity at time t [s], (n,); on x [N], on theta [N m]."""
        angles, rates = self.to_tree @ q, self.to_tree @ v
        contacts = self._local_forces(self.contact_wrenches(t, q, v))
        still = np.zeros(self._tree.nv)
        # At rest, what the joints must hold is what contacts and weights exert.
        held = pin.rnea(self._tree, self._data, angles, still, still, contacts)
        return self.to_tree.T @ (self._joint_torques(t, angles, rates) - held)

    def acceleration(self, t: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """q'' at time t [s], shape (n,), by the articulated body algorithm on the whole tree.

        Raises ArithmeticError if lumped planets of a stage do not move alike.
        """
        angles, rates = self.to_tree @ q, self.to_tree @ v
        contacts = self._local_forces(self.contact_wrenches(t, q, v))
        torques = self._joint_torques(t, angles, rates)
        return self.from_tree(pin.aba(self._tree, self._data, angles, rates, torques, contacts))

    def from_tree(self, angles: np.ndarray) -> np.ndarray:
        """The layout's coordinates, or their derivatives, from the tree's joint angles.

        Raises ArithmeticError if lumped planets of a stage differ by more than rounding.
        """
        coordinates = np.empty(len(self.layout))
        for number, (joint, stage) in enumerate(zip(self.arm.joints, self._stages, strict=True)):
            is_displacement = [
                c.joint == number + 1 and not c.is_angle for c in self.layout.coordinates
            ]
            if isinstance(joint, Planetary):
                coordinates[is_displacement] = self._displacements(joint, stage, angles)
            coordinates[self.layout.at("theta", number)] = angles[stage.link - 1]
        return coordinates

    def _displacements(
        self, joint: Planetary, stage: tree.TreeStage, angles: np.ndarray
    ) -> list[float]:
        """Mesh displacements [m] of a geared joint by the tree's angles, in the layout's order.

        Each is the approach of the teeth, as the carrier sees it: sun on planet, ring on planet. Of
        both together, the sun's advance, the planet's own turn drops out.
        """
        theta, planets = angles[stage.link - 1], angles[np.array(stage.planets) - 1]
        sun = angles[stage.driven - 1] - theta
        r_s, r_p, r_r = tree.base_radii(joint)
        if self.layout.free:
            return [r_s * sun - r_r * theta, *(-r_r * theta - r_p * planets)]
        if np.ptp(planets) > PLANET_TOLERANCE * (1 + np.abs(angles).max()):
            raise ArithmeticError(f"{self.name}: planets of one stage move differently")
        planet = planets.mean()
        return [r_s * sun + r_p * planet, -r_r * theta - r_p * planet]

    def contact_wrenches(self, t: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Sum of the contact forces on each of ``bodies``, damping included, shape (bodies, 3).

        Columns: force along the base's x and y [N], moment about the body's own joint [N m].
        """
        angles, rates = self.to_tree @ q, self.to_tree @ v
        approaching = _approach(self._meshes, rates)
        force = self._mesh_law.forces(self._engagement(t, angles, rates), approaching)
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
        pin.forwardKinematics(self._tree, self._data, self.to_tree @ q)
        return np.array([pose.translation[:2] for pose in self._data.oMi])

    def _engagement(self, t: float, angles: np.ndarray, rates: np.ndarray) -> Engagement:
        phase = self._mesh_phases(t, angles, rates)
        return self._mesh_law.engage(phase, _approach(self._meshes, angles))

    def _mesh_phases(self, t: float, angles: np.ndarray, rates: np.ndarray) -> np.ndarray:
        """phi [rad] of every mesh: meshing rate times joint angle, or times joint rate and time."""
        mesh = self._meshes
        turned = angles if self.switches.phase == "angle" else rates * t
        return mesh.rate * turned[mesh.link - 1] + mesh.phase

    def _joint_torques(self, t: float, angles: np.ndarray, rates: np.ndarray) -> np.ndarray:
        """Joint torques of the tree [N m]: friction of every link on the previous one, and drive.

        The motor turns the sun, or the link if there are no gears, against the previous link.
        Springs that do work on the mesh phase act between the same two bodies as friction.
        """
        law, gains, table_time, table_torque = self._drive
        theta, theta_dot = angles[self._links], rates[self._links]
        torques = np.zeros(self._tree.nv)
        torques[self._links] = -self._friction * theta_dot
        if self.switches.mesh_work == "conservative":
            teeth = self._engagement(t, angles, rates)
            np.add.at(torques, self._meshes.link - 1, self._mesh_law.phase_torques(teeth))
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

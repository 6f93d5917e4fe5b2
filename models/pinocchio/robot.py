"""A robot in Pinocchio, which reads the URDF itself; rotors are bodies of its tree.

The tree's joints that are not free (those that mimic, and rotors) follow from the coordinates by a
constant matrix G: M = G' M_tree G, and so for the torques. A rotor's mesh turns it against its
stator, and the two bodies that its joint connects. Every planet of a stage is a body on the
carrier, which sun and ring push at the pitch points. Friction is that of the tree's joints, of
which no algorithm of Pinocchio's takes notice.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from crosscheck.models.experiment.scenario import Switches
from crosscheck.models.pinocchio.meshes import Engagement, MeshForces, find_contacts
from crosscheck.models.pinocchio.tree import (
    TreeStage,
    add_spinning_body,
    add_wheels,
    base_radii,
    planet_turns,
    reflected_inertia,
    sun_turns,
)
from crosscheck.models.robot.interface import RobotModel
from crosscheck.models.robot.robot import (
    MESH_LAWS,
    WITH_ROTORS,
    JointStage,
    Level,
    Robot,
    Rotor,
    RotorMesh,
)


class MeshConnection(NamedTuple):
    """Where a mesh acts: column of its x; places in the tree of the rotor and of its joint."""

    column: int
    rotor_place: int
    joint_place: int
    ratio: float
    mesh: RotorMesh


class PinocchioRobot(RobotModel):
    """Pinocchio's algorithms on the tree of its own URDF parser.

    ``bodies`` are the names of the tree's bodies, each that of its joint, the base first.
    laws: of the planets' meshes.
    """

    name = "pinocchio"

    def __init__(self, robot: Robot, level: Level, laws: Switches = MESH_LAWS) -> None:
        super().__init__(robot, level)
        self._laws = laws
        self._tree = pin.buildModelFromXML(robot.urdf)
        missing = [j.name for j in robot.joints if not self._tree.existJointName(j.name)]
        if missing or self._tree.njoints != len(robot.joints) + 1:
            raise ValueError(
                f"its parser read other joints; missing: {', '.join(missing) or 'none'}"
            )
        moving_joints = [self._tree.getJointId(joint.name) for joint in robot.joints]
        bodies = robot.rotors if level in WITH_ROTORS else ()
        rotors = [self._add_rotor(rotor, number) for number, rotor in enumerate(bodies)]
        places = [self._tree.joints[joint].idx_v for joint in moving_joints]
        free, meshes = robot.coordinates, robot.meshes if level == "geared" else ()
        geared = robot.stages if level in WITH_ROTORS else ()
        stages = [self._add_stage(stage, moving_joints[stage.joint]) for stage in geared]
        self.bodies = tuple(self._tree.names)
        springs = robot.mesh_coordinates if level == "geared" else 0
        self._offset = np.zeros(self._tree.nv)
        self._given = np.zeros((self._tree.nv, len(free) + springs))  # G
        motors = np.zeros((len(free), self._tree.nv))  # efforts in the tree, per torque
        self._meshes: list[MeshConnection] = []
        self._given[places, : len(free)], self._offset[places] = robot.joint_map
        motors[range(len(free)), [places[joint] for joint in free]] = 1.0
        for rotor_joint, rotor in zip(rotors, bodies, strict=True):
            place, column = self._tree.joints[rotor_joint].idx_v, len(free) + len(self._meshes)
            self._given[place] = rotor.ratio * self._given[places[rotor.joint]]
            if meshes and rotor.mesh:
                self._given[place, column] = 1 / rotor.mesh.pinion_base_radius_m
                moving = places[rotor.joint]
                self._meshes.append(MeshConnection(column, place, moving, rotor.ratio, rotor.mesh))
                if rotor.joint in free:
                    motors[free.index(rotor.joint)] = 0.0
                    motors[free.index(rotor.joint), place] = 1 / rotor.ratio
        rows: list[np.ndarray] = []  # x of each contact by the coordinates
        for stage, wheels, columns in zip(geared, stages, robot.stage_columns, strict=False):
            gears, link = stage.gears, self._given[places[stage.joint]]
            r_s, r_p, _ = base_radii(gears)
            sun = self._tree.joints[wheels.driven].idx_v
            for number, planet in enumerate(wheels.planets):
                x_sp, x_pr = np.zeros((2, len(free) + springs))
                if level == "geared":
                    x_sp[columns] = stage.displacement("x_sp", number)
                    x_pr[columns] = stage.displacement("x_pr", number)
                    rows += [x_sp, x_pr]
                turns = planet_turns(gears) * link - x_pr / r_p
                self._given[self._tree.joints[planet].idx_v] = turns
            self._given[sun] = sun_turns(gears) * link + (x_sp + x_pr) / r_s
            if level != "geared":
                continue
            if stage.joint in free:
                motors[free.index(stage.joint)] = 0.0
                motors[free.index(stage.joint), sun] = 1 / sun_turns(gears)
        self.drive = motors @ self._given
        self._displacements = np.reshape(rows, (len(rows), len(free) + springs))
        elastic = zip(geared, stages, strict=True) if level == "geared" else ()
        contacts = find_contacts((stage.gears, wheels) for stage, wheels in elastic)
        self._mesh_law = MeshForces(contacts, laws)
        links = self._mesh_law.meshes.link.tolist()
        self._axes = np.reshape([self._axis(link) for link in links], (len(links), 3))
        self._link_places = [self._tree.joints[link].idx_v for link in links]
        armature = np.zeros(self._tree.nv)
        if level != "links":
            armature[places] = [joint.armature for joint in robot.joints]
        if level == "armature":
            for rotor in robot.rotors:
                armature[places[rotor.joint]] += rotor.inertia * rotor.ratio**2
            for stage in robot.stages:
                armature[places[stage.joint]] += reflected_inertia(stage.gears)
        self._tree.armature = armature
        damping = np.zeros(self._tree.nv)
        damping[places] = [joint.friction for joint in robot.joints]
        self._tree.damping = damping
        self._tree.gravity.linear = robot.gravity
        self._weightless = self._tree.copy()
        self._weightless.gravity.linear = np.zeros(3)
        self._data = self._tree.createData()
        self._home = pin.neutral(self._tree)
        self._is_depth_first = self._tree.check(self._data)

    def _add_rotor(self, rotor: Rotor, number: int) -> int:
        """Add a rotor's body to the tree; returns its joint."""
        frame = self._tree.frames[self._tree.getFrameId(rotor.stator, pin.BODY)]
        axis = frame.placement.rotation @ rotor.axis
        name = f"rotor of {rotor.joint} ({number})"
        stator, placement = frame.parentJoint, pin.SE3.Identity()
        return add_spinning_body(self._tree, stator, placement, axis, rotor.inertia, name)

    def _add_stage(self, stage: JointStage, link: int) -> TreeStage:
        """Add sun and planets of a joint of the tree."""
        axis = self._axis(link)
        across = np.argmin(np.abs(axis))
        out = np.eye(3)[across] - axis[across] * axis
        return add_wheels(self._tree, stage.gears, link, axis, out / np.linalg.norm(out))

    def _axis(self, joint: int) -> np.ndarray:
        """Axis (3,) of a joint of the tree that turns, in its body's frame."""
        return np.ravel(self._tree.createData().joints[joint].S)[3:]

    def mass_matrix(self, q: np.ndarray) -> np.ndarray:
        """Mass matrix (states, n, n), by the composite algorithm if joints are depth-first.

        Rotors may not be; then column by column, by recursive Newton-Euler.
        """
        return self._mass_matrix_at(self._configurations(q))

    def _mass_matrix_at(self, configurations: Sequence[np.ndarray]) -> np.ndarray:
        if self._is_depth_first:
            trees = [pin.crba(self._tree, self._data, at).copy() for at in configurations]
            return self._given.T @ np.array(trees) @ self._given
        still = np.zeros(self._tree.nv)
        columns = [
            [pin.rnea(self._weightless, self._data, at, still, column) for column in self._given.T]
            for at in configurations
        ]
        torques: np.ndarray = np.array(columns).transpose(0, 2, 1)
        return self._given.T @ torques

    def bias(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Coriolis and centrifugal torques (states, n), by Pinocchio's nonlinear effects."""
        return self._holding_torques(self._weightless, self._configurations(q), v)

    def gravity(self, q: np.ndarray) -> np.ndarray:
        """Torques that hold the weights (states, n), by Pinocchio's own function for it."""
        torques = [
            pin.computeGeneralizedGravity(self._tree, self._data, at).copy()
            for at in self._configurations(q)
        ]
        return np.array(torques) @ self._given

    def inverse_dynamics(self, q: np.ndarray, v: np.ndarray, a: np.ndarray) -> np.ndarray:
        """Generalized forces of a motion (states, n), by recursive Newton-Euler."""
        moving = self._configurations(q), v @ self._given.T, a @ self._given.T
        torques = [
            pin.rnea(self._tree, self._data, *motion) for motion in zip(*moving, strict=True)
        ]
        return np.array(torques) @ self._given - self._passive_forces(q, v)

    def generalized_force(
        self, t: np.ndarray, q: np.ndarray, v: np.ndarray, torques: np.ndarray
    ) -> np.ndarray:
        """Torques of motors, meshes, friction and weights at times t (states,) [s], (states, n)."""
        return torques @ self.drive + self._passive_forces(q, v, t) - self.gravity(q)

    def forward_dynamics(
        self, q: np.ndarray, v: np.ndarray, torques: np.ndarray, t: np.ndarray | float = 0.0
    ) -> np.ndarray:
        """Accelerations under torques of motors (states, n) at times t [s], solved with M."""
        left = torques @ self.drive + self._passive_forces(q, v, t)
        configurations = self._configurations(q)
        left -= self._holding_torques(self._tree, configurations, v)
        return np.linalg.solve(self._mass_matrix_at(configurations), left[:, :, None])[:, :, 0]

    def acceleration(
        self, t: np.ndarray, q: np.ndarray, v: np.ndarray, torques: np.ndarray
    ) -> np.ndarray:
        """The same, times (states,) first."""
        return self.forward_dynamics(q, v, torques, t)

    def energy(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Kinetic energy and that of the weights (states,) [J], by Pinocchio's own functions.

        But for armature: version 4.1 forgets that of joints whose axes are not x, y or z.
        """
        bodies, rates = self._tree.copy(), v @ self._given.T
        bodies.armature = np.zeros(self._tree.nv)
        energies = [
            pin.computeKineticEnergy(bodies, self._data, at, rate)
            + pin.computePotentialEnergy(bodies, self._data, at)
            for at, rate in zip(self._configurations(q), rates, strict=True)
        ]
        return np.array(energies) + rates**2 @ self._tree.armature / 2

    def momentum(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Linear, then angular momentum (states, 6), from Pinocchio's centroidal momentum."""
        momenta = []
        for at, rate in zip(self._configurations(q), v @ self._given.T, strict=True):
            central = pin.computeCentroidalMomentum(self._tree, self._data, at, rate)
            angular = central.angular + np.cross(self._data.com[0], central.linear)
            momenta.append(np.concatenate([central.linear, angular]))
        return np.array(momenta)

    def tip(self, q: np.ndarray) -> np.ndarray:
        """Position of the tip (states, 3) [m], of the frame that Pinocchio's parser made."""
        frame = self._tree.getFrameId(self.robot.tip, pin.BODY)
        places = []
        for at in self._configurations(q):
            pin.framesForwardKinematics(self._tree, self._data, at)
            places.append(self._data.oMf[frame].translation.copy())
        return np.array(places)

    def _configurations(self, q: np.ndarray) -> list[np.ndarray]:
        """Configurations of the tree; a continuous joint has two numbers in them."""
        return [
            pin.integrate(self._tree, self._home, each) for each in q @ self._given.T + self._offset
        ]

    def _holding_torques(
        self, tree: pin.Model, configurations: Sequence[np.ndarray], v: np.ndarray
    ) -> np.ndarray:
        """Generalized forces (states, n) under which no coordinate of a tree accelerates."""
        states = zip(configurations, v @ self._given.T, strict=True)
        torques = [pin.nle(tree, self._data, *state).copy() for state in states]
        return np.array(torques) @ self._given

    def _passive_forces(
        self, q: np.ndarray, v: np.ndarray, t: np.ndarray | float = 0.0
    ) -> np.ndarray:
        """Generalized forces (states, n) of friction and meshes at times t [s]."""
        efforts = -self._tree.damping * (v @ self._given.T)
        for column, rotor_place, joint_place, ratio, mesh in self._meshes:
            force = _tooth_force(mesh, q[:, column], v[:, column])
            efforts[:, rotor_place] -= mesh.pinion_base_radius_m * force
            efforts[:, joint_place] += ratio * mesh.pinion_base_radius_m * force
        still = np.zeros(self._tree.nv)
        states = zip(np.broadcast_to(t, len(q)), q, v, efforts, strict=True)
        for time, at, rate, effort in states if self._link_places else ():
            if self._laws.mesh_work == "conservative":
                turned = self._mesh_law.phase_torques(self._engage(time, at, rate))
                np.add.at(effort, self._link_places, turned)
            pushes = self._local_wrenches(self.contact_wrenches(time, at, rate))
            # At rest and weightless, the joints must hold what the contacts exert.
            (pose,) = self._configurations(at[None])
            effort -= pin.rnea(self._weightless, self._data, pose, still, still, pushes)
        return efforts @ self._given

    def stage_forces(self, q: np.ndarray) -> np.ndarray:
        """Forces (states, meshes) [N] of the springs of all contacts."""
        still = np.zeros(len(self._displacements))
        forces = [self._mesh_law.forces(self._engage(0.0, at, 0 * at), still) for at in q]
        return np.reshape(forces, (len(q), still.size))

    def contact_wrenches(self, t: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Sum of the planets' contact forces on each of ``bodies``, damping included, (bodies, 6).

        At time t [s] in the state q, v (n,). Force [N], and moment about the base's origin [N m],
        along the base's axes. What teeth push outwards does no work.
        """
        teeth = self._mesh_law.meshes
        force = self._mesh_law.forces(self._engage(t, q, v), self._displacements @ v)
        (at,) = self._configurations(q[None])
        pin.forwardKinematics(self._tree, self._data, at)
        places, turns = (
            np.array([getattr(pose, part) for pose in self._data.oMi])
            for part in ("translation", "rotation")
        )
        centre, line = places[teeth.link], places[teeth.planet] - places[teeth.link]
        outward = line / np.linalg.norm(line, axis=1)[:, None]
        axes = np.einsum("mij,mj->mi", turns[teeth.link], self._axes)
        # Pressed on either flank, teeth are driven out of mesh: the planet away from the sun, but
        # away from the ring towards the axis.
        along = teeth.cosine * force, teeth.side * teeth.sine * np.abs(force)
        push = along[0][:, None] * np.cross(axes, outward) + along[1][:, None] * outward
        contact = centre + teeth.pitch[:, None] * line
        on_planets = np.hstack([push, np.cross(contact, push)])
        wrenches = np.zeros((self._tree.njoints, 6))
        np.add.at(wrenches, teeth.planet, on_planets)
        np.subtract.at(wrenches, teeth.central, on_planets)
        return wrenches

    def _local_wrenches(self, wrenches: np.ndarray) -> pin.StdVec_Force:
        """Wrenches on the bodies in each one's own frame, at the poses of the tree's data."""
        local = pin.StdVec_Force()
        for pose, wrench in zip(self._data.oMi, wrenches, strict=True):
            local.append(pose.actInv(pin.Force(wrench)))
        return local

    def _engage(self, t: float, q: np.ndarray, v: np.ndarray) -> Engagement:
        """How the teeth of all contacts stand at time t [s] in a state (n,)."""
        teeth, places = self._mesh_law.meshes, self._link_places
        if self._laws.phase == "angle":
            turned = self._given[places] @ q + self._offset[places]
        else:
            turned = self._given[places] @ v * t
        return self._mesh_law.engage(teeth.rate * turned + teeth.phase, self._displacements @ q)


def _tooth_force(mesh: RotorMesh, x: np.ndarray, rate: np.ndarray) -> np.ndarray:
    """Forces (states,) of the pinion on the wheel [N], positive where the pinion is ahead."""
    deflection = x - np.clip(x, -mesh.backlash_m, mesh.backlash_m)
    force = mesh.stiffness_N_per_m * deflection + mesh.damping_N_s_per_m * rate
    return np.where(np.abs(x) > mesh.backlash_m, force, 0.0)

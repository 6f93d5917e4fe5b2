"""A robot in Pinocchio, which reads the URDF itself; rotors are bodies of its tree.

The tree's joints that are not free (those that mimic, and rotors) follow from the coordinates by a
constant matrix G: M = G' M_tree G, and so for the torques. A mesh pushes bodies of the tree: rotor
and stator, and the two that its joint connects. Every planet of a stage is a body on the carrier,
which sun and ring push at the pitch points. Friction is that of the tree's joints, of which no
algorithm of Pinocchio's takes notice.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pinocchio as pin

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
    """Where a mesh acts: column of its x; joints of the tree, the rotor's and the one it moves."""

    column: int
    rotor_joint: int
    driven_joint: int
    ratio: float
    mesh: RotorMesh


class PinocchioRobot(RobotModel):
    """Pinocchio's algorithms on the tree of its own URDF parser."""

    name = "pinocchio"

    def __init__(self, robot: Robot, level: Level) -> None:
        super().__init__(robot, level)
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
        springs = robot.mesh_coordinates if level == "geared" else 0
        self._offset = np.zeros(self._tree.nv)
        self._given = np.zeros((self._tree.nv, len(free) + springs))  # G
        self._motors = np.zeros((len(free), self._tree.nv))  # efforts in the tree, per torque
        self._meshes: list[MeshConnection] = []
        for place, joint in zip(places, robot.joints, strict=True):
            if joint.mimic is None:
                number = free.index(robot.joints.index(joint))
                self._given[place, number] = self._motors[number, place] = 1.0
        for place, joint in zip(places, robot.joints, strict=True):
            if joint.mimic is not None:
                self._given[place] = joint.mimic.multiplier * self._given[places[joint.mimic.joint]]
                self._offset[place] = joint.mimic.offset
        for rotor_joint, rotor in zip(rotors, bodies, strict=True):
            place, column = self._tree.joints[rotor_joint].idx_v, len(free) + len(self._meshes)
            self._given[place] = rotor.ratio * self._given[places[rotor.joint]]
            if meshes and rotor.mesh:
                self._given[place, column] = 1 / rotor.mesh.pinion_base_radius_m
                connection = MeshConnection(
                    column, rotor_joint, moving_joints[rotor.joint], rotor.ratio, rotor.mesh
                )
                self._meshes.append(connection)
                if rotor.joint in free:
                    self._motors[free.index(rotor.joint)] = 0.0
                    self._motors[free.index(rotor.joint), place] = 1 / rotor.ratio
        rows: list[np.ndarray] = []  # x of each contact by the coordinates
        for stage, wheels, columns in zip(geared, stages, robot.stage_columns, strict=False):
            gears, link = stage.gears, self._given[places[stage.joint]]
            r_s, r_p, _ = base_radii(gears)
            sun = self._tree.joints[wheels.driven].idx_v
            for number, planet in enumerate(wheels.planets):
                x_sp, x_pr = np.zeros((2, len(free) + springs))
                if level == "geared":
                    alike = number if stage.has_free_planets else 0
                    x_sp[columns] = stage.displacement("x_sp", alike)
                    x_pr[columns] = stage.displacement("x_pr", alike)
                    rows += [x_sp, x_pr]
                turns = planet_turns(gears) * link - x_pr / r_p
                self._given[self._tree.joints[planet].idx_v] = turns
            self._given[sun] = sun_turns(gears) * link + (x_sp + x_pr) / r_s
            if level != "geared":
                continue
            if stage.joint in free:
                self._motors[free.index(stage.joint)] = 0.0
                self._motors[free.index(stage.joint), sun] = 1 / sun_turns(gears)
        self._displacements = np.array(rows)
        elastic = zip(geared, stages, strict=True) if level == "geared" else ()
        contacts = find_contacts((stage.gears, wheels) for stage, wheels in elastic)
        self._mesh_law = MeshForces(contacts, MESH_LAWS)
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

    def _add_rotor(self, rotor: Rotor, number: int) -> int:
        """Add a rotor's body to the tree; returns its joint."""
        frame = self._tree.frames[self._tree.getFrameId(rotor.stator, pin.BODY)]
        axis = frame.placement.rotation @ rotor.axis
        name = f"rotor of {rotor.joint} ({number})"
        stator, placement = frame.parentJoint, pin.SE3.Identity()
        return add_spinning_body(self._tree, stator, placement, axis, rotor.inertia, name)

    def _add_stage(self, stage: JointStage, link: int) -> TreeStage:
        """Add sun and planets of a joint of the tree."""
        axis = np.ravel(self._tree.createData().joints[link].S)[3:]
        out = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
        return add_wheels(self._tree, stage.gears, link, axis, out / np.linalg.norm(out))

    def mass_matrix(self, q: np.ndarray) -> np.ndarray:
        """Mass matrix (states, n, n), column by column by recursive Newton-Euler.

        The composite algorithm wants depth-first joints, which the rotors are not.
        """
        still = np.zeros(self._tree.nv)
        columns = [
            [pin.rnea(self._weightless, self._data, at, still, column) for column in self._given.T]
            for at in self._configurations(q)
        ]
        torques: np.ndarray = np.array(columns).transpose(0, 2, 1)
        return self._given.T @ torques

    def bias(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Coriolis and centrifugal torques (states, n), by recursive Newton-Euler."""
        return self._torques(self._weightless, q, v, np.zeros_like(v))

    def gravity(self, q: np.ndarray) -> np.ndarray:
        """Torques that hold the weights (states, n), by Pinocchio's own function for it."""
        torques = [
            pin.computeGeneralizedGravity(self._tree, self._data, at).copy()
            for at in self._configurations(q)
        ]
        return np.array(torques) @ self._given

    def inverse_dynamics(self, q: np.ndarray, v: np.ndarray, a: np.ndarray) -> np.ndarray:
        """Generalized forces of a motion (states, n), by recursive Newton-Euler."""
        return self._torques(self._tree, q, v, a, include_passive=True)

    def forward_dynamics(self, q: np.ndarray, v: np.ndarray, torques: np.ndarray) -> np.ndarray:
        """Accelerations under torques of motors (states, n).

        By the articulated body algorithm where every joint of the tree is free, else solved with M.
        """
        efforts = torques @ self._motors
        if self._given.shape[0] > self._given.shape[1]:
            held = self._torques(self._tree, q, v, np.zeros_like(v), include_passive=True)
            left = efforts @ self._given - held
            return np.linalg.solve(self.mass_matrix(q), left[:, :, None])[:, :, 0]
        rates = v @ self._given.T
        rows = zip(
            self._configurations(q),
            rates,
            efforts - self._tree.damping * rates,
            self._mesh_wrenches(q, v),
            strict=True,
        )
        solved = [
            pin.aba(self._tree, self._data, at, rate, effort, *push).copy()
            for at, rate, effort, push in rows
        ]
        return np.linalg.solve(self._given, np.transpose(solved)).T

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

    def _torques(
        self,
        tree: pin.Model,
        q: np.ndarray,
        v: np.ndarray,
        a: np.ndarray,
        include_passive: bool = False,
    ) -> np.ndarray:
        rates = v @ self._given.T
        mesh_wrenches = self._mesh_wrenches(q, v) if include_passive else [()] * len(q)
        rows = zip(
            self._configurations(q),
            rates,
            a @ self._given.T,
            mesh_wrenches,
            strict=True,
        )
        torques = np.array(
            [pin.rnea(tree, self._data, at, *moving, *push) for at, *moving, push in rows]
        )
        if include_passive:
            torques += self._tree.damping * rates
        return torques @ self._given

    def _mesh_wrenches(self, q: np.ndarray, v: np.ndarray) -> list[tuple[pin.StdVec_Force, ...]]:
        """Wrenches of the meshes on all bodies, for each state; empty where there is no mesh."""
        if not self._meshes and not self._displacements.size:
            return [()] * len(q)
        state_wrenches = []
        for at, coordinates, rate in zip(self._configurations(q), q, v, strict=True):
            pin.forwardKinematics(self._tree, self._data, at)
            wrenches = pin.StdVec_Force()
            wrenches.extend([pin.Force.Zero()] * self._tree.njoints)
            for column, rotor_joint, driven_joint, ratio, mesh in self._meshes:
                moment = (
                    _tooth_force(mesh, coordinates[column], rate[column])
                    * mesh.pinion_base_radius_m
                )
                for joint, effort in ((rotor_joint, -moment), (driven_joint, ratio * moment)):
                    self._turn(joint, effort, wrenches)
            if self._displacements.size:
                self._press(coordinates, rate, wrenches)
            state_wrenches.append((wrenches,))
        return state_wrenches

    def stage_forces(self, q: np.ndarray) -> np.ndarray:
        """Forces (states, meshes) [N] of the springs of all contacts."""
        still = np.zeros(len(self._displacements))
        forces = [self._mesh_law.forces(self._engage(at), still) for at in q if still.size]
        return np.reshape(forces, (len(q), still.size))

    def _engage(self, q: np.ndarray) -> Engagement:
        """How the teeth of all contacts stand at coordinates (n,)."""
        teeth = self._mesh_law.meshes
        places = [self._tree.joints[link].idx_v for link in teeth.link.tolist()]
        phase = teeth.rate * (self._given[places] @ q + self._offset[places]) + teeth.phase
        return self._mesh_law.engage(phase, self._displacements @ q)

    def _turn(self, joint: int, effort: float, wrenches: pin.StdVec_Force) -> None:
        """Add an effort about a joint to the wrenches on its body and the one before."""
        wrench = pin.Force(self._data.joints[joint].S * effort)
        wrenches[joint] += wrench
        wrenches[self._tree.parents[joint]] -= self._data.liMi[joint].act(wrench)

    def _press(self, q: np.ndarray, v: np.ndarray, wrenches: pin.StdVec_Force) -> None:
        """Add the contacts of planets in a state, at the poses of the tree's data.

        They push along the pitch circles: what they push outwards does no work.
        """
        teeth, poses = self._mesh_law.meshes, self._data.oMi
        bodies = [column.tolist() for column in (teeth.link, teeth.planet, teeth.central)]
        engaged = self._engage(q)
        force = self._mesh_law.forces(engaged, self._displacements @ v)
        turned = self._mesh_law.phase_torques(engaged)
        for number, (link, planet, central) in enumerate(zip(*bodies, strict=True)):
            centre = poses[link].translation
            line = poses[planet].translation - centre
            outward = line / np.linalg.norm(line)
            axis = poses[link].rotation @ np.ravel(self._data.joints[link].S)[3:]
            push = force[number] * teeth.cosine[number] * (pin.skew(axis) @ outward)
            point = centre + teeth.pitch[number] * line
            wrench = pin.Force(push, pin.skew(point) @ push)
            wrenches[planet] += poses[planet].actInv(wrench)
            wrenches[central] -= poses[central].actInv(wrench)
            self._turn(link, turned[number], wrenches)


def _tooth_force(mesh: RotorMesh, x: float, rate: float) -> float:
    """Force of the pinion on the wheel [N], positive where the pinion is ahead."""
    if abs(x) <= mesh.backlash_m:
        return 0.0
    deflection = x - mesh.backlash_m if x > 0 else x + mesh.backlash_m
    return mesh.stiffness_N_per_m * deflection + mesh.damping_N_s_per_m * rate

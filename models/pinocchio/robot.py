"""A robot in Pinocchio, which reads the URDF itself; rotors are bodies of its tree.

The tree's joints that are not free (those that mimic, and rotors) follow from the coordinates by a
constant matrix G: M = G' M_tree G, and so for the torques. A mesh pushes bodies of the tree: rotor
and stator, and the two that its joint connects.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pinocchio as pin

from crosscheck.models.robot.interface import RobotModel
from crosscheck.models.robot.robot import WITH_ROTORS, Level, Robot, Rotor, RotorMesh


class PushedJoints(NamedTuple):
    """Where a mesh acts: column of its x; joints of the tree, that of the rotor and its own."""

    column: int
    turned: int
    moved: int
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
        moved = [self._tree.getJointId(joint.name) for joint in robot.joints]
        bodies = robot.rotors if level in WITH_ROTORS else ()
        rotors = [self._added(rotor, number) for number, rotor in enumerate(bodies)]
        places = [self._tree.joints[joint].idx_v for joint in moved]
        free, meshes = robot.coordinates, robot.meshes if level == "geared" else ()
        self._offset = np.zeros(self._tree.nv)
        self._given = np.zeros((self._tree.nv, len(free) + len(meshes)))  # G
        self._motors = np.zeros((len(free), self._tree.nv))  # efforts in the tree, per torque
        self._meshes: list[PushedJoints] = []
        for place, joint in zip(places, robot.joints, strict=True):
            if joint.mimic is None:
                number = free.index(robot.joints.index(joint))
                self._given[place, number] = self._motors[number, place] = 1.0
        for place, joint in zip(places, robot.joints, strict=True):
            if joint.mimic is not None:
                self._given[place] = joint.mimic.multiplier * self._given[places[joint.mimic.joint]]
                self._offset[place] = joint.mimic.offset
        for turned, rotor in zip(rotors, bodies, strict=True):
            place, column = self._tree.joints[turned].idx_v, len(free) + len(self._meshes)
            self._given[place] = rotor.ratio * self._given[places[rotor.joint]]
            if meshes and rotor.mesh:
                self._given[place, column] = 1 / rotor.mesh.pinion_base_radius_m
                own = PushedJoints(column, turned, moved[rotor.joint], rotor.ratio, rotor.mesh)
                self._meshes.append(own)
                if rotor.joint in free:
                    self._motors[free.index(rotor.joint)] = 0.0
                    self._motors[free.index(rotor.joint), place] = 1 / rotor.ratio
        if level == "armature":
            armature = np.zeros(self._tree.nv)
            for rotor in robot.rotors:
                armature[places[rotor.joint]] += rotor.inertia * rotor.ratio**2
            self._tree.armature = armature
        self._tree.gravity.linear = robot.gravity
        self._weightless = self._tree.copy()
        self._weightless.gravity.linear = np.zeros(3)
        self._data = self._tree.createData()
        self._home = pin.neutral(self._tree)

    def _added(self, rotor: Rotor, number: int) -> int:
        """The joint of a rotor; its body has inertia about its axis alone."""
        frame = self._tree.frames[self._tree.getFrameId(rotor.stator, pin.BODY)]
        spin = pin.JointModelRevoluteUnaligned(frame.placement.rotation @ rotor.axis)
        joint: int = self._tree.addJoint(
            frame.parentJoint, spin, pin.SE3.Identity(), f"rotor of {rotor.joint} ({number})"
        )
        axis = frame.placement.rotation @ rotor.axis
        body = pin.Inertia(0.0, np.zeros(3), rotor.inertia * np.outer(axis, axis))
        self._tree.appendBodyToJoint(joint, body, pin.SE3.Identity())
        return joint

    def mass_matrix(self, q: np.ndarray) -> np.ndarray:
        """Column by column by recursive Newton-Euler.

        The composite algorithm wants depth-first joints, which the rotors are not.
        """
        still = np.zeros(self._tree.nv)
        columns = [
            [pin.rnea(self._weightless, self._data, at, still, column) for column in self._given.T]
            for at in self._placed(q)
        ]
        found: np.ndarray = np.array(columns).transpose(0, 2, 1)
        return self._given.T @ found

    def bias(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """By recursive Newton-Euler (states, n)."""
        return self._torques(self._weightless, q, v, np.zeros_like(v))

    def gravity(self, q: np.ndarray) -> np.ndarray:
        """By Pinocchio's own function for it (states, n)."""
        torques = [
            pin.computeGeneralizedGravity(self._tree, self._data, at).copy()
            for at in self._placed(q)
        ]
        return np.array(torques) @ self._given

    def inverse_dynamics(self, q: np.ndarray, v: np.ndarray, a: np.ndarray) -> np.ndarray:
        """By recursive Newton-Euler (states, n)."""
        return self._torques(self._tree, q, v, a, pushed=True)

    def forward_dynamics(self, q: np.ndarray, v: np.ndarray, torques: np.ndarray) -> np.ndarray:
        """By the articulated body algorithm where every joint of the tree is free (states, n)."""
        efforts = torques @ self._motors
        if self._given.shape[0] > self._given.shape[1]:
            held = self._torques(self._tree, q, v, np.zeros_like(v), pushed=True)
            left = efforts @ self._given - held
            found: np.ndarray = np.linalg.solve(self.mass_matrix(q), left[:, :, None])[:, :, 0]
            return found
        rows = zip(self._placed(q), v @ self._given.T, efforts, self._pushes(q, v), strict=True)
        solved = [
            pin.aba(self._tree, self._data, at, rate, effort, *push).copy()
            for at, rate, effort, push in rows
        ]
        accelerations: np.ndarray = np.linalg.solve(self._given, np.transpose(solved)).T
        return accelerations

    def energy(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """By Pinocchio's own functions for both (states,) [J].

        But for armature: version 4.1 forgets that of joints whose axes are not x, y or z.
        """
        bodies, rates = self._tree.copy(), v @ self._given.T
        bodies.armature = np.zeros(self._tree.nv)
        found = [
            pin.computeKineticEnergy(bodies, self._data, at, rate)
            + pin.computePotentialEnergy(bodies, self._data, at)
            for at, rate in zip(self._placed(q), rates, strict=True)
        ]
        return np.array(found) + rates**2 @ self._tree.armature / 2

    def momentum(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """By its centroidal momentum (states, 6)."""
        found = []
        for at, rate in zip(self._placed(q), v @ self._given.T, strict=True):
            central = pin.computeCentroidalMomentum(self._tree, self._data, at, rate)
            angular = central.angular + np.cross(self._data.com[0], central.linear)
            found.append(np.concatenate([central.linear, angular]))
        return np.array(found)

    def tip(self, q: np.ndarray) -> np.ndarray:
        """Of the frame that its parser made (states, 3) [m]."""
        frame = self._tree.getFrameId(self.robot.tip, pin.BODY)
        places = []
        for at in self._placed(q):
            pin.framesForwardKinematics(self._tree, self._data, at)
            places.append(self._data.oMf[frame].translation.copy())
        return np.array(places)

    def _placed(self, q: np.ndarray) -> list[np.ndarray]:
        """Configurations of the tree; a continuous joint has two numbers in them."""
        return [
            pin.integrate(self._tree, self._home, each) for each in q @ self._given.T + self._offset
        ]

    def _torques(
        self, tree: pin.Model, q: np.ndarray, v: np.ndarray, a: np.ndarray, pushed: bool = False
    ) -> np.ndarray:
        pushes = self._pushes(q, v) if pushed else [()] * len(q)
        rows = zip(self._placed(q), v @ self._given.T, a @ self._given.T, pushes, strict=True)
        found = [pin.rnea(tree, self._data, at, *moving, *push) for at, *moving, push in rows]
        return np.array(found) @ self._given

    def _pushes(self, q: np.ndarray, v: np.ndarray) -> list[tuple[pin.StdVec_Force, ...]]:
        """Wrenches of the meshes on all bodies, for each state; empty where there is no mesh."""
        if not self._meshes:
            return [()] * len(q)
        found = []
        for at, own, rate in zip(self._placed(q), q, v, strict=True):
            pin.forwardKinematics(self._tree, self._data, at)
            wrenches = pin.StdVec_Force()
            wrenches.extend([pin.Force.Zero()] * self._tree.njoints)
            for column, turned, moved, ratio, mesh in self._meshes:
                moment = _tooth_force(mesh, own[column], rate[column]) * mesh.pinion_base_radius_m
                for joint, effort in ((turned, -moment), (moved, ratio * moment)):
                    wrench = pin.Force(self._data.joints[joint].S * effort)
                    wrenches[joint] += wrench
                    wrenches[self._tree.parents[joint]] -= self._data.liMi[joint].act(wrench)
            found.append((wrenches,))
        return found


def _tooth_force(mesh: RotorMesh, x: float, rate: float) -> float:
    """Of the pinion on the wheel [N], positive where the pinion is ahead."""
    if abs(x) <= mesh.backlash_m:
        return 0.0
    deflection = x - mesh.backlash_m if x > 0 else x + mesh.backlash_m
    return mesh.stiffness_N_per_m * deflection + mesh.damping_N_s_per_m * rate

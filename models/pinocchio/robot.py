"""A robot in Pinocchio, which reads the URDF itself; rotors are bodies of its tree.

The tree's joints that are not free (those that mimic, and rotors) follow from the free ones by a
constant matrix G: M = G' M_tree G, and so for the torques.
"""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from crosscheck.models.robot.interface import RobotModel
from crosscheck.models.robot.robot import Level, Robot


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
        places = [self._tree.joints[self._tree.getJointId(j.name)].idx_v for j in robot.joints]
        rotors = [self._added(n) for n in range(len(robot.rotors))] if level == "coupled" else []
        self._offset = np.zeros(self._tree.nv)
        self._given = np.zeros((self._tree.nv, len(robot.coordinates)))  # G
        for place, joint in zip(places, robot.joints, strict=True):
            if joint.mimic is None:
                free = robot.coordinates.index(robot.joints.index(joint))
                self._given[place, free] = 1.0
        for place, joint in zip(places, robot.joints, strict=True):
            if joint.mimic is not None:
                self._given[place] = joint.mimic.multiplier * self._given[places[joint.mimic.joint]]
                self._offset[place] = joint.mimic.offset
        for place, rotor in zip(rotors, robot.rotors, strict=bool(rotors)):
            self._given[place] = rotor.ratio * self._given[places[rotor.joint]]
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

    def _added(self, number: int) -> int:
        """The place of a rotor's rate; its body has inertia about its axis alone."""
        rotor = self.robot.rotors[number]
        frame = self._tree.frames[self._tree.getFrameId(rotor.stator, pin.BODY)]
        spin = pin.JointModelRevoluteUnaligned(frame.placement.rotation @ rotor.axis)
        joint = self._tree.addJoint(
            frame.parentJoint, spin, pin.SE3.Identity(), f"rotor of {rotor.joint} ({number})"
        )
        axis = frame.placement.rotation @ rotor.axis
        body = pin.Inertia(0.0, np.zeros(3), rotor.inertia * np.outer(axis, axis))
        self._tree.appendBodyToJoint(joint, body, pin.SE3.Identity())
        place: int = self._tree.joints[joint].idx_v
        return place

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
        return self._torques(self._tree, q, v, a)

    def forward_dynamics(self, q: np.ndarray, v: np.ndarray, torques: np.ndarray) -> np.ndarray:
        """By the articulated body algorithm where every joint of the tree is free (states, n)."""
        if self._given.shape[0] > self._given.shape[1]:
            left = torques - self._torques(self._tree, q, v, np.zeros_like(v))
            found: np.ndarray = np.linalg.solve(self.mass_matrix(q), left[:, :, None])[:, :, 0]
            return found
        rows = zip(self._placed(q), v @ self._given.T, torques @ self._given.T, strict=True)
        solved = [pin.aba(self._tree, self._data, *row).copy() for row in rows]
        return np.array(solved) @ self._given

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

    def _torques(self, tree: pin.Model, q: np.ndarray, v: np.ndarray, a: np.ndarray) -> np.ndarray:
        rows = zip(self._placed(q), v @ self._given.T, a @ self._given.T, strict=True)
        found: np.ndarray = np.array([pin.rnea(tree, self._data, *row) for row in rows])
        return found @ self._given

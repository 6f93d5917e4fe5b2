"""Torques of a robot's links as linear functions of their masses, by Pinocchio's regressor."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from crosscheck.models.robot.robot import Robot

BODY_PARAMETERS = ("m", "mx", "my", "mz", "Ixx", "Ixy", "Iyy", "Ixz", "Iyz", "Izz")


class LinkRegressor:
    """The regressor of a robot's links, without rotors.

    Args:
        robot: Its URDF is read by Pinocchio itself.

    Attributes:
        names: Of the parameters, ten for each joint's body: mass [kg], first moments [kg m] and
            inertia [kg m^2] about the origin of the joint's frame.
        values: What the URDF says of them.
    """

    def __init__(self, robot: Robot) -> None:
        self._tree = pin.buildModelFromXML(robot.urdf)
        self._tree.gravity.linear = robot.gravity
        self._data, self._home = self._tree.createData(), pin.neutral(self._tree)
        places = {
            joint.name: self._tree.joints[self._tree.getJointId(joint.name)].idx_v
            for joint in robot.joints
        }
        self._shares = np.zeros((self._tree.nv, len(robot.coordinates)))
        self._offset = np.zeros(self._tree.nv)
        for number, joint in enumerate(robot.joints):
            leads = joint.mimic.joint if joint.mimic else number
            place, column = places[joint.name], robot.coordinates.index(leads)
            self._shares[place, column] = joint.mimic.multiplier if joint.mimic else 1.0
            self._offset[place] = joint.mimic.offset if joint.mimic else 0.0
        bodies = self._tree.names[1:]
        self.names = tuple(f"{body}: {name}" for body in bodies for name in BODY_PARAMETERS)
        self.values = np.concatenate(
            [body.toDynamicParameters() for body in list(self._tree.inertias)[1:]]
        )

    def compute(self, q: np.ndarray, v: np.ndarray, a: np.ndarray) -> np.ndarray:
        """Slopes (states, n, parameters) of the torques, for motions (states, n)."""
        rows = np.empty((len(q), q.shape[1], len(self.names)))
        shares = self._shares
        states = zip(q @ shares.T + self._offset, v @ shares.T, a @ shares.T, strict=True)
        for row, (at, rate, more) in zip(rows, states, strict=True):
            place = pin.integrate(self._tree, self._home, at)
            slopes = pin.computeJointTorqueRegressor(self._tree, self._data, place, rate, more)
            np.matmul(shares.T, slopes, out=row)
        return rows

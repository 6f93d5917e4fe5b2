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
        numbers = map(self._tree.getJointId, [joint.name for joint in robot.joints])
        places = [self._tree.joints[number].idx_v for number in numbers]
        self._shares = np.zeros((self._tree.nv, len(robot.coordinates)))
        self._offset = np.zeros(self._tree.nv)
        self._shares[places], self._offset[places] = robot.joint_map
        bodies = self._tree.names[1:]
        self.names = tuple(f"{body}: {name}" for body in bodies for name in BODY_PARAMETERS)
        self.values = np.concatenate(
            [body.toDynamicParameters() for body in list(self._tree.inertias)[1:]]
        )

    def gravity_torques(self, q: np.ndarray) -> np.ndarray:
        """Slopes (states, n, 3) of the URDF's links' torques at rest in gravity [m/s^2], at q."""
        slopes = np.empty((len(q), self._shares.shape[1], 3))
        for row, at in zip(slopes, q @ self._shares.T + self._offset, strict=True):
            place = pin.integrate(self._tree, self._home, at)
            centre = pin.jacobianCenterOfMass(self._tree, self._data, place)
            weights = -self._data.mass[0] * centre.reshape(3, -1)  # of one joint: a vector
            np.matmul(self._shares.T, weights.T, out=row)
        return slopes

    def compute(self, q: np.ndarray, v: np.ndarray, a: np.ndarray) -> np.ndarray:
        """Slopes (states, n, parameters) of the torques, for motions (states, n)."""
        rows = np.empty((len(q), q.shape[1], len(self.names)))
        shares = self._shares
        states = zip(q @ shares.T + self._offset, v @ shares.T, a @ shares.T, strict=True)
        for row, (at, rate, more) in zip(rows, states, strict=True):
            place = pin.integrate(self._tree, self._home, at)
            slopes = pin.computeJointTorqueRegressor(self._tree, self._data, place, rate, more)
            # A single row reaches Python as a vector.
            np.matmul(shares.T, slopes.reshape(self._tree.nv, -1), out=row)
        return rows

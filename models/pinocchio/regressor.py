"""Torques of a robot's links as linear functions of their masses, by Pinocchio's regressor."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from crosscheck.models.pinocchio.robot import PinocchioRobot
from crosscheck.models.robot.robot import Robot

BODY_PARAMETERS = ("m", "mx", "my", "mz", "Ixx", "Ixy", "Iyy", "Ixz", "Iyz", "Izz")


class LinkRegressor(PinocchioRobot):
    """The regressor of a robot's links, without rotors.

    Args:
        robot: Its URDF is read by Pinocchio itself.

    Attributes:
        names: Of the parameters, ten for each joint's body: mass [kg], first moments [kg m] and
            inertia [kg m^2] about the origin of the joint's frame.
        values: What the URDF says of them.
    """

    def __init__(self, robot: Robot) -> None:
        super().__init__(robot, "links")
        self.names = tuple(
            f"{body}: {name}" for body in self.bodies[1:] for name in BODY_PARAMETERS
        )
        self.values = np.concatenate(
            [body.toDynamicParameters() for body in list(self._tree.inertias)[1:]]
        )

    def gravity_torques(self, q: np.ndarray) -> np.ndarray:
        """Slopes (states, n, 3) of the URDF's links' torques at rest in gravity [m/s^2], at q."""
        slopes = np.empty((len(q), self._given.shape[1], 3))
        for row, at in zip(slopes, self._configurations(q), strict=True):
            centre = pin.jacobianCenterOfMass(self._tree, self._data, at)
            weights = -self._data.mass[0] * centre.reshape(3, -1)  # of one joint: a vector
            np.matmul(self._given.T, weights.T, out=row)
        return slopes

    def compute(self, q: np.ndarray, v: np.ndarray, a: np.ndarray) -> np.ndarray:
        """Slopes (states, n, parameters) of the torques, for motions (states, n)."""
        rows = np.empty((len(q), q.shape[1], len(self.names)))
        moving = self._configurations(q), v @ self._given.T, a @ self._given.T
        for row, *motion in zip(rows, *moving, strict=True):
            slopes = pin.computeJointTorqueRegressor(self._tree, self._data, *motion)
            # A single row reaches Python as a vector.
            np.matmul(self._given.T, slopes.reshape(self._tree.nv, -1), out=row)
        return rows

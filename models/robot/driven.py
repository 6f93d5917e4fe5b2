"""A robot's model under the drive of an experiment: it is asked what every Model is asked."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from crosscheck.models.experiment.drive import DriveData, torques_along
from crosscheck.models.interface import STATE_ABILITIES, Model
from crosscheck.models.robot.integration import require_regular

if TYPE_CHECKING:
    from crosscheck.models.robot.interface import RobotModel


class DrivenRobot(Model):
    """Equations of motion M(q) a + bias(q, v) = f(t, q, v) of a robot in an experiment.

    ``model`` is the engine's, without the experiment, of which all answers are. Of the robot's
    coordinates in their order, ``order`` are the places here; ``back`` is its inverse.
    """

    abilities = frozenset(STATE_ABILITIES)
    takes_many_states = True
    model: RobotModel
    order: np.ndarray
    _drive: DriveData

    @cached_property
    def back(self) -> np.ndarray:
        """Places of these coordinates in the robot's order (n,)."""
        return np.argsort(self.order)

    def mass_matrix(self, q: np.ndarray) -> np.ndarray:
        """M(q), shape (n, n)."""
        masses = self.model.mass_matrix(self._in_order(q))[:, self.back][:, :, self.back]
        return masses.reshape(*q.shape, q.shape[-1])

    def bias(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Coriolis and centrifugal force, shape (n,)."""
        forces = self.model.bias(self._in_order(q), self._in_order(v))
        return forces[:, self.back].reshape(q.shape)

    def generalized_force(self, t: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Drive, meshes, friction and gravity at time t [s], shape (n,). Raises InputError."""
        return self._drive_model(self.model.generalized_force, t, q, v)

    def acceleration(self, t: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """q'' at time t [s], shape (n,). Raises InputError where M cannot be inverted."""
        return self._drive_model(self.model.acceleration, t, q, v)

    def driving_torques(self, time: np.ndarray, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Output-side torques (states, joints) [N m], [N] of the motors at time (states,) [s].

        q, v (states, n): in the robot's order.
        """
        joints = len(self._drive.gains)
        return torques_along(self._drive, time, q[:, :joints], v[:, :joints])

    def _drive_model(
        self, answer: Callable[..., np.ndarray], t: float, q: np.ndarray, v: np.ndarray
    ) -> np.ndarray:
        """What a function of the model answers under the motors' torques at time t [s]."""
        time, at, rate = np.atleast_1d(t), self._in_order(q), self._in_order(v)
        with require_regular(self.model.robot):
            values = answer(time, at, rate, self.driving_torques(time, at, rate))
        return values[:, self.back].reshape(q.shape)

    def _in_order(self, values: np.ndarray) -> np.ndarray:
        """The values of one state, or of many, in the robot's order (states, n)."""
        return np.atleast_2d(values)[:, self.order]

"""A planar arm's model by an engine's model of the robot that the arm is."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from crosscheck.models.arm.arm import Arm
from crosscheck.models.arm.layout import geared_layout, rigid_layout
from crosscheck.models.experiment.drive import drive_data
from crosscheck.models.experiment.scenario import Scenario, Switches
from crosscheck.models.interface import STATE_ABILITIES, Model
from crosscheck.models.robot.planar import build_level_robots
from crosscheck.models.robot.start import start_state

if TYPE_CHECKING:
    from crosscheck.models.robot.interface import RobotModel
    from crosscheck.models.robot.robot import Level, Robot


class ArmModel(Model):
    """The arm as a robot in the layout's coordinates, which are the robot's in another order.

    ``level`` is one of ``build_level_robots``. Of the robot's coordinates in their order, ``order``
    are the places in the layout; ``_back`` is its inverse. ``model`` is the engine's of the robot,
    of which M and bias are.
    """

    abilities = frozenset(STATE_ABILITIES)
    level: ClassVar[str]
    model: RobotModel

    def __init__(
        self, arm: Arm, scenario: Scenario, chosen_switches: Switches | None = None
    ) -> None:
        super().__init__(arm, scenario, chosen_switches)
        is_geared = self.level == "geared"
        self.layout = geared_layout(arm, self.switches) if is_geared else rigid_layout(arm)
        displaced = [not coordinate.is_angle for coordinate in self.layout.coordinates]
        self.order = np.argsort(displaced, kind="stable")
        self._back = np.argsort(self.order)
        self._drive = drive_data(scenario, len(arm.joints))

    def find_robot(self) -> tuple[Robot, Level]:
        """The robot that the arm is, its planets lumped or free as the switch says, and its level.

        Raises InputError.
        """
        robot, level = build_level_robots(self.arm)[self.level]
        free = self.switches.planets == "free"
        stages = [replace(stage, has_free_planets=free) for stage in robot.stages]
        return replace(robot, stages=tuple(stages)), level

    def mass_matrix(self, q: np.ndarray) -> np.ndarray:
        """M(q), shape (n, n)."""
        masses = self.model.mass_matrix(self._in_order(q))[:, self._back][:, :, self._back]
        return masses.reshape(*q.shape, q.shape[-1])

    def bias(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Coriolis and centrifugal force, shape (n,)."""
        forces = self.model.bias(self._in_order(q), self._in_order(v))
        return forces[:, self._back].reshape(q.shape)

    def _in_order(self, values: np.ndarray) -> np.ndarray:
        """The values of one state, or of many, in the robot's order (states, n)."""
        return np.atleast_2d(values)[:, self.order]

    def start(self) -> tuple[np.ndarray, np.ndarray]:
        """Coordinates and rates (n,) of the scenario's start, which are the robot's."""
        q, v = start_state(*self.find_robot(), self.scenario)
        return q[self._back], v[self._back]

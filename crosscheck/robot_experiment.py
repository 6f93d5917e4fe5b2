"""A robot's model in an experiment, and its runs."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from crosscheck.analytic.robot.springs import largest_stable_step
from crosscheck.models.abilities import STATE_ABILITIES
from crosscheck.models.experiment.drive import drive_data
from crosscheck.models.experiment.scenario import Scenario
from crosscheck.models.loading import require_fit
from crosscheck.models.robot.driven import DrivenRobot
from crosscheck.models.robot.integration import require_regular
from crosscheck.models.robot.interface import RobotModel
from crosscheck.models.robot.start import start_state
from crosscheck.models.robot.trajectory import build_robot_trajectory

if TYPE_CHECKING:
    import xarray as xr


class RobotExperiment(DrivenRobot):
    """A robot's model in an experiment, in the robot's own coordinates.

    Args:
        model: The robot's model, by an engine at a level.
        scenario: The experiment; its lists of one value per joint must fit the robot.

    Raises:
        InputError: Robot and scenario do not fit each other.
    """

    abilities = frozenset((*STATE_ABILITIES, "simulate", "precise"))

    def __init__(self, model: RobotModel, scenario: Scenario) -> None:
        require_fit(scenario, model.robot)
        self.model, self.scenario, robot = model, scenario, model.robot
        self.name = f"{model.name}:{model.level}"
        self.order = np.arange(len(self.coordinates))
        self._drive = drive_data(scenario, len(robot.coordinates), robot.motors)

    def __repr__(self) -> str:
        """Which model it is, of what."""
        title = f"Model {self.name} of {self.model.robot.name}, experiment {self.scenario.name}"
        return f"{title}\ncoordinates: {', '.join(self.coordinates)}"

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Names of the coordinates (n,): free joints, then displacements of meshes."""
        return tuple(self.model.robot.state_names(self.model.level))

    def inverse_dynamics(self, q: np.ndarray, v: np.ndarray, a: np.ndarray) -> np.ndarray:
        """Generalized forces (states, n) of a motion, whatever the scenario's drive."""
        return self.model.inverse_dynamics(q, v, a)

    def start(self) -> tuple[np.ndarray, np.ndarray]:
        """Coordinates and rates (n,) of the scenario's start."""
        return start_state(self.model.robot, self.model.level, self.scenario)

    def simulate(self) -> xr.Dataset:
        """The run by the scenario's fixed steps. Raises Diverged, InputError."""
        return self._make_trajectory(*self.model.integrate(self.scenario))

    def precise(self, rtol: float) -> xr.Dataset:
        """The run by adaptive steps that end at contacts. Raises CannotDo, Diverged, InputError."""
        return self._make_trajectory(*self.model.precise(self.scenario, rtol))

    def largest_stable_step(self) -> float:
        """Largest step [s] with which fixed steps stay stable. Raises InputError."""
        with require_regular(self.model.robot):
            return largest_stable_step(self.model, self.scenario)

    def _make_trajectory(self, q: np.ndarray, v: np.ndarray) -> xr.Dataset:
        with require_regular(self.model.robot):
            return build_robot_trajectory(self.model, self.scenario, q, v)

"""The interface of every model of a robot, for many states at once."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import ClassVar

import numpy as np

from crosscheck.models.errors import CannotDo, Diverged
from crosscheck.models.experiment.drive import drive_data, torques_along
from crosscheck.models.experiment.integration import integrate_scenario
from crosscheck.models.experiment.scenario import Scenario
from crosscheck.models.interface import require_finite
from crosscheck.models.robot.robot import Level, Robot
from crosscheck.models.robot.start import start_state
from crosscheck.models.trajectory import recorded_times


class RobotModel(ABC):
    """Equations of motion M q'' + bias + gravity + meshes + friction = torques.

    q, v and a are (states, n): the robot's free coordinates in rad or m, then, at the level geared,
    x [m] of each rotor's mesh and x_sp, x_pr [m] of each planetary stage. Torques of motors are
    (states, free) in N m or N at the joints: a rotor that has a mesh, or a sun, gets them over its
    ratio, if its joint is free. ``drive`` (free, n): the generalized forces of each motor's torque.
    """

    name: str
    takes_many_states: ClassVar[bool] = True

    def __init__(self, robot: Robot, level: Level) -> None:
        self.robot, self.level = robot, level
        self.drive = np.eye(len(robot.coordinates))

    @abstractmethod
    def mass_matrix(self, q: np.ndarray) -> np.ndarray:
        """Mass matrix M (states, n, n)."""

    @abstractmethod
    def bias(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Coriolis and centrifugal torques (states, n)."""

    @abstractmethod
    def gravity(self, q: np.ndarray) -> np.ndarray:
        """Torques that hold the weights (states, n)."""

    @abstractmethod
    def inverse_dynamics(self, q: np.ndarray, v: np.ndarray, a: np.ndarray) -> np.ndarray:
        """Generalized forces that a motion needs besides its meshes', with friction (states, n)."""

    @abstractmethod
    def forward_dynamics(self, q: np.ndarray, v: np.ndarray, torques: np.ndarray) -> np.ndarray:
        """Accelerations under torques of motors, meshes' forces and friction (states, n)."""

    def acceleration(
        self, t: np.ndarray, q: np.ndarray, v: np.ndarray, torques: np.ndarray
    ) -> np.ndarray:
        """The same at times t (states,) [s], on which meshes' laws of an engine may depend."""
        return self.forward_dynamics(q, v, torques)

    def generalized_force(
        self, t: np.ndarray, q: np.ndarray, v: np.ndarray, torques: np.ndarray
    ) -> np.ndarray:
        """Torques of motors, meshes, friction and weights at times t [s] (states, n)."""
        return torques @ self.drive - self.inverse_dynamics(q, v, 0 * q) + self.bias(q, v)

    @abstractmethod
    def energy(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Kinetic energy and that of the weights (states,) [J], which is 0 at the base's origin."""

    @abstractmethod
    def momentum(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Linear, then angular about the base's origin (states, 6), of bodies and spinning rotors.

        Armature is no body: at that level there is the links' alone.
        """

    def stage_forces(self, q: np.ndarray) -> np.ndarray:
        """Elastic forces of every planet's meshes (states, meshes) [N] at the level geared.

        Stage by stage, planet by planet, the sun's before the ring's. Raises CannotDo.
        """
        raise CannotDo(f"{self.name} has no forces of single planets")

    def integrate(self, scenario: Scenario) -> tuple[np.ndarray, np.ndarray]:
        """Coordinates and rates (records, n) of a run by fixed steps of classical Runge-Kutta.

        An engine whose accelerations are those of its own integrator may override it. Raises
        Diverged.
        """
        free, name = len(self.robot.coordinates), f"{self.name}:{self.level}"
        drive = drive_data(scenario, free, self.robot.motors)
        start = start_state(self.robot, self.level, scenario)

        def acceleration(t: float, at: np.ndarray, rate: np.ndarray) -> np.ndarray:
            torques = torques_along(drive, np.array([t]), at[None, :free], rate[None, :free])
            try:
                return self.forward_dynamics(at[None], rate[None], torques)[0]
            except np.linalg.LinAlgError:
                raise Diverged(name, t) from None

        q, v = integrate_scenario(acceleration, start, scenario)
        require_finite(name, recorded_times(scenario), q, v)
        return q, v

    def precise(self, scenario: Scenario, rtol: float) -> tuple[np.ndarray, np.ndarray]:
        """The same by adaptive steps that end where contacts change. Raises CannotDo, Diverged."""
        raise CannotDo(f"{self.name} has no precise run of robots")

    @abstractmethod
    def tip(self, q: np.ndarray) -> np.ndarray:
        """Position of the origin of the robot's tip, in the base's frame (states, 3) [m]."""

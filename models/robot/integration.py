"""Runs of a robot: fixed steps of the classical Runge-Kutta method, the same for every model."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

import numpy as np

from crosscheck.models.errors import InputError
from crosscheck.models.experiment.integration import integrate_steps
from crosscheck.models.robot.interface import RobotModel
from crosscheck.models.robot.robot import Robot

FASTEST = 1e4  # [rad/s] or [m/s]: beyond it a run has diverged
Torques = Callable[[float], np.ndarray]  # torques (runs, n) at a time since the start


def integrate(
    model: RobotModel, q: np.ndarray, v: np.ndarray, torques: Torques, seconds: float, steps: int
) -> tuple[np.ndarray, np.ndarray]:
    """Coordinates and rates (runs, n) after so many seconds, infinite where a run diverged.

    Raises InputError for a robot whose mass matrix cannot be inverted.
    """
    alive, step = np.ones(len(q), dtype=bool), seconds / steps

    def slope(given: np.ndarray, at: np.ndarray, rate: np.ndarray) -> np.ndarray:
        accelerations = np.zeros_like(at)
        with require_regular(model.robot), np.errstate(over="ignore", invalid="ignore"):
            accelerations[alive] = model.forward_dynamics(at[alive], rate[alive], given[alive])
        return accelerations

    last = torques(0.0)

    def given(number: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        nonlocal last
        first, half, last = last, torques((number + 0.5) * step), torques((number + 1) * step)
        return first, half, last

    for _, after in zip(range(steps), integrate_steps(slope, given, q, v, step), strict=False):
        q, v = after
        alive &= (np.abs(v) <= FASTEST).all(axis=1)
        if not alive.any():
            break
    return np.where(alive[:, None], q, np.inf), np.where(alive[:, None], v, np.inf)


@contextmanager
def require_regular(robot: Robot) -> Iterator[None]:
    """Raise InputError where the robot's mass matrix turns out to be singular."""
    try:
        yield
    except np.linalg.LinAlgError:
        raise conditioning_error(robot) from None


def conditioning_error(robot: Robot) -> InputError:
    """The error for a robot whose mass matrix cannot be inverted."""
    allowed = "masses and inertias are too different for 16 digits: M cannot be inverted"
    return InputError(robot.name, "", None, allowed)

"""Runs of a robot: fixed steps of the classical Runge-Kutta method, the same for every model."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from crosscheck.models.errors import InputError
from crosscheck.models.robot.interface import RobotModel
from crosscheck.models.robot.robot import Robot

FASTEST = 1e4  # [rad/s] or [m/s]: beyond it a run has diverged
Torques = Callable[[float], np.ndarray]  # of the time since the start, (runs, n)


def integrate(
    model: RobotModel, q: np.ndarray, v: np.ndarray, torques: Torques, seconds: float, steps: int
) -> tuple[np.ndarray, np.ndarray]:
    """Coordinates and rates (runs, n) after so many seconds, infinite where a run diverged.

    Raises InputError for a robot whose mass matrix cannot be inverted.
    """
    alive, step = np.ones(len(q), dtype=bool), seconds / steps

    def slope(given: np.ndarray, at: np.ndarray, rate: np.ndarray) -> np.ndarray:
        accelerations = np.zeros_like(at)
        try:
            accelerations[alive] = model.forward_dynamics(at[alive], rate[alive], given[alive])
        except np.linalg.LinAlgError:
            raise conditioning_error(model.robot) from None
        return accelerations

    first = torques(0.0)
    for number in range(steps):
        half, last = torques((number + 0.5) * step), torques((number + 1) * step)
        q, v = classical_step(slope, (first, half, last), q, v, step)
        alive &= (np.abs(v) < FASTEST).all(axis=1)
        q, v = np.where(alive[:, None], q, 0.0), np.where(alive[:, None], v, 0.0)
        first = last
        if not alive.any():
            break
    return np.where(alive[:, None], q, np.inf), np.where(alive[:, None], v, np.inf)


def classical_step(
    acceleration: Callable[[Any, np.ndarray, np.ndarray], np.ndarray],
    at: tuple[Any, Any, Any],
    q: np.ndarray,
    v: np.ndarray,
    h: float,
) -> tuple[np.ndarray, np.ndarray]:
    """q and v after a step h [s] of the classical Runge-Kutta method, of fourth order.

    at: what the acceleration is a function of beside q and v, at beginning, middle and end.
    """
    begin, middle, end = at
    a1 = acceleration(begin, q, v)
    v2 = v + h / 2 * a1
    a2 = acceleration(middle, q + h / 2 * v, v2)
    v3 = v + h / 2 * a2
    a3 = acceleration(middle, q + h / 2 * v2, v3)
    v4 = v + h * a3
    a4 = acceleration(end, q + h * v3, v4)
    return q + h / 6 * (v + 2 * v2 + 2 * v3 + v4), v + h / 6 * (a1 + 2 * a2 + 2 * a3 + a4)


def conditioning_error(robot: Robot) -> InputError:
    """The error for a robot whose mass matrix cannot be inverted."""
    allowed = "masses and inertias are too unlike for 16 digits: M cannot be inverted"
    return InputError(robot.name, "", None, allowed)

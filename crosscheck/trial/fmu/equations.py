"""Equations out of an FMU's accelerations: of a rigid arm also M, bias and force."""

from __future__ import annotations

import numpy as np

from crosscheck.models.arm.arm import Arm
from crosscheck.trial.coordinates.frame import frame_of
from crosscheck.trial.fmu.mapping import MappedUnit
from crosscheck.trial.fmu.unit import acceleration_of
from crosscheck.trial.input.equations import Equations

PUSH_N_M = 1e3  # by which torques are told from weight


def fmu_equations(unit: MappedUnit, arm: Arm) -> Equations:
    """The equations of a unit for Model Exchange, which runs in workers alone.

    With a torque on each coordinate M is what resists them; else there is the acceleration alone.
    """
    frame = frame_of(unit.coordinates, arm)
    theta = frame.jacobian(np.zeros(len(frame.names)))[frame.layout.theta]
    joints, size = theta.shape
    if joints != size:
        return Equations(
            acceleration=lambda t, x, v, torque: acceleration_of(unit, t, x, v, torque),
            coordinates=unit.coordinates,
        )

    def mass_matrix(x: np.ndarray) -> np.ndarray:
        still, gained = np.zeros(size), np.zeros((size, joints))
        for joint, push in enumerate(PUSH_N_M * np.eye(joints)):
            ahead, back = (acceleration_of(unit, 0.0, x, still, sign * push) for sign in (1, -1))
            gained[:, joint] = (ahead - back) / (2 * PUSH_N_M)
        return theta.T @ np.linalg.inv(gained)

    def bias(x: np.ndarray, v: np.ndarray) -> np.ndarray:
        """What is even in the rates and vanishes with them: weight and friction do not."""
        idle = np.zeros(joints)
        ahead, back, still = (acceleration_of(unit, 0.0, x, s * v, idle) for s in (1, -1, 0))
        return mass_matrix(x) @ (still - (ahead + back) / 2)

    def force(t: float, x: np.ndarray, v: np.ndarray, torque: np.ndarray) -> np.ndarray:
        return mass_matrix(x) @ acceleration_of(unit, t, x, v, torque) + bias(x, v)

    return Equations(
        mass_matrix=mass_matrix,
        bias=bias,
        force=force,
        coordinates=unit.coordinates,
        level=unit.level,
    )

"""The drive law as numbers: the same experiment for every model."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from crosscheck.models.experiment import scenario as experiments
from crosscheck.models.experiment.scenario import Scenario, expand_to_joints

CONSTANT, PD, SINE_OF_TIME, SINE_OF_SQRT_TIME, TABLE = range(5)
Signal = Any  # float or array


class DriveData(NamedTuple):
    """A drive law as flat arrays.

    code: one of the constants above. gains (joints, 3): per joint what the law needs.
    table_time (rows,) [s] and table_torque (joints, rows) [N m]: the table, else one row of zeros.
    """

    code: int
    gains: np.ndarray
    table_time: np.ndarray
    table_torque: np.ndarray


def drive_data(scenario: Scenario, joints: int, motors: Sequence[int] | None = None) -> DriveData:
    """Flatten the scenario's drive for this many joints; motors: those that have one, if not all.

    The others have gains and torques of 0.
    """
    drive, driven = scenario.drive, list(range(joints) if motors is None else motors)
    table_time, table_torque = np.zeros(1), np.zeros((joints, 1))
    columns: tuple[float | tuple[float, ...], ...] = ()
    if isinstance(drive, experiments.ConstantDrive):
        code, columns = CONSTANT, (drive.torque_N_m,)
    elif isinstance(drive, experiments.PdDrive):
        code = PD
        columns = (drive.target_rad, drive.proportional_N_m_per_rad, drive.derivative_N_m_s_per_rad)
    elif isinstance(drive, experiments.SinusoidDrive):
        code = SINE_OF_TIME if drive.argument == "time" else SINE_OF_SQRT_TIME
        columns = (drive.amplitude_N_m, drive.rate_rad_per_s)
    else:
        code = TABLE
        table_time, table_torque = np.array(drive.time_s), np.zeros((joints, len(drive.time_s)))
        table_torque[driven] = drive.torque_N_m
    gains = np.zeros((joints, 3))
    for column, value in enumerate(columns):
        gains[driven, column] = expand_to_joints(value, len(driven))
    return DriveData(code, gains, table_time, table_torque)


def joint_torque(
    code: int,
    gains: np.ndarray,
    table_time: np.ndarray,
    table_torque: np.ndarray,
    t: Signal,
    theta: Signal,
    theta_dot: Signal,
) -> Signal:
    """Output-side torque [N m] of one joint at time t [s], angle [rad] and rate [rad/s].

    Each is a number, or an array over times. gains (3,) and table_torque (rows,) are the joint's
    rows of DriveData. An engine may compile it.
    """
    if code == CONSTANT:
        return gains[0]
    if code == PD:
        return gains[1] * (gains[0] - theta) - gains[2] * theta_dot
    if code == SINE_OF_TIME:
        return gains[0] * np.sin(gains[1] * t)
    if code == SINE_OF_SQRT_TIME:
        return gains[0] * np.sin(gains[1] * np.sqrt(t))
    return np.interp(t, table_time, table_torque)


def torques_along(
    drive: DriveData, time: np.ndarray, theta: np.ndarray, theta_dot: np.ndarray
) -> np.ndarray:
    """Output-side torques [N m] at time (times,) [s] by angles and rates, all (times, joints)."""
    torques = np.empty(theta.shape)
    joints = zip(drive.gains, drive.table_torque, theta.T, theta_dot.T, strict=True)
    for joint, (gains, table, *moving) in enumerate(joints):
        law = drive.code, gains, drive.table_time, table
        torques[:, joint] = joint_torque(*law, time, *moving)
    return torques


def torques_at(drive: DriveData, t: float, theta: np.ndarray, theta_dot: np.ndarray) -> np.ndarray:
    """Output-side torques [N m] of one state at time t [s], (joints,) as angles and rates."""
    return torques_along(drive, np.array([t]), theta[None], theta_dot[None])[0]


def table_torques(drive: DriveData, time: np.ndarray | float) -> np.ndarray:
    """Output-side torques [N m] of a table at time (...,) [s], shape (..., joints)."""
    columns = [np.interp(time, drive.table_time, torque) for torque in drive.table_torque]
    return np.stack(columns, axis=-1)

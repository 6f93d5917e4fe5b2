"""Recordings of robots in SI units at the joints."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from crosscheck.models.errors import InputError
from crosscheck.recordings.record import LEAST_MOTION, Record, require_rising

LEAST_ROWS = 64
LONGEST_GAP = 20.0  # times the mean step


@dataclass(frozen=True)
class Recording:
    """A motion of a robot with its torques.

    time (rows,) [s]; position (rows, n) [rad or m]; motor_torque: before the gears, and
    joint_torque: behind them, both (rows, n) at the joints [N m or N], None where not measured;
    recorded: rows of a long recording before its rate was halved; None where all are here.
    """

    where: str
    time: np.ndarray
    position: np.ndarray
    motor_torque: np.ndarray | None
    joint_torque: np.ndarray | None
    recorded: int | None = None

    def __post_init__(self) -> None:
        """Raise InputError for too few rows, times no filter can follow, or rows of nothing."""
        rows = len(self.time)
        if rows < LEAST_ROWS:
            raise InputError(
                self.where, "", None, f"has {rows} rows; must be at least {LEAST_ROWS}"
            )
        require_even_enough(self.where, self.time)
        if np.ptp(self.position, axis=0).max() < LEAST_MOTION:
            allowed = f"is the same in every row; a joint must move by {LEAST_MOTION:g} at least"
            raise InputError(self.where, "position", None, allowed)
        torques = {"motor_torque": self.motor_torque, "joint_torque": self.joint_torque}
        for name, torque in torques.items():
            if torque is not None and not np.nan_to_num(torque).any():
                raise InputError(self.where, name, None, "is 0 in every row: not measured?")

    @property
    def rows(self) -> int:
        """How many were recorded."""
        return self.recorded or len(self.time)

    @property
    def step(self) -> float:
        """Mean time [s] between rows."""
        return float((self.time[-1] - self.time[0]) / (len(self.time) - 1))


def require_even_enough(where: str, time: np.ndarray) -> None:
    """Raise InputError for times that fall or have gaps, which no filter can follow."""
    require_rising(where, "time", time)
    steps = np.diff(time)
    if steps.size and steps.max() > LONGEST_GAP * steps.mean():
        row = int(steps.argmax()) + 2
        reason = f"is {steps.max():.3g} s after the row before; cut the record where it has gaps"
        raise InputError(where, f"time, row {row}", float(time[row - 1]), reason)


def convert_record(record: Record) -> Recording:
    """A record of torques before the gears, as a recording. Raises InputError without torques."""
    if record.torques is None:
        reason = "has no torques; columns must be torque_1_N_m, ..."
        raise InputError(record.where, "", None, reason)
    return Recording(record.where, record.time, record.angles, record.torques, None)

"""A trajectory's file from outside: its arm, and what of its run is drawn."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple, TypeVar

import h5py
import numpy as np
from pydantic import ValidationError

from crosscheck.models.arm.arm import Arm, Planetary
from crosscheck.models.arm.quantities import Data
from crosscheck.models.experiment.scenario import Switches, switches
from crosscheck.models.files import LARGEST_FILE
from crosscheck.models.robot.file import RobotSource
from crosscheck.models.robot.robot import Robot
from crosscheck.models.trajectory import SCHEMA_VERSION
from crosscheck.studies.batches.netcdf_file import NetcdfFile, use_file

LONGEST_ARM, LONGEST_ROBOT = 1_000_000, 2 * LARGEST_FILE  # characters
Record = TypeVar("Record", bound=Data)
DRAWN_SIGNALS = {
    "theta": 2,
    "theta_dot": 2,
    "x_sp": 3,
    "x_pr": 3,
    "F_sp": 3,
    "F_pr": 3,
}  # by dimensions


class Run(NamedTuple):
    """A run to be drawn.

    time (times,) [s], equally spaced; signals: theta (times, joints) [rad] and theta_dot [rad/s],
    which the mesh phase by omega_t needs; displacements [m] and forces [N] of the meshes (times,
    joints, planets), where the model has any; laws: switches of the mesh phase.
    """

    model: str
    arm: Arm
    time: np.ndarray
    signals: dict[str, np.ndarray]
    laws: Switches = switches()


class RobotRun(NamedTuple):
    """A robot's run to be drawn: theta (times, joints) [rad] or [m] at equally spaced times [s]."""

    model: str
    robot: Robot
    time: np.ndarray
    theta: np.ndarray


def read_run(path: Path) -> Run | RobotRun:
    """The run that a file holds; HDF5 reads it in another process. Raises InputError."""
    return use_file(path, TrajectoryFile.read_run, TrajectoryFile)


class TrajectoryFile(NetcdfFile):
    """A file as `crosscheck simulate` writes it."""

    description = "trajectory"

    def __init__(self, path: Path, file: h5py.File) -> None:
        super().__init__(path, file)
        for name in ("theta", "time", "joint"):
            self._require(name in file, f"has no {name}")
        self.require_version(SCHEMA_VERSION)

    def read_run(self) -> Run | RobotRun:
        """The run that the file holds. Raises InputError."""
        return self._read_robot_run() if "robot" in self.file.attrs else self._read_arm_run()

    def _read_robot_run(self) -> RobotRun:
        self._require(self.dims("theta") == ("time", "joint"), "theta is not over time, joint")
        data, robot = (
            self.dataset(["theta"]),
            self._read_record("robot", RobotSource, LONGEST_ROBOT).build(),
        )
        time, theta = self._even_times(data["time"].values), data["theta"].values
        self._require(theta.shape[1] == len(robot.joints), "joints are not the robot's")
        self._require(bool(np.isfinite(theta).all()), "theta is not finite")
        return RobotRun(self._text(self.file, "model"), robot, time, theta)

    def _read_arm_run(self) -> Run:
        names = [name for name in DRAWN_SIGNALS if name in self.file]
        for name in names:
            dims = ("time", "joint", "planet")[: DRAWN_SIGNALS[name]]
            self._require(self.dims(name) == dims, f"{name} is not over {', '.join(dims)}")
        data, arm = self.dataset(names), self._read_record("arm", Arm, LONGEST_ARM)
        time = self._even_times(data["time"].values)
        signals = {name: data[name].values for name in names}
        self._require(signals["theta"].shape[1] == len(arm.joints), "joints are not the arm's")
        geared = [n for n, joint in enumerate(arm.joints) if isinstance(joint, Planetary)]
        for name, values in signals.items():
            signal = values if values.ndim == 2 else values[:, geared, 0]
            self._require(bool(np.isfinite(signal).all()), f"{name} is not finite")
        laws = self._read_record("switches", Switches, LONGEST_ARM)
        has_phase_rate = laws.phase == "angle" or "theta_dot" in signals
        self._require(
            has_phase_rate, "has no theta_dot, by which its switches count the mesh phase"
        )
        return Run(self._text(self.file, "model"), arm, time, signals, laws)

    def _even_times(self, time: np.ndarray) -> np.ndarray:
        """The times [s], which must be equally spaced. Raises InputError."""
        self._require(time.size > 1, "has fewer than two times")
        steps = np.diff(time)
        self._require(bool((steps > 0).all()), "times do not increase")
        even = np.ptp(steps) <= 1e-6 * steps.mean()
        self._require(bool(even), "times are not equally spaced")
        return time

    def _read_record(self, name: str, record: type[Record], most: int) -> Record:
        """The record of an attribute, JSON of so many characters at most. Raises InputError."""
        text = self.file.attrs.get(name)
        self._require(isinstance(text, str) and len(text) <= most, f"has no {name}")
        try:
            return record.model_validate_json(text)
        except ValidationError as error:
            first = error.errors()[0]
            why = f"{'.'.join(map(str, first['loc']))}: {first['msg']}"
            self._require(False, f"its {name} cannot be used: {why}")
            raise

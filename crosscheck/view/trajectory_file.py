"""A trajectory's file from outside: its arm, and the signals of its run that are drawn."""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple, TypeVar

import h5py
import numpy as np
from pydantic import ValidationError

from crosscheck.models.arm.arm import Arm
from crosscheck.models.arm.quantities import Data
from crosscheck.models.errors import rephrase
from crosscheck.models.experiment.scenario import Switches, switches
from crosscheck.models.files import LARGEST_FILE
from crosscheck.models.mechanism import Mechanism
from crosscheck.models.robot.file import RobotSource
from crosscheck.models.trajectory import SCHEMA_VERSION
from crosscheck.studies.batches.netcdf_file import NetcdfFile, use_file

LONGEST_ARM, LONGEST_ROBOT = 1_000_000, 2 * LARGEST_FILE  # characters
Record = TypeVar("Record", bound=Data)
# By how many dimensions they have.
DRAWN_SIGNALS = {"theta": 2, "theta_dot": 2, "x_sp": 3, "x_pr": 3, "F_sp": 3, "F_pr": 3}


class Run(NamedTuple):
    """A run to be drawn.

    time (times,) [s], equally spaced; signals: theta (times, joints) [rad], [m]; of an arm also
    theta_dot [rad/s], which the mesh phase by omega_t needs, and displacements [m] and forces [N]
    of the meshes (times, joints, planets), where the model has any; laws: switches of the mesh
    phase.
    """

    model: str
    mechanism: Any
    time: np.ndarray
    signals: dict[str, np.ndarray]
    laws: Switches = switches()


def read_run(path: Path) -> Run:
    """The run that a file holds; HDF5 reads it in another process. Raises InputError."""
    return use_file(path, TrajectoryFile.read_run, TrajectoryFile)


class TrajectoryFile(NetcdfFile):
    """A file as `crosscheck simulate` writes it."""

    description, command = "trajectory", "simulate"

    def __init__(self, path: Path, file: h5py.File) -> None:
        super().__init__(path, file)
        for name in ("theta", "time", "joint"):
            self._require(name in file, f"has no {name}")
        self.require_version(SCHEMA_VERSION)

    def read_run(self) -> Run:
        """The run that the file holds. Raises InputError."""
        is_of_robot = "robot" in self.file.attrs
        drawn = {"theta": DRAWN_SIGNALS["theta"]} if is_of_robot else DRAWN_SIGNALS
        names = [name for name in drawn if name in self.file]
        for name in names:
            dims = ("time", "joint", "planet")[: drawn[name]]
            self._require(self.content[name].dims == dims, f"{name} is not over {', '.join(dims)}")
        data, mechanism, laws = self.read_variables(names), self._read_mechanism(), switches()
        time, signals = self._even_times(data["time"].values), {n: data[n].values for n in names}
        fits = signals["theta"].shape[1] == len(mechanism.joints)
        self._require(fits, f"joints are not the {mechanism.section}'s")
        geared = np.flatnonzero([] if is_of_robot else mechanism.planet_counts)
        for name, values in signals.items():
            signal = values if values.ndim == 2 else values[:, geared, 0]
            self._require(bool(np.isfinite(signal).all()), f"{name} is not finite")
        if not is_of_robot:
            laws = self._read_record("switches", Switches, LONGEST_ARM)
            has_phase_rate = laws.phase == "angle" or "theta_dot" in signals
            reason = "has no theta_dot, by which its switches count the mesh phase"
            self._require(has_phase_rate, reason)
        return Run(self._text(self.file, "model"), mechanism, time, signals, laws)

    def _read_mechanism(self) -> Mechanism:
        """The arm or robot that the run is of. Raises InputError."""
        if "robot" in self.file.attrs:
            return self._read_record("robot", RobotSource, LONGEST_ROBOT).build()
        return self._read_record("arm", Arm, LONGEST_ARM)

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
            why = f"{'.'.join(map(str, first['loc']))}: {rephrase(first['msg'])}"
            self._require(False, f"its {name} cannot be used: {why}")
            raise

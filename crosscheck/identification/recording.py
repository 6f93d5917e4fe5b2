"""Recordings of robots in SI units at the joints, and the CSV tables that they stand in."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from crosscheck.models.errors import InputError
from crosscheck.models.inputs import read_input
from crosscheck.recordings.csv_table import decode_csv, parse_rows
from crosscheck.recordings.record import LARGEST_FILE, Record

LEAST_ROWS = 64
LONGEST_GAP = 20.0  # times the mean step


@dataclass(frozen=True)
class Recording:
    """A motion of a robot with its torques.

    time (rows,) [s]; position (rows, n) [rad or m]; motor_torque: before the gears, and
    joint_torque: behind them, both (rows, n) at the joints [N m or N], None where not measured.
    """

    where: str
    time: np.ndarray
    position: np.ndarray
    motor_torque: np.ndarray | None
    joint_torque: np.ndarray | None

    def __post_init__(self) -> None:
        """Raise InputError for rows that are too few, or times that no filter can follow."""
        rows = len(self.time)
        if rows < LEAST_ROWS:
            raise InputError(
                self.where, "", None, f"has {rows} rows; must be at least {LEAST_ROWS}"
            )
        steps = np.diff(self.time)
        if not (steps > 0).all():
            row = int(np.flatnonzero(~(steps > 0))[0]) + 2
            field, value = f"time, row {row}", float(self.time[row - 1])
            raise InputError(self.where, field, value, f"must be after {self.time[row - 2]:g}")
        if steps.max() > LONGEST_GAP * self.step:
            row = int(steps.argmax()) + 2
            reason = (
                f"is {steps.max():.3g} s after the row before; cut the record where it has gaps"
            )
            raise InputError(self.where, f"time, row {row}", float(self.time[row - 1]), reason)

    @property
    def step(self) -> float:
        """Mean time [s] between rows."""
        return float((self.time[-1] - self.time[0]) / (len(self.time) - 1))


def convert_record(record: Record) -> Recording:
    """A record of torques before the gears, as a recording. Raises InputError without torques."""
    if record.torques is None:
        reason = "has no torques; columns must be torque_1_N_m, ..."
        raise InputError(record.where, "", None, reason)
    return Recording(record.where, record.time, record.angles, record.torques, None)


@dataclass(frozen=True)
class CsvTable:
    """A table of numbers (rows, columns) with names, from a file."""

    where: str
    names: tuple[str, ...]
    values: np.ndarray

    def select(self, columns: Sequence[str]) -> np.ndarray:
        """Columns of these names (rows, columns), of no number where the name is empty.

        Raises InputError for one that is not there.
        """
        for name in filter(None, columns):
            if self.names.count(name) != 1:
                there = ", ".join(self.names)[:300]
                count = "is there twice" if name in self.names else f"is no column; it has {there}"
                raise InputError(self.where, name, None, count)
        measured = [place for place, name in enumerate(columns) if name]
        chosen = np.full((len(self.values), len(columns)), np.nan)
        chosen[:, measured] = self.values[:, [self.names.index(columns[at]) for at in measured]]
        wrong = np.argwhere(~np.isfinite(chosen) & (np.array(columns) != ""))
        if wrong.size:
            row, column = map(int, wrong[0])
            name = columns[column]
            if not np.isfinite(chosen[:, column]).any():
                raise InputError(self.where, name, None, "is no number in any row: not measured?")
            raise InputError(self.where, f"{name}, row {row + 1}", None, "must be a number")
        return chosen


def read_table(path: Path) -> CsvTable:
    """The table in a CSV file: a line of names, commas or semicolons between columns.

    Where semicolons separate, a comma may stand before decimals. Raises InputError.
    """
    where = str(path)
    head, rest = decode_csv(where, read_input(path, LARGEST_FILE))
    separator = next((each for each in (";", "\t", ",") if each in head), ",")
    names = tuple(name.strip().strip('"') for name in head.split(separator))
    if all(re.fullmatch(r"[-+.,\deE]+", name) for name in names):
        raise InputError(where, "line 1", None, "holds numbers; must hold the columns' names")
    if separator != ",":
        rest = rest.replace(",", ".")
    values = parse_rows(where, names, rest, separator)
    return CsvTable(where, names, values.reshape(-1, len(names)))

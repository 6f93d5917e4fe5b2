"""Recorded motions, opened here alone: CSV, MAT, HDF5, NetCDF, ROS bags; units in the names."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from math import pi
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from crosscheck.models.errors import InputError, format_install_command, format_line
from crosscheck.models.inputs import convert_read_errors, doubt_degrees, input_size, read_input
from crosscheck.recordings.csv_table import LARGEST_FILE, open_table
from crosscheck.runner.isolated_reading import TooManyNumbers, read_arrays, read_in_subprocess

READING_S, BAG_S = 60.0, 300.0
BAGS = (".bag", ".db3", ".mcap")
MESSAGE = "sensor_msgs/msg/JointState"
MISSING = f"ROS bags need the package rosbags: {format_install_command('ros')}"
# Factors of a column's units, by the beginning of its name.
UNITS: dict[str, dict[str, float]] = {
    "t": {"s": 1.0, "ms": 1e-3, "us": 1e-6},
    "theta": {"rad": 1.0, "deg": pi / 180, "m": 1.0, "mm": 1e-3},
    "theta_dot": {"rad_per_s": 1.0, "deg_per_s": pi / 180, "rpm": pi / 30}
    | {"m_per_s": 1.0, "mm_per_s": 1e-3},
    "torque": {"N_m": 1.0, "mN_m": 1e-3, "N": 1.0},
}
OF_SLIDES = {"m", "mm", "m_per_s", "mm_per_s", "N"}  # units of joints that slide, and of no others
SIGNALS = ("theta", "theta_dot", "torque")
NUMBERED = re.compile(r"(theta_dot|theta|torque)_(\d+)_(.+)")
TOGETHER = re.compile(r"(theta_dot|theta|torque)_(.+)")
# Usual names of a record's quantities, without units, for `rename` in a message.
LIKELY = {
    "t": re.compile(r"%?(t|time|timestamp|stamp|secs?|seconds)(_\w+)?"),
    "theta_dot": re.compile(r"(dq|qd|q_?dot|v|vel|velocity|rate|omega|dtheta|theta_?dot)_?\d+"),
    "torque": re.compile(r"(tau|torque|effort)_?\d+"),
    "theta": re.compile(r"(q|theta|phi|angle|pos|position|joint)_?\d+"),
}
TRAJECTORY_NAMES = {"time": "t_s", "theta": "theta_rad", "theta_dot": "theta_dot_rad_per_s"}
TRAJECTORY_NAMES |= {"torque": "torque_N_m"}  # as this program's own trajectories call them
# Largest numbers [rad, rad/s, N m] and times [s], as of a start and a drive.
LARGEST = {"theta": 1e4, "theta_dot": 1e4, "torque": 1e9}
NOUNS = {"t": "times", "theta": "angles", "torque": "torques"}
LATEST = 1e10
LEAST_ROWS = 64
LONGEST_GAP = 20.0  # gap over the mean step
GAP = 5.0  # steps over the usual one from which on a step is a gap, and no jitter
LEAST_MOTION = 1e-6  # [rad or m]


@dataclass(frozen=True)
class Record:
    """A motion of a mechanism with its torques.

    time (rows,) [s], rising; position (rows, n) [rad or m]; rates (rows, n), where stated;
    motor_torque: before the gears, and joint_torque: behind them, both (rows, n) at the joints [N m
    or N], None where not measured, no number at joints that have no sensor; notes: sentences on
    what of the file was left out.
    """

    where: str
    time: np.ndarray
    position: np.ndarray
    motor_torque: np.ndarray | None = None
    joint_torque: np.ndarray | None = None
    rates: np.ndarray | None = None
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        """Raise InputError for too few rows, times no filter can follow, or rows of nothing."""
        rows = len(self.time)
        if rows < LEAST_ROWS:
            allowed = f"has {rows} rows; must be at least {LEAST_ROWS}"
            raise InputError(self.where, "", None, allowed)
        require_even_enough(self.where, self.time)
        if np.ptp(self.position, axis=0).max() < LEAST_MOTION:
            allowed = f"is the same in every row; must move by at least {LEAST_MOTION:g} rad or m"
            raise InputError(self.where, "position", None, allowed)
        slopes = np.abs(np.diff(self.position, axis=0)) / np.diff(self.time)[:, None]
        fastest = np.median(slopes, axis=0)
        if not fastest.max() <= LARGEST["theta_dot"]:
            value = float(fastest.max())
            allowed = f"must be at most {LARGEST['theta_dot']:g}: are positions and times in SI?"
            raise InputError(self.where, "slope of position", value, allowed)
        torques = {"motor_torque": self.motor_torque, "joint_torque": self.joint_torque}
        for name, torque in torques.items():
            if torque is not None and not np.nan_to_num(torque).any():
                raise InputError(self.where, name, None, "is 0 in every row: not measured?")

    @property
    def step(self) -> float:
        """Mean time [s] between rows."""
        return float((self.time[-1] - self.time[0]) / (len(self.time) - 1))


def read_record(
    path: Path,
    joints: int,
    topic: str = "",
    named: Sequence[str] = (),
    slides: Collection[int] = (),
    *,
    is_motion: bool = False,
) -> Record:
    """The record in a file. Raises InputError naming file, row, column and what is allowed.

    Columns are `t_s`, `theta_1_rad`, `theta_dot_1_rad_per_s`, `torque_1_N_m` and so on, in other
    units with those at the end; rates and torques may be missing. In MAT, HDF5 and NetCDF files
    they are variables of these names, or `theta_rad` (N, joints) and so on, or those of a
    trajectory of this program. topic, named: of a ROS bag, and its names of the joints; slides:
    numbers, from 1, of the joints that slide; is_motion: whether nobody asks for its torques.
    """
    where = str(path)
    notes: list[str] = []
    if path.is_dir() or path.suffix in BAGS:
        if named and len(named) != joints:
            raise InputError("--joint", "", len(named), f"must be given {joints} times")
        columns, skipped = _read_bag(path, topic, tuple(named))
        if skipped:
            notes.append(f"{skipped:,} messages without any of the joints are left out")
    elif topic or named:
        option, value = ("--topic", topic) if topic else ("--joint", named[0])
        raise InputError(option, value, None, f"is for ROS bags, and {where} is none")
    elif path.suffix == ".csv":
        columns = _read_csv(path)
    else:
        content = read_input(path, LARGEST_FILE)
        columns = read_in_subprocess(where, _read_arrays, where, content, within_s=READING_S)
    file = _FileColumns(where, columns, slides)
    time, tables = file.select("t"), {kind: file.build_table(kind, joints) for kind in SIGNALS}
    angles = tables["theta"]
    if time is None or angles is None:
        by_kind = {"t": time, **tables} | ({"torque": ()} if is_motion else {})
        missing = [kind for kind in NOUNS if by_kind[kind] is None]
        names = (file.allowed_names(kind, None if kind == "t" else 1)[0] for kind in missing)
        nouns = [NOUNS[kind] for kind in missing]
        listed = " or ".join(filter(None, [", ".join(nouns[:-1]), nouns[-1]]))
        reason = f"has no {listed}; columns must be {', '.join(names)}, ..."
        reason += "" if is_motion else ", or a TOML file names them"
        raise InputError(where, "", None, reason + file.suggest_names(missing))
    notes += describe_gaps(time)
    # Publishers that measure no rates or efforts fill them with zeros or with no numbers; a torque
    # may be 0.
    for kind, nothing in (("theta_dot", "rates are 0 or"), ("torque", "torques are")):
        table, show = tables[kind], np.nan_to_num if kind == "theta_dot" else np.isfinite
        if table is not None and not show(table).any():
            notes.append(f"the {nothing} no number in every row and count as not stated")
            tables[kind] = None
    for kind, table in tables.items():
        if table is not None:
            _require_usable(where, kind, time.size, table)
    for number, each in enumerate(angles.T, 1):
        if number not in slides and {"theta_rad", f"theta_{number}_rad"} & set(columns):
            doubt_degrees(where, f"theta_{number}_rad", each, "name it with _deg")
    return Record(
        where, time, angles, tables["torque"], rates=tables["theta_dot"], notes=tuple(notes)
    )


def _read_csv(path: Path) -> dict[str, np.ndarray]:
    """Columns by name; of those that no record has the names alone, whatever they hold."""
    table = open_table(path)
    used = [place for place, name in enumerate(table.names) if _has_known_unit(name)]
    names = [table.names[place] for place in used]
    twice = [name for name, count in Counter(names).items() if count > 1]
    if twice:
        raise InputError(table.where, "line 1", twice[0], "is there twice")
    values = np.concatenate(list(table.read_pieces(used)))
    return dict.fromkeys(table.names, np.empty(0)) | dict(zip(names, values.T, strict=True))


def _has_known_unit(name: str) -> bool:
    """Whether a column's name is that of a quantity of a record with a unit of it."""
    match = NUMBERED.fullmatch(name) or TOGETHER.fullmatch(name) or re.fullmatch("(t)_(.+)", name)
    return match is not None and match[match.lastindex or 0] in UNITS[match[1]]


class _FileColumns(NamedTuple):
    """Columns of a file by name; slides: numbers, from 1, of the joints that slide."""

    where: str
    columns: Mapping[str, np.ndarray]
    slides: Collection[int]

    def allowed_names(self, kind: str, number: int | None) -> list[str]:
        """Names of the column of a kind, with each unit that it may have, the SI unit first."""
        begin, is_slide = _begin_name(kind, number), number in self.slides
        return [f"{begin}_{unit}" for unit in UNITS[kind] if (unit in OF_SLIDES) == is_slide]

    def suggest_names(self, missing: Sequence[str] = ()) -> str:
        """Names that a file's columns may need, as the end of a sentence; missing: their kinds."""
        renamed, others = [], list[str]()
        counts: Counter[str] = Counter()
        for name, kind in self._guess_kinds(missing).items():
            counts[kind] += 1
            si, *rest = self.allowed_names(kind, None if kind == "t" else counts[kind])
            renamed.append(f"{name} to {si}")
            others += rest if counts[kind] == 1 else []
        seen = f"; its columns are {', '.join(self.columns)[:120]}" if self.columns else ""
        by_unit = f", or {', '.join(others)}, by unit" if others else ""
        return f"{seen}: rename {', '.join(renamed)}{by_unit}" if renamed else seen

    def _guess_kinds(self, missing: Sequence[str]) -> dict[str, str]:
        """What columns of other names may be, by their words, or as all that is left of a kind."""
        words = {n: re.split(r"[\s\[(]", n.lower())[0] for n in self.columns}
        words = {name: word for name, word in words.items() if not _has_known_unit(name)}
        kinds = {
            name: next((kind for kind, likely in LIKELY.items() if likely.fullmatch(word)), "")
            for name, word in words.items()
        }
        lost = [kind for kind in missing if kind not in kinds.values()]
        for are_numbered, left in ((False, {"t"} & {*lost}), (True, {*lost} - {"t"})):
            alike = {
                name: words[name].rstrip("0123456789")
                for name, kind in kinds.items()
                if not kind and words[name][-1:].isdigit() == are_numbered
            }
            if len(left) == 1 and len({*alike.values()}) == 1:
                kinds |= dict.fromkeys(alike, left.pop())
        return {name: kind for name, kind in kinds.items() if kind}

    def select(self, kind: str, number: int | None = None) -> np.ndarray | None:
        """The column of a kind in SI units; None where there is none. Raises InputError."""
        begin, allowed = _begin_name(kind, number), self.allowed_names(kind, number)
        there = [unit for unit in UNITS[kind] if f"{begin}_{unit}" in self.columns]
        if len(there) > 1:
            raise self.refuse(begin, f"is there in {' and in '.join(there)}")
        names = " or ".join(allowed)
        if begin in self.columns and not there:
            raise self.refuse(
                begin, f"has no unit in its name; must be {names}{self.suggest_names()}"
            )
        for unit in there:
            name = f"{begin}_{unit}"
            if name not in allowed:
                moves = "slides" if number in self.slides else "turns"
                raise self.refuse(name, f"joint {number} {moves}; must be {names}")
            values = self.columns[name]
            if values.size != max(values.shape, default=1):
                raise self.refuse(name, f"has shape {values.shape}; must be a column")
            return np.ravel(values) * UNITS[kind][unit]
        return None

    def build_table(self, kind: str, joints: int) -> np.ndarray | None:
        """Angles, rates or torques by `kind`, (N, joints) in SI units; None where there are none.

        Raises InputError for a joint too many or too few.
        """
        for unit, factor in UNITS[kind].items():
            values = self.columns.get(name := f"{kind}_{unit}")
            if values is None:
                continue
            if values.ndim == 1:
                values = values[:, None]
            if values.ndim != 2 or values.shape[1] != joints:
                allowed = f"(times, {joints}), one column a joint"
                raise self.refuse(name, f"has shape {values.shape}; must be {allowed}")
            return values * factor
        matches = filter(None, map(NUMBERED.fullmatch, self.columns))
        numbers = {match[2] for match in matches if match[1] == kind}
        wrong = sorted(numbers - {str(number) for number in range(1, joints + 1)})
        if wrong:
            reason = f"there are {joints} joints, numbered from 1"
            raise self.refuse(f"{kind}_{wrong[0]}", reason)
        columns = [self.select(kind, number) for number in range(1, joints + 1)]
        given = [values for values in columns if values is not None]
        if not given:
            return None
        for number, column in enumerate(columns, 1):
            if column is None:
                reason = f"is missing; must be {' or '.join(self.allowed_names(kind, number))}"
                if kind == "theta" and number > len(given):
                    reason += f"; joints of the record: {len(given)}, of the mechanism: {joints}"
                raise self.refuse(f"{kind}_{number}", reason)
            if len(column) != len(given[0]):
                reason = f"has {len(column)} rows, {kind}_1 has {len(given[0])}"
                raise self.refuse(f"{kind}_{number}", reason)
        return np.stack(given, axis=1)

    def refuse(self, name: str, reason: str) -> InputError:
        """The error of a column."""
        return InputError(self.where, name, None, reason)


def _begin_name(kind: str, number: int | None) -> str:
    return kind if number is None else f"{kind}_{number}"


BagContent = tuple[dict[str, np.ndarray], int]  # columns by name; how many messages were skipped


def _read_bag(path: Path, topic: str, joints: tuple[str, ...]) -> BagContent:
    where = str(path)
    if path.is_dir() and not (path / "metadata.yaml").is_file():
        reason = "is a folder without the metadata.yaml of a ROS bag; name the file of a recording"
        raise InputError(where, "", None, reason)
    with convert_read_errors(where):
        files = [each for each in path.iterdir() if each.is_file()] if path.is_dir() else [path]
        size = sum(map(input_size, files))
    if size > LARGEST_FILE:
        raise InputError(where, "", None, f"more than {LARGEST_FILE // 1_000_000} MB")
    content: BagContent = read_in_subprocess(
        where, _read_bag_columns, where, topic, joints, within_s=BAG_S
    )
    return content


def _read_bag_columns(where: str, topic: str, joints: tuple[str, ...]) -> BagContent:
    """Columns of a ROS bag, as of the other formats; a file, or a ROS 2 bag's folder.

    topic: whose messages; empty for the only one of JointState. joints: their names, from the
    base on; messages may have others beside them. Raises InputError.
    """
    try:
        from rosbags.highlevel import AnyReader
        from rosbags.typesys import Stores, get_typestore
    except ImportError:
        raise InputError(where, "", None, MISSING) from None
    try:
        types = get_typestore(Stores.LATEST)
        with AnyReader([Path(where)], default_typestore=types) as bag:
            return _read_messages(where, bag, topic, joints)
    except InputError:
        raise
    except Exception as bad:  # the package raises what its parsers and SQLite raise
        reason = f"is not a readable ROS bag: {format_line(str(bad))[:200]}"
        raise InputError(where, "", None, reason) from None


def _read_messages(where: str, bag: Any, topic: str, joints: tuple[str, ...]) -> BagContent:
    able = sorted({each.topic for each in bag.connections if each.msgtype == MESSAGE})
    chosen = [topic] if topic else able
    if len(chosen) != 1 or chosen[0] not in able:
        reason = f"has no topic {topic} of {MESSAGE}" if topic else "needs --topic"
        reason += f"; topics of {MESSAGE}: {', '.join(able) or 'none'}"
        raise InputError(where, "", None, reason)
    connections = [each for each in bag.connections if each.topic == chosen[0]]
    skipped: list[str] = []  # names of joints, a message each
    stamps: list[tuple[int, int]] = []  # in the header, and when it was logged [ns]
    rows: list[list[np.ndarray | None]] = []
    for connection, logged, raw in bag.messages(connections):
        state = bag.deserialize(raw, connection.msgtype)
        names, signals = list(state.name), [state.position, state.velocity, state.effort]
        missing = [name for name in joints if name not in names]
        number = len(rows) + len(skipped) + 1
        there = ", ".join(names)[:200] or "none"
        if missing == list(joints) and joints:  # another publisher's, a gripper's for example
            skipped.append(there)
            continue
        if missing or not joints:
            reason = f"has no joint {missing[0]}" if missing else "needs --joint for each joint"
            raise InputError(where, "", None, f"{reason}; message {number} has {there}")
        order = [names.index(name) for name in joints]
        if any(len(each) not in (0, len(names)) for each in signals):
            reason = f"message {number} has another number of values than joints"
            raise InputError(where, "", None, reason)
        rows.append([each[order] if len(each) else None for each in signals])
        stamps.append((state.header.stamp.sec * 10**9 + state.header.stamp.nanosec, logged))
    if not rows and skipped:
        reason = f"has no joint {joints[0]}; message 1 has {skipped[0]}"
        raise InputError(where, "", None, reason)
    headers, logs = zip(*stamps, strict=True) if stamps else ((), ())
    clock = headers if any(headers) else logs
    columns = {"t_s": np.array([1e-9 * (each - clock[0]) for each in clock])}
    column_names = ("theta_rad", "theta_dot_rad_per_s", "torque_N_m")  # units of REP 103
    for kind, values in zip(column_names, zip(*rows, strict=True), strict=False):
        given = [each for each in values if each is not None]
        if given and len(given) < len(values):
            raise InputError(where, "", None, f"only some messages have values of {kind}")
        if given:
            columns[kind] = np.array(given, dtype=float)
    return columns, len(skipped)


def _read_arrays(where: str, content: bytes) -> dict[str, np.ndarray]:
    """Arrays of numbers by name, of a MAT, HDF5 or NetCDF file. Raises InputError."""
    begins = ("t_", "theta_", "torque_")
    try:
        arrays = read_arrays(
            content,
            lambda names: [n for n in names if TRAJECTORY_NAMES.get(n, n).startswith(begins)],
        )
        return {
            TRAJECTORY_NAMES.get(n, n): np.asarray(values, dtype=float)
            for n, values in arrays.items()
            if values.dtype.kind in "fiu"
        }
    except TooManyNumbers as many:
        raise InputError(where, "", None, str(many)) from None
    except (OSError, ValueError, KeyError, TypeError, RuntimeError, NotImplementedError):
        raise InputError(where, "", None, "is not a CSV, MAT, HDF5 or NetCDF file") from None


def require_even_enough(where: str, time: np.ndarray) -> None:
    """Raise InputError for times [s] that do not rise or have gaps, which no filter can follow."""
    wrong = np.flatnonzero(~(np.abs(time) <= LATEST))
    if wrong.size:
        row = int(wrong[0])
        value = float(time[row])
        shown = value if np.isfinite(value) else None
        allowed = f"must be a number up to {LATEST:g} s"
        raise InputError(where, f"time, data row {row + 1}", shown, allowed)
    steps = np.diff(time)
    wrong = np.flatnonzero(~(steps > 0))
    if wrong.size:
        row = int(wrong[0]) + 1
        now, before = float(time[row]), float(time[row - 1])
        reason = f"is that of row {row}" if now == before else f"is before row {row} ({before!r})"
        raise InputError(where, f"time, data row {row + 1}", now, f"{reason}; must rise")
    if steps.max() > LONGEST_GAP * steps.mean():
        row = int(steps.argmax()) + 2
        reason = f"is {steps.max():.3g} s after the row before; cut the record where it has gaps"
        raise InputError(where, f"time, data row {row}", float(time[row - 1]), reason)


def describe_gaps(time: np.ndarray) -> list[str]:
    """A sentence on the gaps in rising times [s], where there are any."""
    steps = np.diff(time)
    if not steps.size or steps.max() <= GAP * (usual := np.median(steps)):
        return []
    count, widest = int((steps > GAP * usual).sum()), int(steps.argmax())
    size = f"{steps[widest] / usual:.3g} usual steps"
    gaps = f"{count:,} gaps, the widest" if count > 1 else "a gap"
    return [f"the times have {gaps} of {size} after {time[widest]:.6g} s, filled by straight lines"]


def _require_usable(where: str, kind: str, rows: int, table: np.ndarray) -> None:
    if len(table) != rows:
        raise InputError(where, kind, None, f"has {len(table)} rows, the times have {rows}")
    wrong = np.argwhere(~(np.abs(table) <= LARGEST[kind]))
    if wrong.size:
        row, joint = map(int, wrong[0])
        field, value = f"{kind}_{joint + 1}, data row {row + 1}", float(table[row, joint])
        if not np.isfinite(value):
            raise InputError(
                where, field, None, "must be a number: cut the record where it has gaps"
            )
        allowed = f"must be at most {LARGEST[kind]:g} in size, in SI units"
        raise InputError(where, field, value, allowed)

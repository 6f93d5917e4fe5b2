"""Recorded motions in ROS bags: messages of sensor_msgs/JointState, by the package rosbags."""

from __future__ import annotations

import signal
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from crosscheck.models.errors import one_line

ENDINGS = (".bag", ".db3", ".mcap")
MESSAGE = "sensor_msgs/msg/JointState"
READING_S = 300.0
MISSING = "ROS bags need the package rosbags: pip install 'geararm-crosscheck[ros]'"


@dataclass(frozen=True)
class BagReading:
    """The task of reading a bag: a file, or the folder of a ROS 2 bag.

    topic: whose messages; empty for the only one of JointState. joints: names of the arm's, from
    the base on; messages may have others beside them.
    """

    path: str
    topic: str
    joints: tuple[str, ...]
    key: str = "record"

    @property
    def cost(self) -> float:
        """Rough seconds."""
        return 1.0

    def perform(self) -> dict[str, np.ndarray] | str:
        """Columns by name as of the other formats, or what is wrong with the bag."""
        try:
            from rosbags.highlevel import AnyReader
            from rosbags.typesys import Stores, get_typestore
        except ImportError:
            return MISSING
        signal.setitimer(signal.ITIMER_REAL, READING_S)  # which ends the process
        try:
            types = get_typestore(Stores.LATEST)
            with AnyReader([Path(self.path)], default_typestore=types) as bag:
                return self._columns(bag)
        except Exception as bad:  # the package raises what its parsers and SQLite raise
            return f"is no readable ROS bag: {one_line(str(bad))[:200]}"

    def _columns(self, bag: Any) -> dict[str, np.ndarray] | str:
        able = sorted({each.topic for each in bag.connections if each.msgtype == MESSAGE})
        chosen = [self.topic] if self.topic else able
        if len(chosen) != 1 or chosen[0] not in able:
            told = ", ".join(able) or "none"
            asked = f"has no topic {self.topic} of {MESSAGE}" if self.topic else "needs --topic"
            return f"{asked}; topics of {MESSAGE}: {told}"
        connections = [each for each in bag.connections if each.topic == chosen[0]]
        stamps: list[int] = []
        logged: list[int] = []
        rows: list[list[np.ndarray | None]] = []
        for connection, time, raw in bag.messages(connections):
            state = bag.deserialize(raw, connection.msgtype)
            names, signals = list(state.name), [state.position, state.velocity, state.effort]
            missing = [name for name in self.joints if name not in names]
            if missing or not self.joints:
                asked = f"has no joint {missing[0]}" if missing else "needs --joint for each joint"
                return f"{asked}; message {len(rows) + 1} has {', '.join(names)[:200] or 'none'}"
            order = [names.index(name) for name in self.joints]
            if any(len(each) not in (0, len(names)) for each in signals):
                return f"message {len(rows) + 1} has another number of values than joints"
            rows.append([each[order] if len(each) else None for each in signals])
            stamps.append(state.header.stamp.sec * 10**9 + state.header.stamp.nanosec)
            logged.append(time)
        clock = stamps if any(stamps) else logged
        columns = {"t_s": np.array([1e-9 * (each - clock[0]) for each in clock])}
        kinds = ("theta_rad", "theta_dot_rad_per_s", "torque_N_m")  # as REP 103 has the units
        for kind, values in zip(kinds, zip(*rows, strict=True), strict=False):
            given = [each for each in values if each is not None]
            if given and len(given) < len(values):
                return f"only some messages have values of {kind}"
            if given:
                columns[kind] = np.array(given, dtype=float)
        return columns

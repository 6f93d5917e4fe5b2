"""Recorded motions in ROS bags: messages of sensor_msgs/JointState, by the package rosbags."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from crosscheck.models.errors import InputError, one_line

ENDINGS = (".bag", ".db3", ".mcap")
MESSAGE = "sensor_msgs/msg/JointState"
MISSING = "ROS bags need the package rosbags: pip install 'geararm-crosscheck[ros]'"


def read_bag(where: str, topic: str, joints: tuple[str, ...]) -> dict[str, np.ndarray]:
    """Columns by name, as of the other formats, of a bag: a file, or the folder of a ROS 2 bag.

    topic: whose messages; empty for the only one of JointState. joints: names of the arm's, from
    the base on; messages may have others beside them. Raises InputError.
    """
    try:
        from rosbags.highlevel import AnyReader
        from rosbags.typesys import Stores, get_typestore
    except ImportError:
        raise InputError(where, "", None, MISSING) from None
    try:
        types = get_typestore(Stores.LATEST)
        with AnyReader([Path(where)], default_typestore=types) as bag:
            return _columns(where, bag, topic, joints)
    except InputError:
        raise
    except Exception as bad:  # the package raises what its parsers and SQLite raise
        reason = f"is no readable ROS bag: {one_line(str(bad))[:200]}"
        raise InputError(where, "", None, reason) from None


def _columns(where: str, bag: Any, topic: str, joints: tuple[str, ...]) -> dict[str, np.ndarray]:
    able = sorted({each.topic for each in bag.connections if each.msgtype == MESSAGE})
    chosen = [topic] if topic else able
    if len(chosen) != 1 or chosen[0] not in able:
        asked = f"has no topic {topic} of {MESSAGE}" if topic else "needs --topic"
        reason = f"{asked}; topics of {MESSAGE}: {', '.join(able) or 'none'}"
        raise InputError(where, "", None, reason)
    connections = [each for each in bag.connections if each.topic == chosen[0]]
    stamps: list[int] = []
    logged: list[int] = []
    rows: list[list[np.ndarray | None]] = []
    for connection, time, raw in bag.messages(connections):
        state = bag.deserialize(raw, connection.msgtype)
        names, signals = list(state.name), [state.position, state.velocity, state.effort]
        missing = [name for name in joints if name not in names]
        if missing or not joints:
            asked = f"has no joint {missing[0]}" if missing else "needs --joint for each joint"
            there = ", ".join(names)[:200] or "none"
            reason = f"{asked}; message {len(rows) + 1} has {there}"
            raise InputError(where, "", None, reason)
        order = [names.index(name) for name in joints]
        if any(len(each) not in (0, len(names)) for each in signals):
            reason = f"message {len(rows) + 1} has another number of values than joints"
            raise InputError(where, "", None, reason)
        rows.append([each[order] if len(each) else None for each in signals])
        stamps.append(state.header.stamp.sec * 10**9 + state.header.stamp.nanosec)
        logged.append(time)
    clock = stamps if any(stamps) else logged
    columns = {"t_s": np.array([1e-9 * (each - clock[0]) for each in clock])}
    kinds = ("theta_rad", "theta_dot_rad_per_s", "torque_N_m")  # as REP 103 has the units
    for kind, values in zip(kinds, zip(*rows, strict=True), strict=False):
        given = [each for each in values if each is not None]
        if given and len(given) < len(values):
            raise InputError(where, "", None, f"only some messages have values of {kind}")
        if given:
            columns[kind] = np.array(given, dtype=float)
    return columns

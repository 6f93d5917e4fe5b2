"""A process with all that it has started: the processor time that they took, and their end.

Known where the system keeps ``/proc``; elsewhere nothing is known of them.
"""

from __future__ import annotations

import ctypes
import os
import signal
import sys
import time
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

PROC = Path("/proc")
PARENT_DEATH_SIGNAL, CHILD_SUBREAPER = 1, 36  # of Linux's prctl
ROUNDS = 50  # at processes that start others while they are being ended


class Member(NamedTuple):
    """A process: its parent, processor time [s] with children it waited for, if it has ended."""

    parent: int
    used_s: float
    ended: bool


Table = Mapping[int, Member]


def processes() -> Table:
    """All processes of the machine by number; none where the system does not tell."""
    found: dict[int, Member] = {}
    with suppress(OSError):
        for name in filter(str.isdigit, os.listdir(PROC)):
            try:
                stat = (PROC / name / "stat").read_text(errors="replace")
            except OSError:  # it has ended since
                continue
            fields = stat.rpartition(")")[2].split()
            used_s = sum(map(int, fields[11:15])) / _TICKS_PER_S
            found[int(name)] = Member(int(fields[1]), used_s, fields[0] in "ZX")
    return found


_TICKS_PER_S = os.sysconf("SC_CLK_TCK")


def descendants(of: int, table: Table) -> list[int]:
    """Numbers of all processes that one has started, directly or not, children before parents."""
    children: dict[int, list[int]] = {}
    for number, member in table.items():
        children.setdefault(member.parent, []).append(number)
    found, unseen = list[int](), [of]
    while unseen:
        own = children.get(unseen.pop(), [])
        found += own
        unseen += own
    return found[::-1]


def used_s(of: int, table: Table) -> float | None:
    """Processor time [s] of a process and all that it has started; None where it is unknown."""
    members = [table[each] for each in (of, *descendants(of, table)) if each in table]
    return sum(member.used_s for member in members) if members else None


def end_descendants(of: int) -> None:
    """End all that a process has started; the process itself must not start more meanwhile."""
    for _ in range(ROUNDS):
        table = processes()
        alive = [each for each in descendants(of, table) if not table[each].ended]
        if not alive:
            return
        for each in alive:
            with suppress(OSError):
                os.kill(each, signal.SIGKILL)
        time.sleep(0.002)


def adopt() -> None:
    """Make this process the parent of whatever its descendants leave behind, from now on."""
    _prctl(CHILD_SUBREAPER, 1)


def end_with_parent() -> None:
    """Have this process ended, from now on, when the thread that forked it ends."""
    _prctl(PARENT_DEATH_SIGNAL, signal.SIGKILL)


def _prctl(option: int, value: int) -> None:
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(option, value)

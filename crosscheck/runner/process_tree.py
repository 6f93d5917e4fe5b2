"""A process with all that it has started: the processor time that they took, and their end."""

from __future__ import annotations

import ctypes
import os
import resource
import signal
import sys
import time
from collections import defaultdict
from collections.abc import Mapping
from contextlib import suppress

import psutil

PARENT_DEATH_SIGNAL, CHILD_SUBREAPER = 1, 36  # of Linux's prctl
ROUNDS = 50  # at processes that start others while they are being ended
ProcessorTimes = Mapping[int, float]  # [s], by number of the process


def measure_processor_times() -> ProcessorTimes:
    """Processor time of each child of this process, with all that the child has started."""
    process_id, child_of, times = os.getpid(), dict[int, int](), defaultdict[int, float](float)
    for process in psutil.Process().children(recursive=True):  # parents before their children
        with suppress(psutil.Error), process.oneshot():  # it may have ended since
            parent, used = process.ppid(), process.cpu_times()
            child = process.pid if parent == process_id else child_of.get(parent, process.pid)
            child_of[process.pid] = child
            # What those used that it waited for is in no other process.
            times[child] += used.user + used.system + used.children_user + used.children_system
    return times


def end_descendants(of: int) -> None:
    """End all that a process has started; the process itself must not start more meanwhile."""
    for _ in range(ROUNDS):
        alive = [each for each in _descendants(of) if not _is_ended(each)]
        if not alive:
            return
        for each in alive:
            with suppress(psutil.Error):
                each.send_signal(signal.SIGKILL)
        time.sleep(0.002)


def _descendants(of: int) -> list[psutil.Process]:
    """All that a process has started, directly or not, children before parents."""
    with suppress(psutil.Error):
        return psutil.Process(of).children(recursive=True)[::-1]
    return []


def _is_ended(process: psutil.Process) -> bool:
    with suppress(psutil.Error):
        return process.status() in (psutil.STATUS_ZOMBIE, psutil.STATUS_DEAD)
    return True


def limit_resources(memory: int, processor_s: int | None = None) -> None:
    """Let this process and those that it starts take so many bytes more, and so many seconds [s].

    Each process by itself; what exceeds the time is ended by a signal.
    """
    used = psutil.Process().memory_info().vms
    _, most = resource.getrlimit(resource.RLIMIT_AS)
    limit = used + memory if most == resource.RLIM_INFINITY else min(used + memory, most)
    resource.setrlimit(resource.RLIMIT_AS, (limit, most))
    if processor_s is not None:
        spent = int(sum(psutil.Process().cpu_times()[:2]))
        _, most = resource.getrlimit(resource.RLIMIT_CPU)
        limit = spent + processor_s
        limit = limit if most == resource.RLIM_INFINITY else min(limit, most)
        resource.setrlimit(resource.RLIMIT_CPU, (limit, limit))


def adopt_orphans() -> None:
    """Make this process the parent of whatever its descendants leave behind, from now on."""
    _prctl(CHILD_SUBREAPER, 1)


def end_with_parent() -> None:
    """Have this process ended, from now on, when the thread that forked it ends."""
    _prctl(PARENT_DEATH_SIGNAL, signal.SIGKILL)


def _prctl(option: int, value: int) -> None:
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(option, value)

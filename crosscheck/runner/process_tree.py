"""A process with all that it has started: their processor time, their number, and their end."""

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
from pathlib import Path

# Whether the system has a file of each process's children; psutil, which looks at every process
# there is, and which many commands need not import, finds them elsewhere.
LISTS_CHILDREN = Path("/proc/thread-self/children").exists()
PARENT_DEATH_SIGNAL, CHILD_SUBREAPER = 1, 36  # options of Linux's prctl
ROUNDS = 50  # rounds of ending processes that keep starting others
MOST_DESCENDANTS = 64  # processes that work may have at once: far more than cores of a workstation
SLOW_FORK_S = 0.05  # wait before each fork beyond so many
ProcessorTimes = Mapping[int, float]  # [s], by number of the process


def measure_processor_times() -> ProcessorTimes:
    """Processor time of each child of this process, with all that the child has started."""
    import psutil

    times = defaultdict[int, float](float)
    for child in _list_children(os.getpid()):
        for process in (*_list_descendants(child), child):
            with suppress(psutil.Error):  # it may have ended since
                # What those used that it waited for is in no other process.
                times[child] += sum(psutil.Process(process).cpu_times()[:4])
    return times


def excess_reason(process: int) -> str:
    """Why a process must be stopped that has started too many others; '' while it need not be."""
    count = len(_list_descendants(process))
    if count <= MOST_DESCENDANTS:
        return ""
    return f"stopped with {count} processes of its own; at most {MOST_DESCENDANTS} may run at once"


class ForkGuard:
    """Keeps code that is not ours from multiplying by forks until nobody can end it.

    Code that forks and goes on in both branches doubles its processes at each call, and whoever
    counts them once a second comes too late. So a fork that would fork ends instead, and a process
    that has forked often waits before each further fork: what is left grows slowly enough to be
    counted (``excess_reason``) and ended.

    Attributes:
        is_active: Whether code that is not ours runs in this process.
    """

    def __init__(self) -> None:
        self.is_active, self._forks, self._is_fork = False, 0, False
        os.register_at_fork(before=self._restrain, after_in_child=self._mark)

    def _restrain(self) -> None:
        if not self.is_active:
            return
        if self._is_fork:
            os._exit(1)
        self._forks += 1
        if self._forks > MOST_DESCENDANTS:
            time.sleep(SLOW_FORK_S)

    def _mark(self) -> None:
        self._is_fork = self.is_active


FORK_GUARD = ForkGuard()


def end_descendants(of: int) -> None:
    """End all that a process has started; the process itself must not start more meanwhile."""
    for _ in range(ROUNDS):
        alive = [each for each in _list_descendants(of) if not _is_ended(each)]
        if not alive:
            return
        for each in alive:
            with suppress(ProcessLookupError):
                os.kill(each, signal.SIGKILL)
        time.sleep(0.002)


def _list_descendants(of: int) -> list[int]:
    """Numbers of all that a process has started, directly or not, children before parents."""
    return [each for child in _list_children(of) for each in (*_list_descendants(child), child)]


def _list_children(of: int) -> list[int]:
    """Numbers of the processes that a process has started and not waited for."""
    if LISTS_CHILDREN:
        with suppress(OSError):  # it may have ended
            texts = [file.read_text() for file in Path(f"/proc/{of}/task").glob("*/children")]
            return [int(number) for text in texts for number in text.split()]
        return []
    import psutil

    with suppress(psutil.Error):
        return [child.pid for child in psutil.Process(of).children()]
    return []


def describe_end(code: int | None) -> str:
    """How a process has ended, by its exit code as Python has it."""
    if code is not None and code < 0:
        return f"was ended by {signal.Signals(-code).name}"
    return f"ended with exit code {code}"


def _is_ended(process: int) -> bool:
    import psutil

    with suppress(psutil.Error):
        return psutil.Process(process).status() in (psutil.STATUS_ZOMBIE, psutil.STATUS_DEAD)
    return True


def limit_resources(memory: int, processor_s: int | None = None) -> None:
    """Let this process and those that it starts take so many bytes more, and so many seconds [s].

    Each process by itself; what exceeds the time is ended by a signal.
    """
    import psutil

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

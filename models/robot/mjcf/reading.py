"""A file in MuJoCo's format, MJCF, read in a process of its own, which it may bring down.

MuJoCo's importer follows includes, builds what a file asks it to repeat, and ends its process where
it runs out of memory. So the process has limits: of memory, of processor time, and of time in which
it uses none, as one does that waits at a pipe.
"""

from __future__ import annotations

import faulthandler
import os
import resource
import signal
from collections.abc import Callable
from contextlib import suppress
from functools import lru_cache, partial
from importlib.util import find_spec
from multiprocessing.connection import Connection, Pipe
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NoReturn

import psutil

from crosscheck.models.errors import InputError, format_install_command
from crosscheck.models.robot.mjcf.writer import MjcfRobot, convert_file

MEMORY_BYTES = 2 * 1024**3  # memory of the reader, beyond the program's own
PROCESSOR_S = 10  # [s] of processor time, of which shapes of files take most
IDLE_S, LOOK_S = 4.0, 0.1  # [s] without processor time; from one look to the next
LONGEST_S = 600  # [s], after which the process ends though its parent has died


@lru_cache(maxsize=8)
def read_mjcf(path: Path, text: str) -> MjcfRobot:
    """The robot of the text of an MJCF file. Raises InputError."""
    if find_spec("mujoco") is None:
        allowed = f"is MJCF, which MuJoCo reads: {format_install_command('mjcf')}"
        raise InputError(str(path), "", None, allowed)
    with TemporaryDirectory() as folder:  # where MuJoCo leaves its log
        convert = partial(convert_file, os.path.abspath(path), str(path))
        result = _run_limited(convert, folder, str(path))
    if isinstance(result, InputError):
        raise result
    return result


def _run_limited(
    convert: Callable[[], MjcfRobot], folder: str, where: str
) -> MjcfRobot | InputError:
    """The result of a forked process that reads a file in a folder. Raises InputError if none."""
    receiving, sending = Pipe(duplex=False)
    child = os.fork()
    if child == 0:
        _convert_and_exit(convert, folder, where, sending)
    sending.close()
    result: MjcfRobot | InputError | None = None
    try:
        is_waiting = _is_waiting(receiving, child)
        with suppress(EOFError, OSError):
            result = None if is_waiting else receiving.recv()
    finally:
        receiving.close()
        with suppress(ProcessLookupError):
            os.kill(child, signal.SIGKILL)
        _, status = os.waitpid(child, 0)
    if result is not None:
        return result
    number = os.waitstatus_to_exitcode(status)
    reason = "ends its process"
    if is_waiting:
        reason = f"waits for a file that is none, {IDLE_S:g} s so far"
    elif number == -signal.SIGXCPU:
        reason = f"takes more than {PROCESSOR_S} s of processor time"
    elif number < 0:
        reason = f"{reason} by {signal.Signals(-number).name}"
    raise InputError(where, "", None, f"MuJoCo cannot read it: it {reason}")


def _is_waiting(pipe: Connection, child: int) -> bool:
    """Whether a child uses no processor time for a while before it sends something or ends."""
    used, idle = -1.0, 0.0
    while not pipe.poll(LOOK_S):
        with suppress(psutil.Error):
            process = psutil.Process(child)
            before, used = used, sum(process.cpu_times()[:2])
            is_asleep = process.status() == psutil.STATUS_SLEEPING and used == before
            idle = idle + LOOK_S if is_asleep else 0.0
            if idle > IDLE_S:
                return True
    return False


def _convert_and_exit(
    convert: Callable[[], MjcfRobot], folder: str, where: str, pipe: Connection
) -> NoReturn:
    """Send the robot or the InputError of a file, in a forked process that prints nothing."""
    try:
        faulthandler.disable()
        signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent answers it
        signal.alarm(LONGEST_S)
        os.chdir(folder)
        null = os.open(os.devnull, os.O_WRONLY)
        for stream in (1, 2):
            os.dup2(null, stream)
        _limit_resources()
        result: MjcfRobot | InputError
        try:
            result = convert()
        except InputError as error:
            result = error
        except MemoryError:
            allowed = f"MuJoCo cannot read it: it takes more than {MEMORY_BYTES >> 30} GB of memory"
            result = InputError(where, "", None, allowed)
        pipe.send(result)
        os._exit(0)
    finally:
        os._exit(1)


def _limit_resources() -> None:
    process = psutil.Process()
    spent = int(sum(process.cpu_times()[:2]))
    limits = {
        resource.RLIMIT_CORE: 0,
        resource.RLIMIT_AS: process.memory_info().vms + MEMORY_BYTES,
        resource.RLIMIT_CPU: spent + 1 + PROCESSOR_S,
    }
    for kind, limit in limits.items():
        _, most = resource.getrlimit(kind)
        limit = limit if most == resource.RLIM_INFINITY else min(limit, most)
        with suppress(ValueError, OSError):  # systems that know a limit and refuse to set it
            resource.setrlimit(kind, (limit, most))

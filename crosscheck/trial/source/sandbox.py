"""Where edited code runs: a process that changes nothing outside itself, within limits.

An edit of right code may be dangerous code: a range that does not end, another file's name. The
process is a worker of its own that ends with the search; what it must not do is refused by an audit
hook, which nothing can take off again. Code that was loaded before is the user's own and has run.
"""

from __future__ import annotations

import os
import resource
import signal
import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np

from crosscheck.runner.process_tree import limit_resources

MEMORY = 1_000_000_000  # bytes beyond those that the process begins with
# What libraries do when they are imported is allowed: ctypes, reading, listing of folders.
REFUSED = (
    "subprocess.", "socket.", "os.system", "os.exec", "os.fork", "os.posix_spawn", "os.spawn",
    "os.startfile", "os.remove", "os.rename", "os.rmdir", "os.mkdir", "os.link", "os.symlink",
    "os.truncate", "os.chmod", "os.chown", "os.utime", "os.setxattr", "os.removexattr", "os.kill",
    "os.putenv", "os.unsetenv", "shutil.", "pty.", "tempfile.", "signal.pthread_kill",
    "sqlite3.", "resource.",
)  # fmt: skip
WRITING = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC | os.O_APPEND


class RefusedAction(BaseException):
    """An error for what edited code must not do; no `except Exception` of its own stops it."""


class TooSlow(BaseException):
    """An error for an edit that takes too long."""


def enter_sandbox(processor_s: int) -> None:
    """Confine this process, for good.

    processor_s: processor time [s] after which it is ended, whatever it does.
    """
    limit_resources(MEMORY, processor_s)
    resource.setrlimit(resource.RLIMIT_FSIZE, (0, 0))  # also of libraries that no hook sees
    sys.dont_write_bytecode = True
    warnings.simplefilter("ignore")
    np.seterr(all="ignore")
    sys.addaudithook(_refuse)


def _refuse(event: str, arguments: tuple[Any, ...]) -> None:
    if event == "open":
        _, mode, flags = arguments
        if set(mode or "") & set("wax+") or (flags or 0) & WRITING:
            raise RefusedAction("writing of files")
    elif event.startswith(REFUSED):
        raise RefusedAction(event)


def _interrupt(number: int, frame: object) -> None:
    raise TooSlow


@contextmanager
def limit_processor_time(seconds: float) -> Iterator[None]:
    """Raise TooSlow in what runs inside after so much processor time [s], and again and again."""
    signal.signal(signal.SIGPROF, _interrupt)
    signal.setitimer(signal.ITIMER_PROF, seconds, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)


def freeze(value: Any, frozen: set[int] | None = None) -> None:
    """Make every array in a mechanism read-only, so that no edit changes what the next one gets."""
    frozen = set() if frozen is None else frozen
    if id(value) in frozen:
        return
    frozen.add(id(value))
    if isinstance(value, np.ndarray):
        value.flags.writeable = False
    elif isinstance(value, dict):
        value = list(value.values())
    elif is_dataclass(value) and not isinstance(value, type):
        value = [getattr(value, each.name) for each in fields(value)]
    if isinstance(value, list | tuple):
        for each in value:
            freeze(each, frozen)

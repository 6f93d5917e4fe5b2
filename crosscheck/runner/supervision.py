"""The command in a process of its own; its exit code is decided here, by what it says last.

Commands run code that is not ours: a user's equations and measures, installed packages' models.
Such code may end its process at any moment, with any exit code, and may leave processes behind. So
the program itself runs none of it: it waits for the command's verdict, and without one there is
no 0.
"""

from __future__ import annotations

import json
import os
import resource
import select
import signal
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from typing import Any, NoReturn

from crosscheck.cli.environment import occupy_streams
from crosscheck.models.errors import PROGRAM, format_line
from crosscheck.runner import cpu_limit
from crosscheck.runner.cpu_limit import CpuTimeLimit
from crosscheck.runner.interruption import SHOW_CURSOR, SIGNALS, ignore_signals
from crosscheck.runner.process_tree import (
    FORK_GUARD,
    adopt_orphans,
    describe_end,
    end_descendants,
    end_with_parent,
    excess_reason,
    measure_processor_times,
)

BAD_INPUT, NO_VERDICT = 2, 3
LEAST_FILES = 64  # open at once: a cross-check on two processes has 30
CHUNK = 65536
CLOSING_S = 5.0  # time between the verdict and the end of the process [s]


# From the command to whoever waits for it: the pipe, and the process whose word counts.
_lines: list[tuple[int, int]] = []


@contextmanager
def track_foreign_code(whose: str, cost: float = 5.0) -> Iterator[None]:
    """Run code that is not ours in this context: it is to blame if the process ends or hangs.

    Whatever it does to the working folder, the umask and the standard streams is undone, and what
    it has forked ends with it, so that the command goes on once. whose: how an error line begins;
    cost: estimated [s], see CpuTimeLimit.
    """
    process, was_guarded = os.getpid(), FORK_GUARD.is_active
    _send_message(begins=whose, cost=cost)
    FORK_GUARD.is_active = True
    try:
        with _restore_streams():
            yield
    finally:
        if os.getpid() != process:
            os._exit(0)
        FORK_GUARD.is_active = was_guarded
        _send_message(ends=whose)


@contextmanager
def _restore_streams() -> Iterator[None]:
    """Restore working folder, umask and standard streams, in which results are written."""
    streams, mask = (sys.stdin, sys.stdout, sys.stderr), os.umask(0o077)
    os.umask(mask)
    folder = os.open(".", os.O_DIRECTORY | os.O_CLOEXEC)
    try:
        yield
    finally:
        os.fchdir(folder)
        os.close(folder)
        os.umask(mask)
        sys.stdin, sys.stdout, sys.stderr = streams


def _send_message(**message: Any) -> None:
    for handle, maker in _lines:
        if os.getpid() == maker:
            with suppress(OSError):  # no process is waiting for it
                os.write(handle, json.dumps(message).encode() + b"\n")


def run_supervised(command: Callable[[], NoReturn]) -> int:
    """Perform a command in a process of its own; returns the exit code of the program.

    The command leaves by SystemExit; it must listen to SIGINT and SIGTERM and unblock them.
    Whatever it has started is ended.
    """
    files, _ = resource.getrlimit(resource.RLIMIT_NOFILE)
    if files < LEAST_FILES:
        need = f"a limit of {files} is set; at least {LEAST_FILES} are needed"
        print(f"{PROGRAM}open files: {need}", file=sys.stderr)
        return BAD_INPUT
    adopt_orphans()
    occupy_streams()
    here, there = os.pipe()
    parent = os.getpid()
    signal.pthread_sigmask(signal.SIG_BLOCK, SIGNALS)
    child = os.fork()
    if child == 0:
        os.close(here)
        _lines.append((there, os.getpid()))
        end_with_parent()
        if os.getppid() != parent:
            os._exit(NO_VERDICT)
        try:
            command()
        except SystemExit as left:
            _send_message(code=left.code if isinstance(left.code, int) else 1)
            raise
        raise AssertionError("a command leaves by SystemExit")
    os.close(there)
    return _Supervision(child, here).exit_code()


@dataclass
class _Supervision:
    """The watch over a command's process, until its end.

    foreign_calls: whose code it runs; verdict_code: its verdict; status: of its end; stop_signal:
    the signal that came.
    """

    child: int
    handle: int
    foreign_calls: list[tuple[str, CpuTimeLimit]] = field(default_factory=list)
    verdict_code: int | None = None
    status: int | None = None
    buffer: bytes = b""
    stop_signal: int | None = None

    def exit_code(self) -> int:
        """The program's exit code, once the command's process has ended."""
        wakes, woken = os.pipe()
        for handle in (wakes, woken, self.handle):
            os.set_blocking(handle, False)
        signal.set_wakeup_fd(woken, warn_on_full_buffer=False)
        for number in SIGNALS:
            signal.signal(number, self._forward)
        signal.signal(signal.SIGCHLD, lambda number, frame: None)
        signal.pthread_sigmask(signal.SIG_UNBLOCK, SIGNALS)
        blame = self._wait_for_end(wakes)
        ignore_signals()  # nothing is left to interrupt
        end_descendants(os.getpid())
        self._collect_ended()
        if blame:
            return self._report_blame(blame, BAD_INPUT)
        if self.verdict_code is not None:
            return self.verdict_code
        if self.stop_signal is not None:
            return 128 + self.stop_signal
        assert self.status is not None  # it has ended, by itself
        how = f"its process {describe_end(os.waitstatus_to_exitcode(self.status))}"
        if self.foreign_calls:
            return self._report_blame(f"{self.foreign_calls[-1][0]}: {how}", BAD_INPUT)
        return self._report_blame(f"came to no verdict: {how}", NO_VERDICT)

    def _forward(self, number: int, frame: object) -> None:
        self.stop_signal = self.stop_signal or number
        with suppress(OSError):
            os.kill(self.child, number)

    def _wait_for_end(self, wakes: int) -> str:
        """Wait for the process to end; returns whom to blame if it had to be stopped."""
        until, open_ = float("inf"), [self.handle, wakes]
        next_look = time.monotonic() + cpu_limit.LOOK_S
        while self.status is None and time.monotonic() < until:
            ready = select.select(open_, [], [], cpu_limit.LOOK_S)[0]
            if wakes in ready:
                os.read(wakes, CHUNK)
            if self.handle in ready and not self._listen():
                open_.remove(self.handle)
            if self.verdict_code is not None:
                until = min(until, time.monotonic() + CLOSING_S)
            elif time.monotonic() >= next_look:
                if blame := self._overdue_message():
                    self._end()
                    return blame
                next_look = time.monotonic() + cpu_limit.LOOK_S
            self._collect_ended()
        self._listen()
        self._end()
        return ""

    def _listen(self) -> bool:
        """Read what the command has said; returns whether anybody may say more."""
        with suppress(BlockingIOError):
            while content := os.read(self.handle, CHUNK):
                *lines, self.buffer = (self.buffer + content).split(b"\n")
                for line in lines:
                    self._handle_message(json.loads(line))
            return False
        return True

    def _handle_message(self, message: dict[str, Any]) -> None:
        if "code" in message:
            self.verdict_code = message["code"]
        elif "begins" in message:
            waiting = CpuTimeLimit(self.child, message["cost"])
            self.foreign_calls.append((message["begins"], waiting))
        elif self.foreign_calls:
            self.foreign_calls.pop()

    def _overdue_message(self) -> str:
        if not self.foreign_calls:
            return ""
        times, excess = measure_processor_times(), excess_reason(self.child)
        for whose, waiting in self.foreign_calls:
            if why := waiting.stop_reason(times) or excess:
                return f"{whose}: {why}"
        return ""

    def _collect_ended(self) -> None:
        """Collect all processes that have ended; others than the command were left behind by it."""
        with suppress(ChildProcessError):
            while (ended := os.waitpid(-1, os.WNOHANG))[0]:
                if ended[0] == self.child:
                    self.status = ended[1]

    def _end(self) -> None:
        if self.status is None:
            with suppress(OSError):
                os.kill(self.child, signal.SIGKILL)

    def _report_blame(self, line: str, code: int) -> int:
        shown = SHOW_CURSOR if os.isatty(2) else ""
        print(f"{shown}{format_line(PROGRAM + line)}", file=sys.stderr)
        return code

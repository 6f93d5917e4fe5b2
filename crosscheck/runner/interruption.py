"""Ctrl-C and termination: at any moment, once or more often, one line and the agreed exit code.

Light on purpose: it is the first thing that the command line imports.
"""

from __future__ import annotations

import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType

SIGNALS = {signal.SIGINT, signal.SIGTERM}
# If the program has not come to its end by then [s], it is ended: engines swallow exceptions.
GRACE_S = 1.2
SHOW_CURSOR = "\x1b[?25h"  # terminal sequence that shows the cursor, which a progress bar hides
# What must not be left behind when the program is ended: worker processes, half-written files.
cleanup_callbacks: list[Callable[[], None]] = []
# How to go on later, where work is kept: what the one line says besides.
advice: list[str] = []
_signals: list[int] = []
_pending_signals: list[int] = []
_hold_marks: list[bool] = []


def listen() -> None:
    """Let SIGINT and SIGTERM raise KeyboardInterrupt, once, from now on."""
    for number in SIGNALS:
        signal.signal(number, _stop)


def ignore_signals() -> None:
    """Ignore SIGINT and SIGTERM from now on."""
    for number in SIGNALS:
        signal.signal(number, signal.SIG_IGN)


def exit_code() -> int:
    """Exit code that the shell expects of a program that a signal has ended: 130 or 143."""
    return 128 + (_signals[0] if _signals else signal.SIGINT)


def was_stopped() -> bool:
    """Whether SIGINT or SIGTERM has come: then any exception may be what has become of it.

    Python makes another one of a KeyboardInterrupt in ``__set_name__``, which imports call.
    """
    return bool(_signals)


def leave_if_stopped() -> None:
    """End at once, with ``exit_code()``, if SIGINT or SIGTERM has come.

    Python itself ends by SIGINT, whatever the exit code, where a KeyboardInterrupt has once passed
    through code that a C extension had run, as some do while they are imported.
    """
    if _signals:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(exit_code())


def exit_message() -> str:
    """The one line that a program says when it is stopped."""
    word = "terminated" if _signals and _signals[0] == signal.SIGTERM else "interrupted"
    return "; ".join([word, *advice])


@contextmanager
def finish_before_interrupt() -> Iterator[None]:
    """Finish what is done in this context before an interrupt counts; it must be short."""
    _hold_marks.append(True)
    try:
        yield
    finally:
        _hold_marks.pop()
        if _pending_signals:
            _stop(_pending_signals[0], None)


def _stop(number: int, _: FrameType | None) -> None:
    if _hold_marks:
        _pending_signals.append(number)
        return
    ignore_signals()
    _signals.append(number)
    # Where Python can only report the interrupt (in a weak reference's callback, as imports have
    # them), it would be said in a traceback; _end_anyway says it in one line.
    sys.unraisablehook = _ignore_unraisable
    threading.Thread(target=_end_anyway, daemon=True).start()
    raise KeyboardInterrupt


def _ignore_unraisable(_: sys.UnraisableHookArgs) -> None:
    """Say nothing more of a program that is being stopped."""


def _end_anyway() -> None:
    """End the program where the interrupt was swallowed, or its way out takes too long."""
    threading.Event().wait(GRACE_S)
    for clear in cleanup_callbacks:
        clear()
    shown = SHOW_CURSOR if os.isatty(2) else ""
    os.write(2, f"{shown}crosscheck: {exit_message()}\n".encode())
    os._exit(exit_code())

"""Progress of long work on standard error: a bar on a terminal, lines elsewhere."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager
from typing import TYPE_CHECKING

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, ProgressColumn, Task, TextColumn
from rich.status import Status
from rich.text import Text

if TYPE_CHECKING:
    from crosscheck.runner.progress_update import ProgressCallback

# Where there is no terminal: the first line, unless work asks for an earlier one; how often others
# follow at most [s].
QUIET_S, EVERY_S = 20.0, 20.0
IN_MINUTES_S = 100.0  # longer times are shown in minutes


def show_starting_status() -> Status:
    """A status line while libraries load: what comes next shows its own progress."""
    return Console(stderr=True).status("starting")


def show_progress(about: str, quiet_s: float = QUIET_S) -> AbstractContextManager[ProgressCallback]:
    """A progress callback that shows a bar on a terminal and otherwise prints occasional lines.

    about: what is under way. The first line comes after ``quiet_s`` seconds: whoever keeps the
    standard error of short work finds nothing in it but what is wrong.
    """
    console = Console(stderr=True)
    return _live(console) if console.is_interactive else _lines(about, quiet_s)


@contextmanager
def _live(console: Console) -> Iterator[ProgressCallback]:
    words = TextColumn("{task.description}", markup=False)
    columns = (BarColumn(), MofNCompleteColumn(), _TimeLeft(), words)
    with Progress(*columns, console=console, transient=True) as progress:
        task = progress.add_task("starting", total=None, until=None)

        def update_bar(
            what: str, done: int = 0, total: int = 0, left_s: float | None = None
        ) -> None:
            until = None if left_s is None else time.monotonic() + left_s
            progress.update(
                task, description=what, completed=done, total=total or None, until=until
            )

        yield update_bar


class _TimeLeft(ProgressColumn):
    """Column of a progress bar: the time that is left, counted down since it was worked out."""

    def render(self, task: Task) -> Text:
        until = task.fields["until"]
        return Text("" if until is None else f"{_format_duration(until - time.monotonic())} left")


@contextmanager
def _lines(about: str, quiet_s: float) -> Iterator[ProgressCallback]:
    due = time.monotonic() + quiet_s

    def print_progress(
        what: str, done: int = 0, total: int = 0, left_s: float | None = None
    ) -> None:
        nonlocal due
        if time.monotonic() >= due:
            left = "" if left_s is None else f"{_format_duration(left_s)} left, "
            count = f"{done} of {total} tasks done, " if total else ""
            print(f"{about}: {count}{left}{what}", file=sys.stderr)
            due = time.monotonic() + EVERY_S

    yield print_progress


def _format_duration(seconds: float) -> str:
    """A rough time in words, such as ``about 20 s`` or ``about 3 min``."""
    if seconds < IN_MINUTES_S:
        return f"about {max(1, round(seconds))} s"
    return f"about {round(seconds / 60)} min"

"""A progress bar on standard error for long work under way."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    ProgressColumn,
    Task,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)
from rich.text import Text

if TYPE_CHECKING:
    from crosscheck.run import Told


@contextmanager
def progress_bar() -> Iterator[Callable[[str, int, int], None]]:
    """A function to tell what is being done, how much is done, of how much.

    The bar disappears at the end, and is not drawn where nobody would see it move.
    """
    with _bar(TimeElapsedColumn()) as told:
        yield told


@contextmanager
def _bar(*more: ProgressColumn) -> Iterator[Callable[[str, int, int], None]]:
    columns = (TextColumn("{task.description}", markup=False), BarColumn(), MofNCompleteColumn())
    console = Console(stderr=True)
    hidden = not console.is_interactive
    bar = Progress(*columns, *more, console=console, transient=True, disable=hidden)
    with bar as progress:
        task = progress.add_task("starting", total=None)
        doing = ""

        def told(what: str, done: int, total: int) -> None:
            nonlocal doing
            if what != doing and doing:  # another rate
                progress.reset(task)
            doing = what
            progress.update(task, description=what, completed=done, total=total)

        yield told


@contextmanager
def members_bar() -> Iterator[Callable[[str, int, int], None]]:
    """The same, with how many are done in a second and the time that is left."""
    with _bar(_Rate(), TimeRemainingColumn(elapsed_when_finished=True)) as told:
        yield told


class _Rate(ProgressColumn):
    """How many are done in a second."""

    def render(self, task: Task) -> Text:
        return Text(f"{task.speed:,.0f}/s" if task.speed else "")


@contextmanager
def shown_progress() -> Iterator[Told]:
    """What to hand to cross_check as ``told``."""
    total = 0
    with progress_bar() as bar:

        def told(what: str, left: int) -> None:
            nonlocal total
            total = max(total, left)
            bar(what, total - left, total)

        yield told

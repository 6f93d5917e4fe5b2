"""A progress bar on standard error for long work under way."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from crosscheck.run import Told


@contextmanager
def progress_bar() -> Iterator[Callable[[str, int, int], None]]:
    """A function to tell what is being done, how much is done, of how much.

    The bar disappears at the end, and is not drawn where nobody would see it move.
    """
    columns = (TextColumn("{task.description}", markup=False), BarColumn(), MofNCompleteColumn())
    console = Console(stderr=True)
    hidden = not console.is_interactive
    bar = Progress(*columns, TimeElapsedColumn(), console=console, transient=True, disable=hidden)
    with bar as progress:
        task = progress.add_task("starting", total=None)

        def told(what: str, done: int, total: int) -> None:
            progress.update(task, description=what, completed=done, total=total)

        yield told


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

"""A progress bar on standard error for a cross-check under way."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from crosscheck.run import Told


@contextmanager
def shown_progress() -> Iterator[Told]:
    """What to hand to cross_check as ``told``; the bar disappears at the end."""
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn())
    console = Console(stderr=True)
    with Progress(*columns, TimeElapsedColumn(), console=console, transient=True) as progress:
        task = progress.add_task("states", total=None)
        total = 0

        def told(what: str, left: int) -> None:
            nonlocal total
            total = max(total, left)
            progress.update(task, description=what, total=total, completed=total - left)

        yield told

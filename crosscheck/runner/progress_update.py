"""Progress reports: the task under way, and the time that it still takes."""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from crosscheck.runner.outcomes import Task

ENOUGH = 0.1  # share of declared costs that is done before a time left is worked out


class ProgressCallback(Protocol):
    """Hears what is being done, pieces done, of how many, and seconds left (None if unknown)."""

    def __call__(
        self, what: str, done: int = 0, total: int = 0, left_s: float | None = None, /
    ) -> None: ...


def ignore_progress(*progress: object) -> None:
    """Tell nobody of the progress."""


class TimeEstimate:
    """An estimate of how long tasks still take.

    Declared costs say what share is done, and the time that this took how long the rest takes.
    """

    def __init__(self, tasks: Sequence[Task]) -> None:
        self.costs = {task.key: task.cost for task in tasks}
        self.whole = sum(self.costs.values())
        self.done = 0.0
        self.began = time.monotonic()

    def finish(self, key: object) -> None:
        """Count a task as done, by its key."""
        self.done += self.costs[key]

    @property
    def left_s(self) -> float | None:
        """Estimated time that is left [s]; None before enough is done."""
        if self.done <= ENOUGH * self.whole:
            return None
        return (self.whole - self.done) * (time.monotonic() - self.began) / self.done

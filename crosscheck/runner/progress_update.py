"""Progress reports: the task under way, and the time that it still takes."""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from crosscheck.runner.outcomes import Task

# Declared costs are believed as much as what so many seconds [s] of work have shown.
BELIEVED_S = 5.0


class ProgressCallback(Protocol):
    """Hears what is being done, pieces done, of how many, and seconds left (None if unknown)."""

    def __call__(
        self, what: str, done: int = 0, total: int = 0, left_s: float | None = None, /
    ) -> None: ...


def ignore_progress(*progress: object) -> None:
    """Tell nobody of the progress."""


class TimeEstimate:
    """An estimate of how long tasks on so many processes still take.

    It is made from their declared costs, and from the time that those of them took which are done.
    """

    def __init__(self, tasks: Sequence[Task], jobs: int) -> None:
        self.costs = {task.key: task.cost for task in tasks}
        self.whole = sum(self.costs.values())
        self.jobs = jobs
        self.done = 0.0
        self.began = time.monotonic()

    def finish(self, key: object) -> None:
        """Count a task as done, by its key."""
        self.done += self.costs[key]

    @property
    def left_s(self) -> float:
        """Estimated time that is left [s]."""
        spent = time.monotonic() - self.began + BELIEVED_S
        return max(0.0, self.whole - self.done) * spent / (self.done + self.jobs * BELIEVED_S)

"""What a piece of work in another process is, and why one may have no result."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

DIED = "Died"  # of whatever has no result because its process ended


@dataclass(frozen=True)
class Failure:
    """Why there is no result: the exception's name and message; the traceback of a user's code.

    unfinished: whether the work was stopped before it had an answer, right or wrong.
    """

    kind: str
    message: str
    trace: str = ""
    unfinished: bool = False

    def __str__(self) -> str:
        return f"{self.kind}: {self.message}" if self.message else self.kind


def failure(error: BaseException) -> Failure:
    """Of an exception, its text on one line."""
    return Failure(type(error).__name__, " ".join(str(error).split()))


class Task(Protocol):
    """A piece of work for another process, rough seconds long; ``key`` is unlike all others'."""

    @property
    def key(self) -> Any: ...

    @property
    def cost(self) -> float: ...

    def perform(self) -> Any: ...

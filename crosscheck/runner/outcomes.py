"""Tasks that run in other processes, and the failures by which one has no result."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import wraps
from typing import TYPE_CHECKING, Any, Protocol, Self, TypeAlias, TypeVar

from crosscheck.models.errors import describe_error

if TYPE_CHECKING:
    import numpy as np
    import xarray as xr

Outcome: TypeAlias = "xr.Dataset | np.ndarray | Failure"  # of work on a model

Worker = TypeVar("Worker")
Result = TypeVar("Result")
DIED = "Died"  # kind of failure if a task's process ended without a result


@dataclass(frozen=True)
class Failure:
    """Why there is no result: the exception's name and message; the traceback of a user's code.

    unfinished: whether the work was stopped before it had an answer, right or wrong; place: the
    state at which the exception was raised, in words.
    """

    kind: str
    message: str
    trace: str = ""
    unfinished: bool = False
    place: str = ""

    def __str__(self) -> str:
        return f"{self.reason} ({self.place})" if self.place else self.reason

    @property
    def reason(self) -> str:
        """The failure in words, without its place."""
        return f"{self.kind}: {self.message}" if self.message else self.kind


def failure_from_error(error: BaseException) -> Failure:
    """The Failure of an exception, its text on one line."""
    kind, _, message = describe_error(error).partition(": ")
    return Failure(kind, message)


def return_failures(work: Callable[[Worker], Result]) -> Callable[[Worker], Result | Failure]:
    """The work, made to return what it raises as a Failure: a failed check, not a crash."""

    @wraps(work)
    def perform(self: Worker) -> Result | Failure:
        try:
            return work(self)
        except BaseException as error:  # also SystemExit and KeyboardInterrupt out of a model
            return failure_from_error(error)

    return perform


class SelfKeyedTask:
    """A task that is its own key: its fields differ from those of all others."""

    @property
    def key(self) -> Self:
        """The task's key: the task itself."""
        return self


@dataclass(frozen=True)
class FunctionTask(SelfKeyedTask):
    """A task: a function with its arguments; ``cost``: estimated [s]."""

    function: Callable[..., Any]
    arguments: tuple[Any, ...]
    cost: float = 1.0

    def perform(self) -> Any:
        """What the function returns."""
        return self.function(*self.arguments)


class Task(Protocol):
    """A piece of work for another process; ``key``: unique; ``cost``: estimated [s]."""

    @property
    def key(self) -> Any: ...

    @property
    def cost(self) -> float: ...

    def perform(self) -> Any: ...

"""Batches on the processes of this machine: tasks go out, and each comes back with its result."""

from __future__ import annotations

import hashlib
import platform
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import cache
from typing import Any, ClassVar

from crosscheck import __version__
from crosscheck.models.errors import Unfinished
from crosscheck.provenance import find_version
from crosscheck.registry import MODELS, model_names, reference_model, second_engine
from crosscheck.runner.outcomes import DIED, Failure
from crosscheck.runner.sources import compute_code_hash
from crosscheck.runner.workers import Workers
from crosscheck.studies.batches.batch import prepare_worker

BATCH = "crosscheck.studies.batches.batch"  # module whose code, with all its imports, makes a batch
ATTEMPTS = 3  # attempts at a batch whose worker dies
BATCH_S = 60.0  # rough cost of a batch [s]: a user's function may be slow


@dataclass(frozen=True)
class FunctionTask:
    """A function of a module with its arguments; key: unique, made from the content."""

    key: str
    function: Callable[..., Any]
    arguments: tuple[Any, ...]
    cost: ClassVar[float] = BATCH_S

    def perform(self) -> Any:
        """The function's result in a process of this machine, or the error that it raised."""
        prepare_worker()
        try:
            return self.function(*self.arguments)
        except Exception as error:
            return _TaskError(error)


@dataclass(frozen=True)
class _TaskError:
    error: Exception


class _TaskQueue:
    """Tasks not yet begun, and those to be tried again, which come first."""

    def __init__(self, tasks: Iterable[FunctionTask]) -> None:
        self.tasks, self.retries = iter(tasks), list[FunctionTask]()
        self.running: dict[str, FunctionTask] = {}

    def __iter__(self) -> Iterator[FunctionTask]:
        return self

    def __next__(self) -> FunctionTask:
        work = self.retries.pop() if self.retries else next(self.tasks)
        self.running[work.key] = work
        return work


def perform_tasks(
    workers: Workers, tasks: Iterable[FunctionTask]
) -> Iterator[tuple[FunctionTask, Any]]:
    """Perform tasks; yields each with its result, as they finish.

    Raises the error of a task, and Unfinished for one that did not finish.
    """
    waiting, tries = _TaskQueue(tasks), Counter[str]()
    for key, result in workers.stream(waiting):
        work = waiting.running.pop(key)
        if isinstance(result, _TaskError):
            raise result.error
        if isinstance(result, Failure):
            tries[key] += 1
            if result.kind != DIED or tries[key] == ATTEMPTS:
                often = f" in {ATTEMPTS} attempts" if result.kind == DIED else ""
                reason = f"{result}{often}"
                raise Unfinished(f"a batch came to no end: {reason}; --resume goes on")
            waiting.retries.append(work)
            continue
        yield work, result


@cache
def compute_fingerprint() -> str:
    """Versions that this process runs, as text: equal where a study gives the same numbers."""
    names = reference_model(), second_engine(), *model_names("robot")[:2]
    run_by = [MODELS[name] for name in names]
    packages = sorted({name for entry in run_by for name in entry.versioned_packages})
    models = [entry.module for entry in run_by]
    parts = [
        f"python {platform.python_version()} {platform.machine()}",
        *(f"{name} {find_version(name) or 'missing'}" for name in packages),
        f"crosscheck {__version__} {compute_code_hash(BATCH, *models)[:16]}",
    ]
    return ", ".join(parts)


def compute_digest(*parts: object) -> str:
    """Digest of all parts, as the key of what depends on them."""
    return hashlib.sha256("\n".join(map(str, parts)).encode()).hexdigest()[:32]

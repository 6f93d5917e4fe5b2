"""Where batches are run, and by which version: on this machine, or on a Dask scheduler's workers.

Both are functions that take tasks and give each with its result, as they come; what is done with
them does not know which it is.
"""

from __future__ import annotations

import hashlib
import logging
import platform
import re
import warnings
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import cache, partial
from itertools import islice
from queue import SimpleQueue
from typing import Any, Protocol

from crosscheck import __version__
from crosscheck.models.errors import InputError, Unfinished, install_extra
from crosscheck.provenance import version
from crosscheck.registry import MODELS, reference_model, second_engine
from crosscheck.runner.outcomes import DIED, Failure
from crosscheck.runner.sources import code_hash
from crosscheck.runner.workers import Workers
from crosscheck.studies.batches.batch import made_ready

BATCH = "crosscheck.studies.batches.batch"  # whose code, and all that it imports, makes a batch
PATIENCE_S = 6.0  # until an unreachable scheduler is given up
AHEAD = 2  # tasks that wait beyond those that run
ATTEMPTS = 3  # at a batch whose worker dies
BATCH_S = 60.0  # rough cost of a batch: a user's function may be slow
START = "dask scheduler --port 8786"
JOIN = "dask worker {address} --nthreads 1"


@dataclass(frozen=True)
class FunctionTask:
    """A function of a module with its arguments; key: unlike all others', by content."""

    key: str
    function: Callable[..., Any]
    arguments: tuple[Any, ...]


# Gives each task with its result, as they come. Raises what a task raised, and Unfinished for one
# that came to no end.
Place = Callable[[Iterable[FunctionTask]], Iterator[tuple[FunctionTask, Any]]]


@contextmanager
def here(jobs: int) -> Iterator[Place]:
    """A place on this machine, with so many processes."""
    with Workers(jobs) as workers:
        yield partial(_by_workers, workers)


@dataclass(frozen=True)
class _Work:
    """A task for a worker of this machine."""

    task: FunctionTask
    cost = BATCH_S

    @property
    def key(self) -> str:
        """The task's key."""
        return self.task.key

    def perform(self) -> Any:
        """The function's result, or the error that it raised."""
        made_ready()
        try:
            return self.task.function(*self.task.arguments)
        except Exception as error:
            return _Raised(error)


@dataclass(frozen=True)
class _Raised:
    error: Exception


class _Waiting:
    """Tasks not yet begun, and those to be tried again, which come first."""

    def __init__(self, tasks: Iterable[FunctionTask]) -> None:
        self.tasks, self.again = iter(tasks), list[_Work]()
        self.given: dict[str, _Work] = {}

    def __iter__(self) -> Iterator[_Work]:
        return self

    def __next__(self) -> _Work:
        work = self.again.pop() if self.again else _Work(next(self.tasks))
        self.given[work.key] = work
        return work


def _by_workers(
    workers: Workers, tasks: Iterable[FunctionTask]
) -> Iterator[tuple[FunctionTask, Any]]:
    waiting, tries = _Waiting(tasks), Counter[str]()
    for key, result in workers.stream(waiting):
        work = waiting.given.pop(key)
        if isinstance(result, _Raised):
            raise result.error
        if isinstance(result, Failure):
            tries[key] += 1
            if result.kind != DIED or tries[key] == ATTEMPTS:
                often = f" in {ATTEMPTS} attempts" if result.kind == DIED else ""
                reason = f"{result}{often}"
                raise Unfinished(f"a batch came to no end: {reason}; --resume goes on")
            waiting.again.append(work)
            continue
        yield work.task, result


class Future(Protocol):
    """What a scheduler hands back for a task: its result to come."""

    def result(self) -> Any: ...

    def add_done_callback(self, fn: Callable[[Any], Any], /) -> None: ...


def _by_futures(
    submit: Callable[[FunctionTask], Future], most: int, tasks: Iterable[FunctionTask]
) -> Iterator[tuple[FunctionTask, Any]]:
    """Each task with its result as it comes; at most so many are handed over at once."""
    waiting, left = iter(tasks), 0
    done: SimpleQueue[tuple[FunctionTask, Future]] = SimpleQueue()

    def give(task: FunctionTask) -> None:
        submit(task).add_done_callback(lambda ended: done.put((task, ended)))

    for task in islice(waiting, most):
        give(task)
        left += 1
    while left:
        try:
            task, future = done.get()
        except KeyboardInterrupt:  # what is done by now is not lost
            while not done.empty():
                task, future = done.get()
                with suppress(Exception):
                    yield task, future.result()
            raise
        result, left = future.result(), left - 1
        del future
        for following in islice(waiting, 1):
            give(following)
            left += 1
        yield task, result


@contextmanager
def cluster(address: str) -> Iterator[Place]:
    """A place on the workers of a Dask scheduler. Raises InputError if it cannot be used."""
    # Host and port; other protocols need more than a name.
    host = r"(?:tcp://)?(?:[\w.-]+|\[[0-9A-Fa-f:.%\w]+\])"
    named = re.fullmatch(rf"{host}:(\d{{1,5}})", address, re.ASCII)
    if named is None or not 0 < int(named[1]) < 65536:
        raise InputError("--scheduler", "", address, "must be tcp://HOST:PORT")
    try:
        import distributed
    except ImportError:
        allowed = f"needs Dask: {install_extra('dask')}"
        raise InputError("--scheduler", "", address, allowed) from None
    # Dask's own remarks would stand between the lines of the progress.
    for name in [*logging.root.manager.loggerDict, "tornado", "asyncio"]:
        if name.partition(".")[0] in ("distributed", "tornado", "asyncio"):
            logging.getLogger(name).setLevel(logging.CRITICAL)
    warnings.filterwarnings("ignore", module="distributed")
    ours = fingerprint()
    with _connected(distributed, address) as client:
        threads = _ready(client, address, ours)

        def submit(task: FunctionTask) -> Future:
            arguments = (ours, task.function, *task.arguments)
            future: Future = client.submit(performed_as, *arguments, key=task.key)
            return future

        try:
            yield partial(_by_futures, submit, threads + max(AHEAD, threads // 2))
        except (distributed.KilledWorker, distributed.client.FutureCancelledError) as error:
            reason = f"{type(error).__name__}: a batch's workers died, or the scheduler did"
            raise Unfinished(f"{address}: {reason}; --resume goes on") from None


@contextmanager
def _connected(distributed: Any, address: str) -> Iterator[Any]:
    try:
        client = distributed.Client(address, timeout=PATIENCE_S, set_as_default=False)
    except (OSError, ValueError, TimeoutError):
        allowed = f"no scheduler answers there; start one with: {START}"
        raise InputError("--scheduler", "", address, allowed) from None
    try:
        yield client
    finally:
        client.close(timeout=1)


def _ready(client: Any, address: str, ours: str) -> int:
    """Prepare the workers; returns their threads. Raises InputError for none or other versions."""
    threads: dict[str, int] = client.nthreads()
    if not threads:
        allowed = f"has no workers; start one with: {JOIN.format(address=address)}"
        raise InputError("--scheduler", "", address, allowed)
    for worker, theirs in client.run(fingerprint, on_error="return").items():
        if not isinstance(theirs, str):
            reason = f"{type(theirs).__name__}: {theirs}"
            allowed = f"cannot run this program, it must be installed there: {reason}"
            raise InputError("--scheduler", "", worker, allowed)
        require_same(ours, theirs, worker)
    client.run(made_ready)
    return sum(threads.values())


@cache
def fingerprint() -> str:
    """Versions that this process runs, as text: equal where a study gives the same numbers."""
    run_by = [MODELS[name] for name in (reference_model(), second_engine())]
    packages = sorted({name for entry in run_by for name in entry.versioned})
    models = [entry.module for entry in run_by]
    parts = [
        f"python {platform.python_version()} {platform.machine()}",
        *(f"{name} {version(name) or 'missing'}" for name in packages),
        f"crosscheck {__version__} {code_hash(BATCH, *models)[:16]}",
    ]
    return ", ".join(parts)


def digest_of(*parts: object) -> str:
    """Digest of all parts, as the key of what depends on them."""
    return hashlib.sha256("\n".join(map(str, parts)).encode()).hexdigest()[:32]


def differs(ours: str, theirs: str) -> str:
    """What two fingerprints have unlike, in words."""
    pairs = zip(ours.split(", "), theirs.split(", "), strict=False)
    return "; ".join(f"{a} here, {b} there" for a, b in pairs if a != b) or "another one"


def require_same(ours: str, theirs: str, worker: str) -> None:
    """Raise InputError unless a worker's fingerprint is the one that is expected."""
    if ours != theirs:
        allowed = f"runs another version: {differs(ours, theirs)}"
        raise InputError("--scheduler", "", worker, allowed)


def performed_as(expected: str, function: Callable[..., Any], *arguments: Any) -> Any:
    """What a function returns, where the versions are the expected ones. Raises InputError."""
    require_same(expected, fingerprint(), f"a worker on {platform.node()}")
    return function(*arguments)

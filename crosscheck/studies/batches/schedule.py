"""Executors of batches: on this machine, or on the workers of a Dask scheduler.

Both are functions that take tasks and yield each with its result, as they finish; their caller
does not know which of them it has.
"""

from __future__ import annotations

import hashlib
import logging
import math
import platform
import re
import time
import warnings
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import cache, partial
from itertools import islice
from queue import Empty, SimpleQueue
from typing import Any, ClassVar, Protocol

from crosscheck import __version__
from crosscheck.models.errors import InputError, Unfinished, format_install_command
from crosscheck.provenance import find_version
from crosscheck.registry import MODELS, model_names, reference_model, second_engine
from crosscheck.runner.outcomes import DIED, Failure
from crosscheck.runner.sources import compute_code_hash
from crosscheck.runner.workers import Workers
from crosscheck.studies.batches.batch import prepare_worker

BATCH = "crosscheck.studies.batches.batch"  # module whose code, with all its imports, makes a batch
CONNECT_TIMEOUT_S = 6.0  # time after which an unreachable scheduler is given up [s]
LOOK_S = 5.0  # time without a result until the scheduler is asked for its workers [s]
REJOIN_S = 30.0  # time for a restarted worker to return [s]
AHEAD = 2  # tasks that are sent beyond the running ones
ATTEMPTS = 3  # attempts at a batch whose worker dies
BATCH_S = 60.0  # rough cost of a batch [s]: a user's function may be slow
START = "dask scheduler --port 8786"
JOIN = "dask worker {address} --nthreads 1"


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


# Yields each task with its result, as they finish. Raises the error of a task, and Unfinished for
# one that did not finish.
BatchExecutor = Callable[[Iterable[FunctionTask]], Iterator[tuple[FunctionTask, Any]]]


@contextmanager
def open_local_executor(jobs: int) -> Iterator[BatchExecutor]:
    """A place on this machine, with so many processes."""
    with Workers(jobs) as workers:
        yield partial(_run_by_workers, workers)


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


def _run_by_workers(
    workers: Workers, tasks: Iterable[FunctionTask]
) -> Iterator[tuple[FunctionTask, Any]]:
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


class Future(Protocol):
    """Future result of a task, as a scheduler returns it."""

    def result(self) -> Any: ...

    def add_done_callback(self, fn: Callable[[Any], Any], /) -> None: ...


def _run_by_futures(
    submit: Callable[[FunctionTask], Future],
    require_workers: Callable[[], None],
    most: int,
    tasks: Iterable[FunctionTask],
) -> Iterator[tuple[FunctionTask, Any]]:
    """Each task with its result as it comes; at most so many are sent at once.

    A scheduler keeps tasks for workers to come. So whenever no result has come for a while,
    ``require_workers`` raises Unfinished where there is nobody left to wait for.
    """
    waiting, left = iter(tasks), 0
    done: SimpleQueue[tuple[FunctionTask, Future]] = SimpleQueue()

    def give(task: FunctionTask) -> None:
        submit(task).add_done_callback(lambda ended: done.put((task, ended)))

    for task in islice(waiting, most):
        give(task)
        left += 1
    while left:
        try:
            task, future = done.get(timeout=LOOK_S)
        except Empty:
            require_workers()
            continue
        except KeyboardInterrupt:  # finished results are not lost
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
def open_cluster_executor(address: str) -> Iterator[BatchExecutor]:
    """A place on the workers of a Dask scheduler. Raises InputError if it cannot be used."""
    # Host and port; other protocols need more than a name.
    host = r"(?:tcp://)?(?:[\w.-]+|\[[0-9A-Fa-f:.%\w]+\])"
    named = re.fullmatch(rf"{host}:(\d{{1,5}})", address, re.ASCII)
    if named is None or not 0 < int(named[1]) < 65536:
        raise InputError("--scheduler", "", address, "must be tcp://HOST:PORT")
    try:
        import distributed
    except ImportError:
        allowed = f"needs Dask: {format_install_command('dask')}"
        raise InputError("--scheduler", "", address, allowed) from None
    # Dask's own remarks would stand between the lines of the progress.
    for name in [*logging.root.manager.loggerDict, "tornado", "asyncio"]:
        if name.partition(".")[0] in ("distributed", "tornado", "asyncio"):
            logging.getLogger(name).setLevel(logging.CRITICAL)
    warnings.filterwarnings("ignore", module="distributed")
    local_fingerprint = compute_fingerprint()
    with _connect(distributed, address) as client:
        threads = _prepare_workers(client, address, local_fingerprint)

        def submit(task: FunctionTask) -> Future:
            arguments = (local_fingerprint, task.function, *task.arguments)
            future: Future = client.submit(run_with_version, *arguments, key=task.key)
            return future

        try:
            crew = _Crew(client.nthreads, address)
            yield partial(_run_by_futures, submit, crew.require, threads + max(AHEAD, threads // 2))
        except (distributed.KilledWorker, distributed.client.FutureCancelledError) as error:
            reason = f"{type(error).__name__}: a batch's workers died, or the scheduler did"
            raise Unfinished(f"{address}: {reason}; --resume goes on") from None


class _Crew:
    """The workers of a scheduler.

    Args:
        threads: Asks for each worker's threads, by the worker's address.
        address: The scheduler's.
    """

    def __init__(self, threads: Callable[[], Mapping[str, int]], address: str) -> None:
        self._threads, self._address, self._absent_since = threads, address, math.inf

    def require(self) -> None:
        """Raise Unfinished where no worker has been there for as long as one takes to come back."""
        now = time.monotonic()
        self._absent_since = math.inf if self._threads() else min(self._absent_since, now)
        if now - self._absent_since >= REJOIN_S:
            line = (
                f"{self._address}: no worker is left; start one with: {JOIN}, and go on by --resume"
            )
            raise Unfinished(line.format(address=self._address))


@contextmanager
def _connect(distributed: Any, address: str) -> Iterator[Any]:
    try:
        client = distributed.Client(address, timeout=CONNECT_TIMEOUT_S, set_as_default=False)
    except (OSError, ValueError, TimeoutError):
        allowed = f"no scheduler answers there; start one with: {START}"
        raise InputError("--scheduler", "", address, allowed) from None
    try:
        yield client
    finally:
        client.close(timeout=1)


def _prepare_workers(client: Any, address: str, local_fingerprint: str) -> int:
    """Prepare the workers; returns their threads. Raises InputError for none or other versions."""
    threads: dict[str, int] = client.nthreads()
    if not threads:
        allowed = f"has no workers; start one with: {JOIN.format(address=address)}"
        raise InputError("--scheduler", "", address, allowed)
    for worker, worker_fingerprint in client.run(compute_fingerprint, on_error="return").items():
        if not isinstance(worker_fingerprint, str):
            reason = f"{type(worker_fingerprint).__name__}: {worker_fingerprint}"
            allowed = f"cannot run this program, it must be installed there: {reason}"
            raise InputError("--scheduler", "", worker, allowed)
        require_same_version(local_fingerprint, worker_fingerprint, worker)
    client.run(prepare_worker)
    return sum(threads.values())


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


def require_same_version(local_fingerprint: str, worker_fingerprint: str, worker: str) -> None:
    """Raise InputError unless a worker's fingerprint is the one that is expected."""
    if local_fingerprint != worker_fingerprint:
        pairs = zip(local_fingerprint.split(", "), worker_fingerprint.split(", "), strict=False)
        differences = "; ".join(f"{a} here, {b} there" for a, b in pairs if a != b) or "another one"
        raise InputError("--scheduler", "", worker, f"runs another version: {differences}")


def run_with_version(expected: str, function: Callable[..., Any], *arguments: Any) -> Any:
    """Call a function if the versions are the expected ones. Raises InputError."""
    require_same_version(expected, compute_fingerprint(), f"a worker on {platform.node()}")
    return function(*arguments)

"""Where batches are run: on this machine, or on the workers of a Dask scheduler.

Both take a task and give a future; what is done with them does not know which it is.
"""

from __future__ import annotations

import logging
import os
import sys
import warnings
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from itertools import islice
from queue import SimpleQueue
from typing import Any, Protocol

from crosscheck.interruption import leftovers
from crosscheck.sweeps.batch import made_ready
from crosscheck.sweeps.version import fingerprint, performed_as, require_same
from crosscheck.workers import settle_down
from models.errors import InputError, Unfinished

PATIENCE_S = 6.0  # until an unreachable scheduler is given up
AHEAD = 2  # tasks that wait beyond those that run
ATTEMPTS = 3  # at a batch whose worker dies
# To its own child process, which cleans up after a program that was stopped, and says so.
QUIET_TRACKER = "ignore:resource_tracker:UserWarning"
START = "dask scheduler --port 8786"
JOIN = "dask worker {address} --nthreads 1"


@dataclass(frozen=True)
class Task:
    """A function of a module with its arguments; key: unlike all others', by content."""

    key: str
    function: Callable[..., Any]
    arguments: tuple[Any, ...]


class Future(Protocol):
    """What a task becomes."""

    def result(self) -> Any: ...

    def add_done_callback(self, fn: Callable[[Any], Any], /) -> None: ...


@dataclass(frozen=True)
class Place:
    """Where tasks are run: how one is handed over, how many may be on their way at once."""

    submit: Callable[[Task], Future]
    most: int
    lost: tuple[type[Exception], ...] = ()


def performed(tasks: Iterable[Task], place: Place) -> Iterator[tuple[Task, Any]]:
    """Each task with its result, as they come; no more wait anywhere than the place allows.

    Raises what a task raised, and Unfinished for one whose workers keep dying.
    """
    waiting = iter(tasks)
    done: SimpleQueue[tuple[Task, Future]] = SimpleQueue()
    tries: dict[str, int] = {}

    def give(task: Task) -> None:
        tries[task.key] = tries.get(task.key, 0) + 1
        future = place.submit(task)
        future.add_done_callback(lambda ended: done.put((task, ended)))

    for task in islice(waiting, place.most):
        give(task)
    while tries:
        try:
            task, future = done.get()
        except KeyboardInterrupt:  # what is done by now is not lost
            while not done.empty():
                task, future = done.get()
                with suppress(Exception):
                    yield task, future.result()
            raise
        try:
            result = future.result()
        except place.lost as error:
            if tries[task.key] == ATTEMPTS:
                reason = f"{type(error).__name__} in {ATTEMPTS} attempts"
                raise Unfinished(f"a batch came to no end: {reason}; --resume goes on") from None
            give(task)
            continue
        del tries[task.key], future
        for following in islice(waiting, 1):
            give(following)
        yield task, result


class _Done:
    """A task that was run when it was handed over."""

    def __init__(self, task: Task) -> None:
        self.task = task

    def result(self) -> Any:
        return self.task.function(*self.task.arguments)

    def add_done_callback(self, fn: Callable[[Any], Any], /) -> None:
        fn(self)


@contextmanager
def here(jobs: int) -> Iterator[Place]:
    """This machine, with so many processes; with one, this process itself."""
    if jobs == 1:
        yield Place(_Done, 1)
        return
    from joblib.externals.loky import get_reusable_executor
    from joblib.externals.loky.process_executor import BrokenProcessPool, TerminatedWorkerError

    if QUIET_TRACKER not in sys.warnoptions:
        sys.warnoptions.append(QUIET_TRACKER)

    def pool() -> Any:  # another one where the last has broken
        return get_reusable_executor(jobs, initializer=settle_down, initargs=(os.getpid(),))

    def submit(task: Task) -> Future:
        future: Future = pool().submit(task.function, *task.arguments)
        return future

    def dismiss() -> None:
        pool().shutdown(wait=False, kill_workers=True)

    leftovers.append(dismiss)
    try:
        for _ in range(jobs):  # while the members are still being checked
            pool().submit(made_ready)
        yield Place(submit, jobs + AHEAD, (BrokenProcessPool, TerminatedWorkerError))
    finally:
        leftovers.remove(dismiss)
        dismiss()


@contextmanager
def cluster(address: str) -> Iterator[Place]:
    """The workers of a Dask scheduler. Raises InputError if it cannot be used."""
    try:
        import distributed
    except ImportError:
        allowed = "needs Dask: pip install 'geararm-crosscheck[dask]'"
        raise InputError("--scheduler", "", address, allowed) from None
    _quiet()
    ours = fingerprint()
    with _connected(distributed, address) as client:
        threads = _ready(client, address, ours)

        def submit(task: Task) -> Future:
            arguments = (ours, task.function, *task.arguments)
            future: Future = client.submit(performed_as, *arguments, key=task.key)
            return future

        try:
            yield Place(submit, threads + max(AHEAD, threads // 2))
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
    """How many threads all workers have. Raises InputError if there are none, or other versions."""
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


def _quiet() -> None:
    """Dask's own remarks would stand between the lines of the progress."""
    for name in [*logging.root.manager.loggerDict, "tornado", "asyncio"]:
        if name.partition(".")[0] in ("distributed", "tornado", "asyncio"):
            logging.getLogger(name).setLevel(logging.CRITICAL)
    warnings.filterwarnings("ignore", module="distributed")

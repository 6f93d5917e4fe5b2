"""Tasks on several processes, none of which can take the others or the program down.

Forked, so that a worker knows every model that its parent does, those made in memory included.
A worker that dies, by a signal or an engine's own exit, or that takes far more processor time than
its task should, costs that task alone. Workers never outlive their parent, nor does what they have
started outlive them, and they are deaf to Ctrl-C, which is for the parent to answer. Pools of the
standard library give up all tasks when one worker dies.
"""

from __future__ import annotations

import faulthandler
import gc
import multiprocessing
import os
import resource
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from multiprocessing.context import ForkProcess
from operator import length_hint
from typing import Any, Self

from crosscheck.runner import cpu_limit
from crosscheck.runner.cpu_limit import CpuTimeLimit
from crosscheck.runner.interruption import SIGNALS, cleanup_callbacks
from crosscheck.runner.outcomes import DIED, Failure, Task, failure_from_error
from crosscheck.runner.process_tree import (
    FORK_GUARD,
    ProcessorTimes,
    adopt_orphans,
    describe_end,
    end_descendants,
    end_with_parent,
    excess_reason,
    measure_processor_times,
)

FORK = multiprocessing.get_context("fork")
CLOSING_S = 5.0  # time between the end of a process's pipes and its own end [s]
# A worker is alone for so much processor time [s], which others take to begin, or so long [s].
ALONE_S, WAITED_S = 1.0, 10.0
LEAVING_S = 1.0  # time for an idle worker to exit by itself [s]


def perform_all(tasks: Sequence[Task], jobs: int) -> dict[Any, Any]:
    """All results by key, in the tasks' order; no two tasks have one key."""
    with Workers(min(jobs, len(tasks))) as workers:
        results = workers.perform(tasks)
    return {task.key: results[task.key] for task in tasks}


@dataclass
class _Worker:
    """A worker: its process, the pipe to it, its task, and why that must be stopped."""

    process: ForkProcess
    pipe: Connection
    task: Task | None = None
    time_limit: CpuTimeLimit | None = None
    stop_reason: str = ""

    @property
    def number(self) -> int:
        """Number of the worker's process."""
        assert self.process.pid is not None  # it has been started
        return self.process.pid

    def is_overdue(self, times: ProcessorTimes) -> bool:
        """Whether the worker's task must be stopped."""
        assert self.time_limit is not None  # those at work alone are looked at
        self.stop_reason = self.time_limit.stop_reason(times) or excess_reason(self.number)
        return bool(self.stop_reason)

    def dismiss(self) -> None:
        """End the worker: by its own exit if it is idle, so that whatever traces it can write."""
        if self.task is None:
            end_descendants(self.number)
            with suppress(OSError):  # it has died idle
                self.pipe.send(None)
            self.process.join(LEAVING_S)
        self.kill()

    def kill(self) -> None:
        if self.process.is_alive():
            with suppress(OSError):
                os.kill(self.number, signal.SIGSTOP)  # so that it starts no more
            end_descendants(self.number)
        self.process.kill()
        self.process.join()
        self.pipe.close()


class Workers:
    """Up to ``jobs`` forked worker processes; as a context, it leaves none behind.

    One worker begins alone. Others join it once it has been at work for a while and more is left
    than done: what takes a second in all is done sooner than they could start.
    """

    def __init__(self, jobs: int) -> None:
        self.jobs, self.most = jobs, min(jobs, 1)
        self.crew: list[_Worker] = []
        self.begun = time.monotonic()
        self.looks = self.begun + cpu_limit.LOOK_S  # when those at work are looked at next

    def __enter__(self) -> Self:
        cleanup_callbacks.append(self._dismiss)
        return self

    def __exit__(self, *error: object) -> None:
        cleanup_callbacks.remove(self._dismiss)
        self._dismiss()

    def _dismiss(self) -> None:
        while self.crew:
            self.crew.pop().dismiss()

    def perform(self, tasks: Sequence[Task]) -> dict[Any, Any]:
        """Results by key."""
        return dict(self.stream_longest_first(tasks))

    def stream_longest_first(
        self, tasks: Sequence[Task], on_begin: Callable[[Any], None] = lambda key: None
    ) -> Iterator[tuple[Any, Any]]:
        """Each task's key and result as it ends, the longest begun first; see ``stream``."""
        longest_first = sorted(tasks, key=lambda task: task.cost, reverse=True)
        return self.stream(iter(longest_first), on_begin)

    def stream(
        self, waiting: Iterator[Task], on_begin: Callable[[Any], None] = lambda key: None
    ) -> Iterator[tuple[Any, Any]]:
        """Each task's key and result as it ends; ``on_begin`` receives the key as it begins.

        A task whose worker died or was too slow has a Failure. Whoever takes a result may take
        some time over it: the workers go on meanwhile. A KeyboardInterrupt is raised once what has
        ended by then is passed on.
        """
        given, done = self._employ(waiting), 0
        while any(worker.task is not None for worker in self.crew):
            for key in given:
                on_begin(key)
            try:
                finished = self._wait_for_finished()
            except KeyboardInterrupt:
                ready = [w for w in self.crew if w.task is not None and w.pipe.poll()]
                yield from [*map(self._take_result, ready)]
                raise
            done += len(finished)
            if not finished and length_hint(waiting, done + 1) > done:
                self.most = self.jobs
            ended = [*map(self._take_result, finished)]
            given = self._employ(waiting)
            yield from ended
            given += self._employ(waiting)  # what whoever was handed a result has added

    def _take_result(self, worker: _Worker) -> tuple[Any, Any]:
        task = worker.task
        assert task is not None  # only those at work can have finished
        return task.key, self._result(worker)

    def _employ(self, waiting: Iterator[Task]) -> list[Any]:
        """Give idle workers the next tasks, hire while there are any; returns the tasks' keys."""
        idle = [worker for worker in self.crew if worker.task is None]
        given = []
        while idle or len(self.crew) < self.most:
            task = next(waiting, None)
            if task is None:
                break
            worker = idle.pop() if idle else self._start_worker()
            worker.task, worker.stop_reason = task, ""
            worker.time_limit = CpuTimeLimit(worker.number, task.cost)
            with suppress(OSError):  # it has died idle, and will be found dead
                worker.pipe.send(task)
            given.append(task.key)
        return given

    def _start_worker(self) -> _Worker:
        here, there = FORK.Pipe()
        process = FORK.Process(target=_serve, args=(there, os.getpid()), daemon=True)
        # No signal in between, when the child would still answer it as its parent does.
        signal.pthread_sigmask(signal.SIG_BLOCK, SIGNALS)
        try:
            process.start()
        finally:
            signal.pthread_sigmask(signal.SIG_UNBLOCK, SIGNALS)
        there.close()
        worker = _Worker(process, here)
        self.crew.append(worker)
        return worker

    def _wait_for_finished(self) -> list[_Worker]:
        """The workers that have a result, are dead, or must be stopped.

        None where a worker has been at work alone for a while.
        """
        busy = [worker for worker in self.crew if worker.task is not None]
        events = [w.pipe for w in busy] + [w.process.sentinel for w in busy]
        while True:
            if time.monotonic() >= self.looks:
                times, self.looks = measure_processor_times(), time.monotonic() + cpu_limit.LOOK_S
                if over := [worker for worker in busy if worker.is_overdue(times)]:
                    return over
                was_long = sum(times.values()) >= ALONE_S or self.looks > self.begun + WAITED_S
                if was_long and self.most < self.jobs:
                    return []
            ready = wait(events, timeout=max(0.0, self.looks - time.monotonic()))
            if ready:
                return [w for w in busy if w.pipe in ready or w.process.sentinel in ready]

    def _result(self, worker: _Worker) -> Any:
        """Result from a worker, or a Failure if it sent none; it is then dismissed."""
        worker.task = None
        try:
            if worker.pipe.poll():
                return worker.pipe.recv()
        except (EOFError, OSError):
            pass
        except Exception as error:  # a result that cannot be put together again here
            return failure_from_error(error)
        self.crew.remove(worker)
        worker.process.join(0 if worker.stop_reason else CLOSING_S)
        worker.kill()
        if worker.stop_reason:
            return Failure("TooSlow", worker.stop_reason, unfinished=True)
        how = describe_end(worker.process.exitcode)
        return Failure(DIED, f"the process of the model {how}")


def _serve(pipe: Connection, parent: int) -> None:
    """Live as a worker: receive tasks, send their results."""
    settle_down(parent)
    worker = os.getpid()
    while True:
        try:
            task: Task | None = pipe.recv()
        except (EOFError, OSError):
            os._exit(0)
        if task is None:  # it is no longer needed
            os._exit(0)
        try:
            result = task.perform()
        except BaseException as error:  # also what is no Exception ends a task, not a worker
            result = failure_from_error(error)
        if os.getpid() != worker:  # the task has forked, and this is its other branch
            os._exit(0)
        try:
            pipe.send(result)
        except Exception as error:  # a result that cannot be sent
            pipe.send(failure_from_error(error))


def settle_down(parent: int) -> None:
    """Make this process a worker: end with the parent, leave signals to it, write nothing.

    The parent's objects stay as they are, so that the memory that they are in stays shared. The
    process leaves no core file.
    """
    gc.freeze()
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, SIGNALS)
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    faulthandler.disable()
    adopt_orphans()
    end_with_parent()
    FORK_GUARD.is_active = True
    threading.Thread(target=_watch, args=(parent,), daemon=True).start()
    nowhere = os.open(os.devnull, os.O_RDWR)
    for stream in (0, 1, 2):
        os.dup2(nowhere, stream)
    sys.stdin, sys.stdout, sys.stderr = os.fdopen(0), os.fdopen(1, "w"), os.fdopen(2, "w")


def _watch(parent: int) -> None:
    """End with the parent where the kernel does not see to it."""
    while os.getppid() == parent:
        time.sleep(1)
    os._exit(1)

"""Cuts a study's members into batches, by the study alone, and performs them on this machine."""

from __future__ import annotations

import hashlib
import math
import platform
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any, ClassVar

import numpy as np

from crosscheck import __version__
from crosscheck.models.errors import Unfinished
from crosscheck.provenance import find_version
from crosscheck.registry import MODELS, model_names, reference_model, second_engine
from crosscheck.runner.outcomes import DIED, Failure
from crosscheck.runner.sources import compute_code_hash
from crosscheck.runner.workers import Workers
from crosscheck.studies.batches.batch import Numbers, prepare_worker, run_batch, run_check
from crosscheck.studies.definition import quantities
from crosscheck.studies.measures.columns import Column
from crosscheck.studies.measures.measurement import list_signals
from crosscheck.studies.members.members import PreparedStudy

BATCH = "crosscheck.studies.batches.batch"  # module whose code, with all its imports, makes a batch
ATTEMPTS = 3  # attempts at a batch whose worker dies
TASK_S = 60.0  # rough cost of a batch [s]: a user's function may be slow
STEP_S = 1e-8  # roughly, of a step for each mesh of a member among others
BATCH_S = 3.0  # work in one batch [s]
FEWEST = 16  # batches, where each still fills the lanes: what several workers share
LANES = 32
MOST_BYTES = 200e6  # memory for signals that are kept whole meanwhile


@dataclass(frozen=True)
class BatchTask:
    """A task on members: a function with its arguments; key: unique, made from the content."""

    key: str
    function: Callable[..., Any]
    arguments: tuple[Any, ...]
    cost: ClassVar[float] = TASK_S

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


class _TaskStack(list[BatchTask]):
    """Tasks not yet begun, of which the last comes first: one that is tried again is added."""

    def __iter__(self) -> Iterator[BatchTask]:
        return self

    def __next__(self) -> BatchTask:
        if not self:
            raise StopIteration
        return self.pop()


def perform_tasks(workers: Workers, tasks: Sequence[BatchTask]) -> Iterator[tuple[BatchTask, Any]]:
    """Perform tasks; yields each with its result, as they finish.

    Raises the error of a task, and Unfinished for one that did not finish.
    """
    by_key, waiting = {task.key: task for task in tasks}, _TaskStack(tasks[::-1])
    tries = Counter[str]()
    for key, result in workers.stream(waiting):
        if isinstance(result, _TaskError):
            raise result.error
        if isinstance(result, Failure):
            tries[key] += 1
            if result.kind != DIED or tries[key] == ATTEMPTS:
                often = f" in {ATTEMPTS} attempts" if result.kind == DIED else ""
                raise Unfinished(f"a batch came to no end: {result}{often}; --resume goes on")
            waiting.append(by_key[key])
        else:
            yield by_key[key], result


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


def make_batch_tasks(study: PreparedStudy, version: str) -> list[BatchTask]:
    """Tasks that run all members, in the grid's C order; version: a part of their keys.

    arguments: (text, place of the first member, place behind the last).
    """
    size, digest = batch_size(study), study.digest
    ends = ((begin, min(begin + size, study.count)) for begin in range(0, study.count, size))
    return [
        BatchTask(compute_digest(digest, version, *each), run_batch, (study.text, *each))
        for each in ends
    ]


def make_check_tasks(study: PreparedStudy, version: str) -> list[BatchTask]:
    """Tasks by which a second engine runs evenly chosen members again; arguments: (text, place)."""
    count = min(study.definition.spot_checks, study.count)
    places = [(2 * number + 1) * study.count // (2 * count) for number in range(count)]
    return [
        BatchTask(compute_digest(study.digest, version, "check", p), run_check, (study.text, p))
        for p in places
    ]


def batch_size(study: PreparedStudy) -> int:
    """Number of members in a batch: some seconds of work, full lanes, bounded memory."""
    case = study.base
    meshes = case.mesh_count or 1
    for_time = min(BATCH_S / (case.scenario.steps * meshes * STEP_S), study.count / FEWEST)
    by_memory = MOST_BYTES / max(1.0, _kept_bytes(study))
    size = max(LANES * math.ceil(for_time / LANES), LANES)
    return max(1, min(size, int(by_memory), study.count))


def _kept_bytes(study: PreparedStudy) -> float:
    """Bytes of the signals that one member keeps while its batch runs, and of what is made of them.

    Each may be copied once, with numbers for all planets.
    """
    base, measured = study.base, study.definition.quantities
    record = 8.0 * (base.scenario.steps // base.scenario.stride + 1) * len(base.planet_counts)
    names = {name for quantity in measured for name in list_signals(quantity, base)}
    planets = max(1, *base.planet_counts)
    is_every = [name.planet is None and name.name in quantities.MESH_SIGNALS for name in names]
    rigid = sum(isinstance(each, quantities.RigidDeviation) for each in measured)
    return 2 * record * (sum(planets if every else 1 for every in is_every) + rigid)


def pack_numbers(numbers: Numbers, columns: Sequence[Column]) -> bytes:
    """The numbers as the bytes that are kept: one column behind the other."""
    arrays = [np.ascontiguousarray(numbers[column.name], np.float64) for column in columns]
    return b"".join(array.tobytes() for array in arrays)


def unpack_numbers(content: bytes, columns: Sequence[Column], members: int) -> Numbers:
    """The numbers of so many members, by column, from the bytes kept. Raises ValueError."""
    sizes = [members * math.prod(column.shape) for column in columns]
    numbers = np.frombuffer(content, np.float64)
    if numbers.size != sum(sizes):
        raise ValueError(f"holds {numbers.size} numbers, {sum(sizes)} are needed")
    parts = np.split(numbers, np.cumsum(sizes)[:-1])
    return {
        column.name: part.reshape(members, *column.shape)
        for column, part in zip(columns, parts, strict=True)
    }

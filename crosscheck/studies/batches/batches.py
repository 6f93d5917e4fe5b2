"""Cuts a study's members into batches, by the study alone, so that a resumed run fits."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from crosscheck.studies.batches.batch import Numbers, run_batch, run_check
from crosscheck.studies.batches.schedule import FunctionTask, compute_digest
from crosscheck.studies.definition import quantities
from crosscheck.studies.measures.columns import Column
from crosscheck.studies.members.members import PreparedStudy

STEP_S = 1e-8  # roughly, of a step for each mesh of a member among others
BATCH_S = 3.0  # work in one batch [s]
FEWEST = 16  # batches, where each still fills the lanes: what several workers share
LANES = 32
MOST_BYTES = 200e6  # memory for signals that are kept whole meanwhile


class MemberBatch(NamedTuple):
    """A batch: members from one place to before another, in the grid's C order; key: its digest."""

    key: str
    begin: int
    end: int


def split_into_batches(study: PreparedStudy, version: str) -> Iterator[MemberBatch]:
    """All batches of a study, in order; version: a part of their keys."""
    size = batch_size(study)
    for begin in range(0, study.count, size):
        end = min(begin + size, study.count)
        yield MemberBatch(compute_digest(study.digest, version, begin, end), begin, end)


def make_batch_task(study: PreparedStudy, batch: MemberBatch) -> FunctionTask:
    """The task that runs a batch."""
    return FunctionTask(batch.key, run_batch, (study.text, batch.begin, batch.end))


def make_check_tasks(study: PreparedStudy, version: str) -> list[FunctionTask]:
    """Tasks by which a second engine runs evenly chosen members again; arguments: (text, place)."""
    count = min(study.definition.spot_checks, study.count)
    places = [(2 * number + 1) * study.count // (2 * count) for number in range(count)]
    return [
        FunctionTask(compute_digest(study.digest, version, "check", p), run_check, (study.text, p))
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
    """Bytes of the signals that one member keeps while its batch runs."""
    scenario, joints = study.base.scenario, len(study.base.planet_counts)
    record = 8.0 * (scenario.steps // scenario.stride + 1) * joints
    planets = max(1, *study.base.planet_counts)
    whole = quantities.SpectralPeak | quantities.BandRms | quantities.RigidDeviation
    total = 0.0
    for quantity in study.definition.quantities:
        if isinstance(quantity, whole):
            total += 2 * record
        elif isinstance(quantity, quantities.Trajectories):
            total += 3 * record * len(quantity.signals) * planets
        elif isinstance(quantity, quantities.Function):
            total += 2 * record * (4 + 6 * planets)
    return total


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

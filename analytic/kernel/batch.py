"""Models of one structure, side by side in blocks of lanes, stepped and recorded together."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from typing import NamedTuple, Protocol

import numpy as np

from crosscheck.analytic.kernel.numbers import Numbers
from crosscheck.analytic.kernel.program import (
    RUNS,
    STATE,
    Program,
    RecordMap,
    build_steps_program,
    compile_program,
)
from crosscheck.analytic.kernel.structure import Structure
from crosscheck.models.experiment.drive import TABLE, DriveData, table_torques
from crosscheck.models.experiment.scenario import Scenario

BLOCK_LANES = 8  # lanes of a block: as many numbers as the widest registers hold
CACHE_LINE = 64  # alignment of blocks [bytes]: no load spans two lines of the cache


class Records(NamedTuple):
    """States q, v and accelerations a (records, n, members), in the coordinates of the layout.

    forces (records, meshes, members): elastic force per planet [N], in the order of Gears.
    """

    q: np.ndarray
    v: np.ndarray
    a: np.ndarray
    forces: np.ndarray


class SteppedEquations(ABC):
    """Equations that a kernel runs, in a layout's coordinates unless they say otherwise."""

    @property
    @abstractmethod
    def structure(self) -> Structure:
        """Structure that the kernel's text depends on."""

    @property
    @abstractmethod
    def numbers(self) -> Numbers:
        """The numbers that the text needs, by name, in SI units."""

    def record_map(self) -> RecordMap:
        """The layout's coordinates by the kernel's."""
        return tuple((place,) for place in range(len(self.structure.coordinates)))

    def to_kernel(self, x: np.ndarray) -> np.ndarray:
        """Coordinates or rates x (..., n) of the layout as the kernel's."""
        return x


class SteppedModel(Protocol):
    """Equations in an experiment that a kernel steps; edges (meshes,) [m]: half clearances."""

    @property
    def scenario(self) -> Scenario: ...

    @property
    def drive(self) -> DriveData: ...

    @property
    def equations(self) -> SteppedEquations: ...

    @property
    def edges(self) -> np.ndarray: ...

    def start(self) -> tuple[np.ndarray, np.ndarray]: ...


class Batch:
    """Models of one structure, step and drive table, at least one, stepped from their starts.

    What one member does is not changed by the others: they share no number. What it does is bit for
    bit the same at every number of lanes.
    """

    def __init__(
        self, models: Sequence[SteppedModel], lanes: int = BLOCK_LANES, level: int = RUNS
    ) -> None:
        """Compile the models' kernel; level: of its optimisation."""
        first = models[0]
        self.models, self.step_s = models, first.scenario.step_s
        self.structure = first.equations.structure
        record_map = first.equations.record_map()
        self.program = build_steps_program(self.structure, record_map, lanes, level)
        self.code = compile_program(self.program)
        self.step_count = 0  # steps
        blocks = -(-len(models) // lanes)
        self.work = make_aligned_zeros(blocks, self.program.rows * lanes)
        # Spare lanes repeat the last member.
        members = np.minimum(np.arange(blocks * lanes), len(models) - 1)
        columns = self._columns()[members].reshape(blocks, lanes, self.program.rows)
        self.work[:] = columns.swapaxes(1, 2).reshape(self.work.shape)

    def _columns(self) -> np.ndarray:
        """All rows of the members at their starts (members, rows): state, forces and numbers."""
        equations = self.models[0].equations
        starts = equations.to_kernel(np.array([model.start() for model in self.models]))
        q, v = starts.swapaxes(0, 1)
        state = {"q": q, "v": v, "stage_q": q, "stage_v": v}
        rows = [state.get(name, 0 * q) for name in STATE]
        forces = np.zeros((len(q), len(self.structure.meshes)))
        numbers = [
            np.concatenate(number_rows(self.program, model.equations.numbers))
            for model in self.models
        ]
        return np.concatenate([*rows, forces, numbers], axis=1)

    def advance(self, records: int, stride: int) -> Records:
        """Run so many records, each ``stride`` steps after the one before; the first is of now.

        With stride 0 the batch stays where it is.
        """
        lanes, (blocks, _) = self.program.lanes, self.work.shape
        first, n = self.models[0], len(self.structure.coordinates)
        times, torques = contiguous_table(first.drive)
        table = np.zeros(len(torques))
        rows = 3 * n + len(self.structure.meshes)
        out = np.empty((records, rows, blocks * lanes))
        self.code["advance"](
            self.work.ctypes.data,
            blocks,
            self.step_count,
            records,
            stride,
            self.step_s,
            times.ctypes.data,
            torques.ctypes.data,
            times.size,
            table.ctypes.data,
            out.ctypes.data,
        )
        self.step_count += records * stride
        return Records(*np.split(out[:, :, : len(self.models)], (n, 2 * n, 3 * n), axis=1))

    def run(self, records: int, stride: int, most: int) -> Iterator[Records]:
        """Run so many records, at most ``most`` at a time, and by itself the one where they end."""
        while records:
            part = min(records, most)
            yield self.advance(part, stride)
            records -= part
        yield self.advance(1, 0)


def number_rows(program: Program, numbers: Numbers) -> list[np.ndarray]:
    """A model's numbers in the order of a program's rows."""
    single = np.array([numbers[name] for name in program.numbers])
    return [single, *(np.asarray(numbers[name]) for name, _ in program.tables)]


def look_up_torques(drive: DriveData, t: float) -> np.ndarray:
    """A table's torques (joints,) [N m] at a time [s]; of other laws nothing is looked up."""
    return table_torques(drive, t) if drive.code == TABLE else np.zeros(len(drive.gains))


def contiguous_table(drive: DriveData) -> tuple[np.ndarray, np.ndarray]:
    """Times (rows,) [s] and torques (joints, rows) [N m] as a kernel reads them."""
    return np.ascontiguousarray(drive.table_time), np.ascontiguousarray(drive.table_torque)


def make_aligned_zeros(blocks: int, size: int) -> np.ndarray:
    """Zeros (blocks, size) that begin at a line of the cache."""
    room = np.zeros(blocks * size + CACHE_LINE // 8)
    first = -room.ctypes.data % CACHE_LINE // 8
    return room[first : first + blocks * size].reshape(blocks, size)

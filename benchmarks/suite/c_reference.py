"""The C references: compiled for an arm's structure, and called."""

from __future__ import annotations

import ctypes
import os
import shutil
import subprocess
import tempfile
from collections.abc import Sequence
from functools import cache
from pathlib import Path

import numpy as np

from benchmarks.suite.c_numbers import layout_of, numbers_of, state_of, structure_of
from crosscheck.analytic.model import AnalyticModel

SOURCES = Path(__file__).parent.parent / "c"
FLAGS = ("-O3", "-march=native", "-shared", "-fPIC")
LANES = 8  # of a vector
ALIGNED = 64  # bytes of a vector
DOUBLES = ctypes.POINTER(ctypes.c_double)


class NoCompiler(Exception):
    """There is no C compiler, or it cannot compile the references; says why."""


def compiler() -> str:
    """The C compiler: $CC, or cc. Raises NoCompiler."""
    found = shutil.which(os.environ.get("CC", "cc"))
    if found is None:
        raise NoCompiler("no C compiler (cc)")
    return found


def compiler_version() -> str:
    """First line of what it says of itself. Raises NoCompiler."""
    command = [compiler(), "--version"]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout.split("\n")[0]


@cache
def library(source: str, macros: tuple[str, ...]) -> ctypes.CDLL:
    """A source of benchmarks/c compiled and loaded. Raises NoCompiler."""
    with tempfile.TemporaryDirectory() as folder:
        made = Path(folder) / "arm.so"
        command = [compiler(), *FLAGS, *macros, str(SOURCES / source), "-o", str(made), "-lm"]
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode:
            raise NoCompiler(done.stderr.strip().split("\n")[0])
        loaded = ctypes.CDLL(str(made))
    loaded.integrate.argtypes = [DOUBLES, DOUBLES, ctypes.c_double, *[ctypes.c_long] * 2, DOUBLES]
    loaded.integrate.restype = None
    return loaded


def aligned(*shape: int) -> np.ndarray:
    """Zeros that begin where a vector may."""
    size = int(np.prod(shape))
    room = np.zeros(size + ALIGNED // 8)
    first = -room.ctypes.data % ALIGNED // 8
    return room[first : first + size].reshape(shape)


def _pointer(array: np.ndarray) -> object:
    return array.ctypes.data_as(DOUBLES)


class Scalar:
    """One trajectory of a model's scenario by arm.c. Raises NoCompiler, NotCovered."""

    def __init__(self, model: AnalyticModel) -> None:
        self.model, self.scenario = model, model.scenario
        self.library = library("arm.c", tuple(structure_of(model).macros()))
        self.numbers = np.ascontiguousarray(numbers_of(model))
        assert self.library.size() == self.numbers.size
        self.start = np.ascontiguousarray(state_of(model, np.array(model.start())))
        records = self.scenario.steps // self.scenario.stride + 1
        self.records = aligned(records, *self.start.shape)

    def run(self) -> None:
        """Once, into ``records``."""
        scenario = self.scenario
        data = map(_pointer, (self.numbers, self.start))
        plan = scenario.step_s, scenario.steps, scenario.stride
        self.library.integrate(*data, *plan, _pointer(self.records))

    def states(self) -> tuple[np.ndarray, np.ndarray]:
        """(q, v) (records, n) in the model's coordinates."""
        found = layout_of(self.model, self.records)
        return found[:, 0], found[:, 1]


class Vectors:
    """LANES * vectors trajectories side by side by arm_simd.c, of models of the same structure.

    Raises NoCompiler, NotCovered.
    """

    def __init__(self, models: Sequence[AnalyticModel]) -> None:
        assert len(models) % LANES == 0
        self.models, self.scenario = models, models[0].scenario
        vectors = len(models) // LANES
        macros = (*structure_of(models[0]).macros(), f"-DVECTORS={vectors}")
        self.library = library("arm_simd.c", macros)
        numbers = np.array([numbers_of(model) for model in models])
        assert self.library.size() == numbers.shape[1]
        starts = np.array([state_of(model, np.array(model.start())) for model in models])
        self.numbers, self.start = _by_vector(numbers, vectors), _by_vector(starts, vectors)
        records = self.scenario.steps // self.scenario.stride + 1
        self.records = aligned(vectors, records, *starts.shape[1:], LANES)

    def run(self) -> None:
        """Once, into ``records``."""
        scenario = self.scenario
        data = map(_pointer, (self.numbers, self.start))
        plan = scenario.step_s, scenario.steps, scenario.stride
        self.library.integrate(*data, *plan, _pointer(self.records))

    def states(self, member: int) -> tuple[np.ndarray, np.ndarray]:
        """(q, v) (records, n) of one, in its model's coordinates."""
        vector, lane = divmod(member, LANES)
        found = layout_of(self.models[member], self.records[vector, ..., lane])
        return found[:, 0], found[:, 1]


def _by_vector(values: np.ndarray, vectors: int) -> np.ndarray:
    """Of (members, ...) an aligned (vectors, ..., LANES)."""
    shape = values.shape[1:]
    out = aligned(vectors, *shape, LANES)
    out[:] = np.moveaxis(values.reshape(vectors, LANES, *shape), 1, -1)
    return out

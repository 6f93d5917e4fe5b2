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

from benchmarks.suite.c_numbers import collect_numbers, layout_of, make_structure, state_of
from crosscheck.analytic.model import AnalyticModel

SOURCES = Path(__file__).parent.parent / "c"
FLAGS = ("-O3", "-march=native", "-shared", "-fPIC")
LANES = 8  # of a vector
ALIGNMENT = 64  # bytes of a vector
DOUBLES = ctypes.POINTER(ctypes.c_double)


class NoCompiler(Exception):
    """There is no C compiler, or it cannot compile the references; says why."""


def find_compiler() -> str:
    """The C compiler: $CC, or cc. Raises NoCompiler."""
    path = shutil.which(os.environ.get("CC", "cc"))
    if path is None:
        raise NoCompiler("no C compiler (cc)")
    return path


def compiler_version() -> str:
    """First line of what it says of itself. Raises NoCompiler."""
    command = [find_compiler(), "--version"]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout.split("\n")[0]


@cache
def load_library(source: str, macros: tuple[str, ...]) -> ctypes.CDLL:
    """A source of benchmarks/c compiled and loaded. Raises NoCompiler."""
    with tempfile.TemporaryDirectory() as folder:
        made = Path(folder) / "arm.so"
        command = [find_compiler(), *FLAGS, *macros, str(SOURCES / source), "-o", str(made), "-lm"]
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode:
            raise NoCompiler(done.stderr.strip().split("\n")[0])
        loaded = ctypes.CDLL(str(made))
    loaded.integrate.argtypes = [DOUBLES, DOUBLES, ctypes.c_double, *[ctypes.c_long] * 2, DOUBLES]
    loaded.integrate.restype = None
    return loaded


def make_aligned_zeros(*shape: int) -> np.ndarray:
    """Zeros that begin where a vector may."""
    size = int(np.prod(shape))
    room = np.zeros(size + ALIGNMENT // 8)
    first = -room.ctypes.data % ALIGNMENT // 8
    return room[first : first + size].reshape(shape)


def _pointer(array: np.ndarray) -> object:
    return array.ctypes.data_as(DOUBLES)


class ScalarRun:
    """One trajectory of a model's scenario by arm.c. Raises NoCompiler, NotCovered."""

    def __init__(self, model: AnalyticModel) -> None:
        self.model, self.scenario = model, model.scenario
        self.library = load_library("arm.c", tuple(make_structure(model).macros()))
        self.numbers = np.ascontiguousarray(collect_numbers(model))
        assert self.library.size() == self.numbers.size
        self.start = np.ascontiguousarray(state_of(model, np.array(model.start())))
        records = self.scenario.steps // self.scenario.stride + 1
        self.records = make_aligned_zeros(records, *self.start.shape)

    def run(self) -> None:
        """Once, into ``records``."""
        scenario = self.scenario
        data = map(_pointer, (self.numbers, self.start))
        plan = scenario.step_s, scenario.steps, scenario.stride
        self.library.integrate(*data, *plan, _pointer(self.records))

    def states(self) -> tuple[np.ndarray, np.ndarray]:
        """(q, v) (records, n) in the model's coordinates."""
        coordinates = layout_of(self.model, self.records)
        return coordinates[:, 0], coordinates[:, 1]


class VectorRun:
    """LANES * vectors trajectories side by side by arm_simd.c, of models of the same structure.

    Raises NoCompiler, NotCovered.
    """

    def __init__(self, models: Sequence[AnalyticModel]) -> None:
        assert len(models) % LANES == 0
        self.models, self.scenario = models, models[0].scenario
        vectors = len(models) // LANES
        macros = (*make_structure(models[0]).macros(), f"-DVECTORS={vectors}")
        self.library = load_library("arm_simd.c", macros)
        numbers = np.array([collect_numbers(model) for model in models])
        assert self.library.size() == numbers.shape[1]
        starts = np.array([state_of(model, np.array(model.start())) for model in models])
        self.numbers, self.start = (
            _group_by_vector(numbers, vectors),
            _group_by_vector(starts, vectors),
        )
        records = self.scenario.steps // self.scenario.stride + 1
        self.records = make_aligned_zeros(vectors, records, *starts.shape[1:], LANES)

    def run(self) -> None:
        """Once, into ``records``."""
        scenario = self.scenario
        data = map(_pointer, (self.numbers, self.start))
        plan = scenario.step_s, scenario.steps, scenario.stride
        self.library.integrate(*data, *plan, _pointer(self.records))

    def states(self, member: int) -> tuple[np.ndarray, np.ndarray]:
        """(q, v) (records, n) of one, in its model's coordinates."""
        vector, lane = divmod(member, LANES)
        coordinates = layout_of(self.models[member], self.records[vector, ..., lane])
        return coordinates[:, 0], coordinates[:, 1]


def _group_by_vector(values: np.ndarray, vectors: int) -> np.ndarray:
    """Of (members, ...) an aligned (vectors, ..., LANES)."""
    shape = values.shape[1:]
    out = make_aligned_zeros(vectors, *shape, LANES)
    out[:] = np.moveaxis(values.reshape(vectors, LANES, *shape), 1, -1)
    return out

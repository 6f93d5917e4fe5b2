"""The result of a study as NetCDF: made at full size, filled with batches as they come."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import h5netcdf
import h5py
import numpy as np

from crosscheck.provenance import provenance
from crosscheck.sweeps.axes import SAMPLE, START, Varied
from crosscheck.sweeps.batch import Numbers
from crosscheck.sweeps.columns import Column
from crosscheck.sweeps.members import Study
from models.errors import InputError
from models.trajectory import recorded_times

SCHEMA_VERSION = 1
CHECKED = "checked"
STUDY, VERSION = "study_sha256", "made_by"
NUMBER_BYTES = 8


def expected_bytes(study: Study, columns: Sequence[Column]) -> int:
    """Size of a result's numbers."""
    each = sum(int(np.prod(column.shape, dtype=object)) for column in columns)
    return study.count * each * NUMBER_BYTES


def blocks(
    begin: int, end: int, shape: Sequence[int]
) -> Iterator[tuple[tuple[slice, ...], int, int]]:
    """The rectangles that places begin to end of a grid in C order make up, with their places."""
    if begin >= end:
        return
    if not shape:
        yield (), begin, end
        return
    row = int(np.prod(shape[1:], dtype=object))
    first, last = begin // row, (end - 1) // row
    if first == last and (begin % row or (end - 1) % row != row - 1):
        inside = blocks(begin - first * row, end - first * row, shape[1:])
        for rest, a, b in inside:
            yield (slice(first, first + 1), *rest), a + first * row, b + first * row
        return
    head = begin if begin % row == 0 else min((first + 1) * row, end)
    tail = end - end % row
    yield from blocks(begin, head, shape) if head > begin else ()
    if tail > head:
        full = tuple(slice(0, size) for size in shape[1:])
        yield (slice(head // row, tail // row), *full), head, tail
    yield from blocks(max(tail, head), end, shape)


class ResultFile:
    """A result that is being made in a file of any name."""

    def __init__(self, path: Path, study: Study, columns: Sequence[Column], version: str) -> None:
        self.study, self.columns = study, {column.name: column for column in columns}
        self.file = h5netcdf.File(path, "w", locking=False)  # the draft's writer has it locked
        self.file.attrs.update(_attributes(study, version))
        self._coordinates()
        for column in columns:
            self._variable(column, tuple(study.dimensions))

    def close(self) -> None:
        """All that was written is in the file."""
        self.file.close()

    def write(self, begin: int, numbers: Numbers) -> None:
        """Members from a place on."""
        for name, values in numbers.items():
            variable = self.file[name]
            for where, first, after in blocks(begin, begin + len(values), self.study.shape):
                part = values[first - begin : after - begin]
                sizes = [there.stop - there.start for there in where]
                rest = tuple(slice(0, size) for size in values.shape[1:])
                variable[(*where, *rest)] = part.reshape((*sizes, *values.shape[1:]))

    def spread(self, name: str) -> np.ndarray:
        """Largest less smallest of what all members have of a column, of the column's shape."""
        values = self.file[name][...].reshape(self.study.count, *self.columns[name].shape)
        some = np.isfinite(values).any(axis=0)
        high = np.where(np.isfinite(values), values, -np.inf).max(axis=0)
        low = np.where(np.isfinite(values), values, np.inf).min(axis=0)
        return np.where(some, high, np.nan) - np.where(some, low, np.nan)

    def values_at(self, name: str, place: int) -> np.ndarray:
        """What a member has of a column."""
        where = tuple(self.study.points(place).values())
        return np.asarray(self.file[name][where] if where else self.file[name][...])

    def add_checks(self, places: Sequence[int], engine: str) -> None:
        """Room for what a second engine says of members at these places."""
        self.file.dimensions[CHECKED] = len(places)
        self._coordinate(CHECKED, (CHECKED,), np.array(places), "", f"member that {engine} ran too")
        for dimension in self.study.dimensions:
            points = np.array([self.study.points(place)[dimension] for place in places])
            meaning = f"its place along {dimension}, from 0"
            self._coordinate(f"{CHECKED}_{dimension}", (CHECKED,), points, "", meaning)

    def add(self, column: Column, values: np.ndarray) -> None:
        """A variable over the members that were checked, (checked, *the column's shape)."""
        self._variable(column, (CHECKED,))
        self.file[column.name][...] = values

    def _coordinates(self) -> None:
        study, file = self.study, self.file
        for dimension, size in study.dimensions.items():
            file.dimensions[dimension] = size
        for axis in study.axes:
            self._axis(axis)
        if SAMPLE in study.dimensions:
            count = np.arange(study.dimensions[SAMPLE])
            self._coordinate(SAMPLE, (SAMPLE,), count, "", "number of the sample, from 0")
        starts = study.definition.starts
        if starts is not None:
            seeds = starts.seed + np.arange(starts.count)
            about = f"seed of the start's perturbation of up to {starts.size_m:g} m"
            self._coordinate(START, (START,), seeds, "", about)
        own = {d: s for c in self.columns.values() for d, s in zip(c.dims, c.shape, strict=True)}
        file.dimensions.update(own)
        for name in ("joint", "planet"):
            if name in own:
                self._coordinate(name, (name,), 1 + np.arange(own[name]), "", f"{name} number")
        if "time" in own:
            time = recorded_times(study.base.scenario)
            self._coordinate("time", ("time",), time, "s", "time")

    def _axis(self, axis: Varied) -> None:
        values = _as_array(axis)
        dims: tuple[str, ...] = (axis.dimension,)
        if values.ndim == 2:  # entries that are given unlike values
            entry = f"{axis.name}_entry"
            self.file.dimensions[entry] = values.shape[1]
            dims = (*dims, entry)
        self._coordinate(axis.name, dims, values, axis.unit, axis.path)

    def _coordinate(
        self, name: str, dims: tuple[str, ...], values: np.ndarray, unit: str, meaning: str
    ) -> None:
        text = values.dtype == object
        dtype = h5py.string_dtype() if text else values.dtype
        made = self.file.create_variable(name, dims, dtype=dtype)
        made[...] = values
        made.attrs.update({"long_name": meaning, **({"units": unit} if unit else {})})

    def _variable(self, column: Column, over: tuple[str, ...]) -> None:
        dims = (*over, *column.dims)
        made = self.file.create_variable(column.name, dims, dtype=np.float64, fillvalue=np.nan)
        made.attrs.update({"units": column.unit, "long_name": column.meaning})
        beside = [a.name for a in self.study.axes if a.dimension == SAMPLE and SAMPLE in dims]
        if beside:  # by which readers find the samples' values
            made.attrs["coordinates"] = " ".join(beside)


def _as_array(axis: Varied) -> np.ndarray:
    """An axis' values: (points,) where all entries are given the same, words where no numbers."""
    if isinstance(axis.values, np.ndarray):
        return axis.values[:, 0] if axis.values.shape[1] == 1 else axis.values
    column = [row[0] for row in axis.values]
    if all(isinstance(value, int | float) and not isinstance(value, bool) for value in column):
        return np.array(column)
    words = [value if isinstance(value, str) else json.dumps(value) for value in column]
    return np.array(words, dtype=object)


def _attributes(study: Study, version: str) -> dict[str, Any]:
    base, definition = study.base, study.definition
    record = provenance(base.arm, 0, False, [base.scenario], base.switches)
    return {
        "Conventions": "CF-1.11",
        "schema_version": SCHEMA_VERSION,
        "title": definition.title or definition.name,
        "study": definition.model_dump_json(),
        STUDY: study.digest,
        VERSION: version,
        "provenance": record.model_dump_json(),
    }


def identity_of(path: Path) -> tuple[str, str]:
    """Digest of the study, and version, that made a file. Raises InputError for any other file."""
    try:
        with h5netcdf.File(path, "r") as file:
            return str(file.attrs[STUDY]), str(file.attrs[VERSION])
    except (OSError, KeyError, ValueError):
        raise InputError(str(path), "", None, "is no result of a study") from None

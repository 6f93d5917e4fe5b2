"""The result of a study as NetCDF: laid out at full size, filled with batches as they come.

HDF5 does not survive a disk that becomes full, so it is never let near one: it lays a file out in
memory, where only what it writes takes room, and the numbers are written by their places.
"""

from __future__ import annotations

import io
import json
import math
from collections.abc import Iterator, Sequence
from typing import Any

import h5netcdf
import h5py
import numpy as np

from crosscheck.models.errors import InputError
from crosscheck.models.trajectory import recorded_times
from crosscheck.output import Draft
from crosscheck.provenance import record_provenance
from crosscheck.studies.batches.batch import Numbers
from crosscheck.studies.definition.axes import RESERVED_NAMES, SAMPLE, START, VariedAxis
from crosscheck.studies.measures.columns import DIVERGED, Column
from crosscheck.studies.members.members import PreparedStudy

SCHEMA_VERSION = 1
CHECKED = "checked"
STUDY, VERSION = "study_sha256", "made_by"
NUMBER_BYTES = 8
PAGE = 1 << 16


def expected_bytes(study: PreparedStudy, columns: Sequence[Column]) -> int:
    """Size of a result's numbers [bytes]."""
    return study.count * sum(map(_size, columns)) * NUMBER_BYTES


def _size(column: Column) -> int:
    """The count of numbers that a member has in a column."""
    return math.prod(column.shape)


def spot_check_columns(columns: Sequence[Column], engine: str) -> list[Column]:
    """Columns of a second engine's values and differences, over the members that are checked."""
    new_columns = []
    for column in columns:
        name, unit, about = column.name, column.unit, f"{column.name} by {engine}"
        if "time" in column.dims:
            over = column.dims[1:], column.shape[1:]
            worst = f"largest difference of {about} over the run"
            new_columns.append(Column(f"{name}_difference", unit, worst, *over))
            continue
        over = column.dims, column.shape
        new_columns.append(Column(f"{name}_checked", unit, about, *over))
        new_columns.append(Column(f"{name}_difference", unit, f"{about}, distance", *over))
        if name != DIVERGED:
            meaning = f"{about}, distance over spread"
            new_columns.append(Column(f"{name}_difference_over_spread", "1", meaning, *over))
    return new_columns


def require_unique_names(study: PreparedStudy, columns: Sequence[Column]) -> None:
    """Raise InputError unless every variable and dimension has a name of its own."""
    all_columns = [*columns, *spot_check_columns(columns, study.base.second_model)]
    axis_names = {name for axis in study.axes for name in (axis.name, f"{axis.name}_entry")}
    names = [
        *RESERVED_NAMES,
        *axis_names,
        *(f"{CHECKED}_{dimension}" for dimension in study.dimensions),
    ]
    names += [column.name for column in all_columns]
    for name in names:
        if names.count(name) > 1:
            allowed = "more than one has this name; give each a name of its own"
            raise InputError(study.file, "quantities", name, allowed)


class ResultFile:
    """A result that is being made in a draft, where all its numbers have their places.

    checks: members that a second engine runs too. Raises OSError where there is no room for it.
    """

    def __init__(
        self, new: Draft, study: PreparedStudy, columns: Sequence[Column], checks: Sequence[int],
        version: str,
    ) -> None:  # fmt: skip
        self.new, self.study, self.checks = new, study, checks
        self.columns = {column.name: column for column in columns}
        self.engine = study.base.second_model
        extra = spot_check_columns(columns, self.engine) if checks else []
        self.over_checks = {column.name: column for column in extra}
        memory = _Sparse()
        with h5netcdf.File(memory, "w") as file:
            self._fill(file, version)
        with h5py.File(memory, "r") as file:  # where each variable's first number is
            names = (*self.columns, *self.over_checks)
            self.places = {name: file[name].id.get_offset() for name in names}
        new.reserve(memory.size)
        for number, page in sorted(memory.pages.items()):
            new.write_at(number * PAGE, bytes(page[: memory.size - number * PAGE]))

    def write(self, begin: int, numbers: Numbers) -> None:
        """Write the numbers of members from a place on. Raises OSError."""
        for name, column in self.columns.items():
            self._put(name, begin * _size(column), numbers[name])

    def add(self, name: str, values: np.ndarray) -> None:
        """Write a variable over the members that are checked, (checked, *the column's shape)."""
        self._put(name, 0, values)

    def spread(self, name: str) -> np.ndarray:
        """Largest less smallest value of a column over all members, of the column's shape."""
        values = self.numbers(name, 0, self.study.count)
        some = np.isfinite(values).any(axis=0)
        high = np.where(np.isfinite(values), values, -np.inf).max(axis=0)
        low = np.where(np.isfinite(values), values, np.inf).min(axis=0)
        return np.where(some, high, np.nan) - np.where(some, low, np.nan)

    def _put(self, name: str, first: int, values: np.ndarray) -> None:
        """Write numbers of a variable, from one of them on; members stand in the grid's C order."""
        content = np.ascontiguousarray(values, dtype=np.float64).tobytes()
        self.new.write_at(self.places[name] + first * NUMBER_BYTES, content)

    def numbers(self, name: str, place: int, members: int) -> np.ndarray:
        """Values of members from a place on, (members, *the column's shape)."""
        column = self.columns[name]
        count = members * _size(column)
        offset = self.places[name] + place * _size(column) * NUMBER_BYTES
        values = np.fromfile(self.new.path, np.float64, count, offset=offset)
        return values.reshape(members, *column.shape)

    def _fill(self, file: h5netcdf.File, version: str) -> None:
        """Lay out the file: everything but the numbers of its columns."""
        self.file = file
        base, definition = self.study.base, self.study.definition
        record = record_provenance(base.mechanism, 0, False, [base.scenario], base.switches)
        file.attrs.update(
            {
                "Conventions": "CF-1.11",
                "schema_version": SCHEMA_VERSION,
                "title": definition.title or definition.name,
                "study": definition.model_dump_json(),
                STUDY: self.study.digest,
                VERSION: version,
                "provenance": record.model_dump_json(),
            }
        )
        self._coordinates()
        if self.checks:
            self._check_places()
        for column in self.columns.values():
            self._variable(column, tuple(self.study.dimensions))
        for column in self.over_checks.values():
            self._variable(column, (CHECKED,))

    def _check_places(self) -> None:
        """Write which members a second engine runs."""
        self.file.dimensions[CHECKED] = len(self.checks)
        meaning = f"member that {self.engine} ran too"
        self._coordinate(CHECKED, (CHECKED,), np.array(self.checks), "", meaning)
        for dimension in self.study.dimensions:
            points = np.array([self.study.points(place)[dimension] for place in self.checks])
            meaning = f"its place along {dimension}, from 0"
            self._coordinate(f"{CHECKED}_{dimension}", (CHECKED,), points, "", meaning)

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
        dimension_sizes = {
            d: s for c in self.columns.values() for d, s in zip(c.dims, c.shape, strict=True)
        }
        file.dimensions.update(dimension_sizes)
        for name in ("joint", "planet"):
            if name in dimension_sizes:
                self._coordinate(
                    name, (name,), 1 + np.arange(dimension_sizes[name]), "", f"{name} number"
                )
        if "time" in dimension_sizes:
            time = recorded_times(study.base.scenario)
            self._coordinate("time", ("time",), time, "s", "time")

    def _axis(self, axis: VariedAxis) -> None:
        """Write an axis' values, (points,) where all entries get the same; words if no numbers."""
        dims: tuple[str, ...] = (axis.dimension,)
        if isinstance(axis.values, np.ndarray):
            values = axis.values
            if values.shape[1] == 1:
                values = values[:, 0]
            else:
                entry = f"{axis.name}_entry"
                self.file.dimensions[entry] = values.shape[1]
                dims = (*dims, entry)
        else:
            given = [row[0] for row in axis.values]
            if all(isinstance(v, int | float) and not isinstance(v, bool) for v in given):
                values = np.array(given)
            else:
                words = [value if isinstance(value, str) else json.dumps(value) for value in given]
                values = np.array(words, dtype=object)
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
        """Create a variable of numbers, whose place is kept free for them."""
        dims = (*over, *column.dims)
        kept_free = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
        kept_free.set_alloc_time(h5py.h5d.ALLOC_TIME_EARLY)
        kept_free.set_fill_time(h5py.h5d.FILL_TIME_NEVER)
        made = self.file.create_variable(
            column.name, dims, np.float64, fillvalue=np.nan, dcpl=kept_free
        )
        if not dims:  # h5py takes no such wishes for a single number: it has its place once written
            made[...] = np.nan
        comment = {"comment": column.missing} if column.missing else {}
        made.attrs.update({"units": column.unit, "long_name": column.meaning, **comment})
        beside = [a.name for a in self.study.axes if a.dimension == SAMPLE and SAMPLE in dims]
        if beside:  # the attribute by which readers find the samples' values
            made.attrs["coordinates"] = " ".join(beside)


class _Sparse(io.RawIOBase):
    """A file in memory in which only written parts take room."""

    def __init__(self) -> None:
        self.pages: dict[int, bytearray] = {}
        self.size = self.at = 0

    def seek(self, offset: int, whence: int = io.SEEK_SET) -> int:
        self.at = offset + {io.SEEK_SET: 0, io.SEEK_CUR: self.at, io.SEEK_END: self.size}[whence]
        return self.at

    def tell(self) -> int:
        return self.at

    def truncate(self, size: int | None = None) -> int:
        self.size = self.at if size is None else size
        return self.size

    def readinto(self, buffer: Any) -> int:
        view = memoryview(buffer).cast("B")
        count = max(0, min(len(view), self.size - self.at))
        for begin, page, inside in self._parts(count):
            kept = self.pages.get(page)
            piece = bytes(inside.stop - inside.start) if kept is None else kept[inside]
            view[begin : begin + len(piece)] = piece
        self.at += count
        return count

    def write(self, data: Any) -> int:
        view = memoryview(data).cast("B")
        for begin, page, inside in self._parts(len(view)):
            kept = self.pages.setdefault(page, bytearray(PAGE))
            kept[inside] = view[begin : begin + inside.stop - inside.start]
        self.at += len(view)
        self.size = max(self.size, self.at)
        return len(view)

    def _parts(self, count: int) -> Iterator[tuple[int, int, slice]]:
        """Pieces of the next ``count`` bytes: (first byte, number of its page, slice of it)."""
        done = 0
        while done < count:
            page, first = divmod(self.at + done, PAGE)
            last = min(PAGE, first + count - done)
            yield done, page, slice(first, last)
            done += last - first

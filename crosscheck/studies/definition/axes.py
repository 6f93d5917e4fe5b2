"""The axes of a study: the entries that each one varies, and their values."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from crosscheck.models.arm.arm import Arm
from crosscheck.models.arm.quantities import Data
from crosscheck.models.errors import InputError
from crosscheck.models.experiment.scenario import Scenario, Switches
from crosscheck.models.paths import FieldPath, find_paths, format_path, is_path, value_at
from crosscheck.models.robot.file import RobotFile
from crosscheck.schema import FieldDescription, describe_fields
from crosscheck.studies.definition import definition

RECORDS: dict[str | int, type[Data]] = {
    "arm": Arm,
    "robot": RobotFile,
    "scenario": Scenario,
    "switches": Switches,
}
SAMPLE, START = "sample", "start"
RESERVED_NAMES = {SAMPLE, START, "joint", "planet", "time", "checked"}  # dimensions of every result


@dataclass(frozen=True)
class VariedAxis:
    """An axis in numbers: the value of each of its entries at each of its points.

    name: of the result's coordinate; dimension: along which it varies, its own name or SAMPLE;
    values: (points, 1) where all entries share a value, else (points, entries).
    """

    name: str
    dimension: str
    path: str
    unit: str
    entries: tuple[FieldPath, ...]
    values: np.ndarray | tuple[tuple[Any, ...], ...]

    def __len__(self) -> int:
        return len(self.values)

    def entry_values(self, point: int) -> Sequence[Any]:
        """The value of each entry at a point of the axis, as in a file."""
        row = self.values[point]
        plain = row.tolist() if isinstance(row, np.ndarray) else row
        return plain if len(plain) == len(self.entries) else list(plain) * len(self.entries)


def build_axes(
    axes: Sequence[definition.Axis],
    samples: definition.Samples | None,
    data: dict[str, Any],
    file: str,
) -> list[VariedAxis]:
    """All axes of a study; data: of PreparedStudy; file: the study's.

    Raises InputError.
    """
    varied_axes: list[VariedAxis] = []
    sections = varied_sections(data)
    for number, axis in enumerate(axes):
        where, entries = f"{file}: axes[{number}]", list[FieldPath]()
        for path in axis.paths:
            if not is_path(path, sections):
                allowed = f"must be the path of an entry, beginning with {', '.join(sections)}"
                raise InputError(where, "path", path, allowed)
            entries += find_paths(data, path, f"{where}: path")
        varied_axes.append(_build_axis(axis, tuple(entries), samples, data, where))
    _require_distinct(varied_axes, file)
    return varied_axes


def varied_sections(data: dict[str, Any]) -> tuple[str, ...]:
    """Names of the sections of a study's data whose entries can be varied."""
    return tuple(section for section in RECORDS if section in data)


def _build_axis(
    axis: definition.Axis,
    entries: tuple[FieldPath, ...],
    samples: definition.Samples | None,
    data: dict[str, Any],
    where: str,
) -> VariedAxis:
    name = axis.name or str(next(k for k in reversed(entries[0]) if isinstance(k, str)))
    values: np.ndarray | tuple[tuple[Any, ...], ...]
    if isinstance(axis, definition.ListAxis):
        values = tuple((value,) for value in axis.values)
    elif isinstance(axis, definition.GridAxis):
        space = np.geomspace if axis.spacing == "log" else np.linspace
        values = space(axis.start, axis.stop, axis.count)[:, np.newaxis]
    else:
        assert samples is not None  # the definition's own validation
        values = _draw_samples(axis, entries, samples, data, where)
    dimension = SAMPLE if isinstance(axis, definition.SampledAxisBase) else name
    return VariedAxis(name, dimension, ", ".join(axis.paths), _unit(entries[0]), entries, values)


def _unit(place: FieldPath) -> str:
    """Unit of an entry, as the schema states it; empty where none is known."""
    section, *keys = place
    records: list[type[Data]] = [RECORDS[section]]
    fields: list[FieldDescription] = []
    for name in (key for key in keys if isinstance(key, str)):
        below = [f for record in records for f in describe_fields(record) if f.name == name]
        if below:  # else a name of the user's own, of a robot's joint or link
            fields, records = below, [record for field in below for record in field.records]
    return next((field.unit for field in fields if field.unit), "")


def _draw_samples(
    axis: definition.SampledAxis,
    entries: tuple[FieldPath, ...],
    samples: definition.Samples,
    data: dict[str, Any],
    where: str,
) -> np.ndarray:
    """Drawn values, (samples, 1) where one draw serves all entries, else (samples, entries)."""
    count, columns = samples.count, len(entries) if axis.each else 1
    # By the paths alone, so that other axes may come and go beside this one.
    stream = int.from_bytes(hashlib.sha256("\n".join(axis.paths).encode()).digest()[:8])
    generator = np.random.default_rng([samples.seed, stream])
    if isinstance(axis, definition.HypercubeAxis):
        # One sample in each of ``count`` equal parts of the range.
        parts = generator.permuted(np.tile(np.arange(count), (columns, 1)), axis=1).T
        share = (parts + generator.uniform(size=(count, columns))) / count
        if axis.spacing == "log":
            return axis.low * (axis.high / axis.low) ** share
        return axis.low + (axis.high - axis.low) * share
    centres = _centres(axis.centre, entries, data, where)
    if len(set(centres.tolist())) == 1:
        centres = centres[: columns if axis.each else 1]
    if isinstance(axis, definition.NormalAxis):
        draws = generator.standard_normal((count, columns))
        while axis.within_sd is not None and (far := np.abs(draws) > axis.within_sd).any():
            draws[far] = generator.standard_normal(int(far.sum()))
        width, relative = axis.sd, axis.relative_sd
    else:
        draws = generator.uniform(-1, 1, (count, columns))
        width, relative = axis.tolerance, axis.relative_tolerance
    if relative is not None:
        return centres + draws * (np.abs(centres) * relative)
    assert width is not None  # the definition's own validation
    return centres + draws * width


def _centres(
    centre: float | None, entries: tuple[FieldPath, ...], data: dict[str, Any], where: str
) -> np.ndarray:
    """Values that the entries are drawn about, (entries,): the file's own unless given."""
    if centre is not None:
        return np.full(len(entries), centre)
    values = [value_at(data, entry) for entry in entries]
    for entry, centre_value in zip(entries, values, strict=True):
        if not isinstance(centre_value, int | float) or isinstance(centre_value, bool):
            allowed = "the file has no number there to vary about; give the centre"
            raise InputError(where, format_path(entry), centre_value, allowed)
    return np.array(values, dtype=float)


def _require_distinct(axes: Sequence[VariedAxis], file: str) -> None:
    """Raise InputError unless every axis has a name and entries of its own."""
    seen: dict[FieldPath, str] = {}
    names: set[str] = set(RESERVED_NAMES)
    for axis in axes:
        if axis.name in names:
            raise InputError(file, "axes", axis.name, "is taken; give the axis a name of its own")
        names |= {axis.name, f"{axis.name}_entry"}
        for entry in axis.entries:
            if entry in seen:
                raise InputError(
                    file, "axes", format_path(entry), f"is varied by {seen[entry]} already"
                )
            seen[entry] = axis.name

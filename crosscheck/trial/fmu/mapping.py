"""Which variables of an FMU are an arm's coordinates, rates and torques."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from pydantic import Field

from crosscheck.models.arm.arm import Arm
from crosscheck.models.errors import InputError
from crosscheck.models.files import read_toml
from crosscheck.models.loading import validated
from crosscheck.trial.coordinates.frame import frame_of
from crosscheck.trial.fmu.archive import library_of, unpacked
from crosscheck.trial.fmu.description import FmuDescription, described
from crosscheck.trial.input.equations import Coordinates, Level
from crosscheck.trial.tables.coordinates_file import MOST, CoordinatesFile

Variables = Annotated[tuple[str, ...], Field(min_length=1, max_length=MOST)]


class MappingFile(CoordinatesFile):
    """Names of an FMU's variables: coordinates, their rates, the drive's torques."""

    q: Variables
    v: Variables
    torque: Variables


@dataclass(frozen=True)
class MappedUnit:
    """An unpacked FMU and its binary; names of its variables q, v and torque."""

    folder: Path
    library: Path
    description: FmuDescription
    coordinates: Coordinates
    level: Level
    q: tuple[str, ...]
    v: tuple[str, ...]
    torque: tuple[str, ...]

    def references(self, names: tuple[str, ...]) -> list[int]:
        """Of variables."""
        known = {v.name: v.reference for v in self.description.variables}
        return [known[name] for name in names]

    def places(self, names: tuple[str, ...]) -> list[int]:
        """Of continuous states among them."""
        return [self.description.states.index(name) for name in names]


def mapped_unit(path: Path, mapping: Path, arm: Arm, folder: Path) -> MappedUnit:
    """A unit, unpacked into an empty folder, not run. Raises InputError."""
    said = validated(MappingFile, read_toml(mapping), str(mapping))
    unpacked(path, folder)
    description = described(str(path), folder)
    own = Coordinates(**said.model_dump(exclude={"level", "q", "v", "torque"}))
    size = len(frame_of(own, arm).names)
    inputs = tuple(v.name for v in description.variables if v.is_input)
    states, kind = description.states, "a continuous state"
    if description.kind == "co-simulation":
        states, kind = tuple(v.name for v in description.variables), "a real variable"
    _require(mapping, "q", said.q, size, states, kind)
    _require(mapping, "v", said.v, size, states, kind)
    _require(mapping, "torque", said.torque, len(arm.joints), inputs, "a real input")
    library = library_of(str(path), folder, description.identifier)
    return MappedUnit(folder, library, description, own, said.level, said.q, said.v, said.torque)


def _require(
    mapping: Path, field: str, names: tuple[str, ...], count: int, known: tuple[str, ...], kind: str
) -> None:
    """Raise InputError unless these are so many names of the unit's own."""
    if len(names) != count or len(set(names)) < count:
        raise InputError(str(mapping), field, list(names), f"must be {count} names, each once")
    for name in names:
        if name not in known:
            allowed = f"is not {kind} of the unit; there are {', '.join(known) or 'none'}"
            raise InputError(str(mapping), field, name, allowed)

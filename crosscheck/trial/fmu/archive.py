"""An FMU as files, none of its code run: the archive, its description, the mapping to an arm.

The archive is looked at as a whole before anything of it is unpacked.
"""

from __future__ import annotations

import io
import platform
import re
import stat
import zipfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath
from typing import Annotated, Any, Literal

from pydantic import Field

from crosscheck.mechanisms import supply
from crosscheck.models.errors import InputError, describe_error, format_install_command
from crosscheck.models.files import format_toml_fields, read_toml
from crosscheck.models.inputs import read_input
from crosscheck.models.loading import validate_record
from crosscheck.models.mechanism import Mechanism
from crosscheck.runner.isolated_reading import read_in_subprocess
from crosscheck.trial.input.equations import MOST, Coordinates, CoordinatesFile, Level

LARGEST_FILE = 200_000_000  # bytes
MOST_BYTES, MOST_FILES = 500_000_000, 10_000  # unpacked
LARGEST_RATIO = 200  # largest ratio of a good compression; a bomb has a thousand and more
DESCRIPTION = "modelDescription.xml"
LARGEST_DESCRIPTION = 50_000_000
BINARIES = {
    ("Linux", "x86_64"): ("linux64", "x86_64-linux"),
    ("Linux", "aarch64"): ("aarch64-linux",),
    ("Darwin", "arm64"): ("aarch64-darwin", "darwin64"),
}
LIBRARIES = (".so", ".dylib")
EXTRA = f"needs FMPy: {format_install_command('fmu')}"
LONGEST = 200  # characters of a name that is looked at
LARGEST_REFERENCE = 2**32 - 1  # fmi2ValueReference is an unsigned int
Variables = Annotated[tuple[str, ...], Field(min_length=1, max_length=MOST)]


def unpack_fmu(path: Path, folder: Path) -> None:
    """Unpack description, resources and this machine's binaries into an empty folder.

    Raises InputError for what is no FMU, leads out of the folder or grows beyond all measure, when
    nothing is unpacked, and for what cannot be unpacked.
    """
    where = str(path)
    content = read_input(path, LARGEST_FILE)
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            entries = archive.infolist()
            _require_harmless(where, entries)
            prefixes = ("resources/", *(f"binaries/{name}/" for name in _folders()))
            for entry in entries:
                name = entry.filename
                if entry.is_dir() or not (name == DESCRIPTION or name.startswith(prefixes)):
                    continue
                target = folder / name
                target.parent.mkdir(parents=True, exist_ok=True)
                target.touch(0o600, exist_ok=False)  # a binary is code: nobody else may write it
                target.write_bytes(archive.read(entry))
    except (InputError, MemoryError):
        raise
    except OSError as error:  # names that no file can have, or a file where a folder is needed
        raise InputError(where, "", None, f"cannot be unpacked: {error.strerror}") from None
    except Exception as error:  # whatever a damaged archive makes of its reader
        raise InputError(where, "", None, f"is not an FMU: {describe_error(error)}") from None
    description = (folder / DESCRIPTION).read_bytes()
    if b"<!DOCTYPE" in description or b"<!ENTITY" in description or b"\0" in description:
        reason = "must be XML in UTF-8 without definitions of its own"
        raise InputError(where, DESCRIPTION, None, reason)


def _folders() -> tuple[str, ...]:
    return BINARIES.get((platform.system(), platform.machine()), ())


def _require_harmless(where: str, entries: list[zipfile.ZipInfo]) -> None:
    """Raise InputError for an archive that no program should unpack, or that is not an FMU."""
    if len(entries) > MOST_FILES:
        raise InputError(where, "", None, f"holds {len(entries)} files; may hold {MOST_FILES}")
    size = sum(entry.file_size for entry in entries)
    if size > MOST_BYTES:
        raise InputError(where, "", None, f"would unpack to {size} bytes; may have {MOST_BYTES}")
    seen: set[str] = set()
    for entry in entries:
        name = entry.filename
        path = PurePosixPath(name)
        if path.is_absolute() or ".." in path.parts or set("\\:\0") & set(name) or not name:
            raise InputError(where, name, None, "leads out of the folder that it is unpacked into")
        if stat.S_ISLNK(entry.external_attr >> 16):
            raise InputError(where, name, None, "is a link; must be a file")
        if entry.flag_bits & 1:
            raise InputError(where, name, None, "is encrypted")
        if entry.file_size > LARGEST_RATIO * max(entry.compress_size, 1000):
            reason = f"is packed {entry.file_size // max(entry.compress_size, 1)} times; may be"
            raise InputError(where, name, None, f"{reason} {LARGEST_RATIO} times")
        if str(path) in seen:
            raise InputError(where, name, None, "is there twice")
        seen.add(str(path))
    sizes = {entry.filename: entry.file_size for entry in entries if not entry.is_dir()}
    if DESCRIPTION not in sizes:
        raise InputError(where, DESCRIPTION, None, "is missing: this is not an FMU")
    if sizes[DESCRIPTION] > LARGEST_DESCRIPTION:
        raise InputError(where, DESCRIPTION, None, f"has more than {LARGEST_DESCRIPTION} bytes")


@dataclass(frozen=True)
class FmuDescription:
    """An FMU's description of itself.

    version: 2 or 3; kind: Model Exchange, where it has that, or Co-Simulation; references: by which
    FMI calls its real variables, by their names; inputs: names of those that are inputs; states:
    the continuous ones, in the order of their derivatives; rates: by the name of a state, that of
    the one that is its derivative, as far as the unit says so.
    """

    version: int
    kind: Literal["exchange", "co-simulation"]
    identifier: str
    token: str
    references: Mapping[str, int] = field(hash=False)
    inputs: tuple[str, ...]
    states: tuple[str, ...]
    rates: Mapping[str, str] = field(default_factory=dict, hash=False)


def read_description(where: str, folder: Path) -> FmuDescription:
    """Read the description of an unpacked FMU, in a separate process. Raises InputError."""
    description: FmuDescription = read_in_subprocess(where, _parse_description, where, folder)
    if not re.fullmatch(r"[A-Za-z_]\w{,199}", description.identifier, re.ASCII):
        allowed = "must be a name of C with at most 200 characters"
        raise InputError(where, "modelIdentifier", description.identifier, allowed)
    return description


def _parse_description(where: str, folder: Path) -> FmuDescription:
    try:
        from fmpy import read_model_description
    except ImportError:
        raise InputError(where, "", None, EXTRA) from None
    text = (folder / DESCRIPTION).read_bytes()
    version = re.search(rb"fmiVersion\s*=\s*[\"']([^\"']*)", text)
    fmi_version = "" if version is None else version[1].decode("utf-8", "backslashreplace")
    if fmi_version[:2] not in ("2.", "3."):
        raise InputError(where, "fmiVersion", fmi_version, "must be 2.0 or 3.0")
    try:
        # Vendors' annotations break the schema, and nothing of them is read.
        model_description = read_model_description(str(folder), validate=False)
    except Exception as error:
        raise InputError(where, DESCRIPTION, None, _describe_damage(folder, error)) from None
    interface = model_description.modelExchange or model_description.coSimulation
    if interface is None:
        reason = "is neither for Model Exchange nor for Co-Simulation"
        raise InputError(where, "", None, reason)
    for name, value in (
        ("modelIdentifier", interface.modelIdentifier),
        ("guid, or instantiationToken", model_description.guid),
    ):
        if not value:
            raise InputError(where, name, None, "is missing")
    real_variables = [v for v in model_description.modelVariables if v.type in ("Real", "Float64")]
    states = _find_states(where, model_description)
    _require_scalars(where, real_variables, list(states))
    variables = [v for v in real_variables if len(v.name) <= LONGEST and v.name.isprintable()]
    for v in variables:
        if not 0 <= v.valueReference <= LARGEST_REFERENCE:
            allowed = f"must be a whole number from 0 to {LARGEST_REFERENCE}"
            raise InputError(where, f"{v.name}.valueReference", v.valueReference, allowed)
    return FmuDescription(
        version=int(fmi_version[0]),
        kind="exchange" if model_description.modelExchange else "co-simulation",
        identifier=interface.modelIdentifier,
        token=model_description.guid,
        references={v.name: v.valueReference for v in variables if not v.dimensions},
        inputs=tuple(v.name for v in variables if v.causality == "input"),
        states=tuple(states),
        rates=_find_rates(states, {v.name: v for v in real_variables}),
    )


def _describe_damage(folder: Path, error: Exception) -> str:
    """What FMI does not allow in a description that cannot be read, in the words of its schema."""
    from fmpy import read_model_description

    if isinstance(error, SyntaxError):
        return f"is not XML: {error}"
    try:
        read_model_description(str(folder), validate=True)
    except Exception as complaint:  # of the schema, or of what a variable refers to
        error = complaint
    for problem in getattr(error, "problems", [str(error)] if type(error) is Exception else []):
        if "Annotation" not in problem:
            return re.sub(r"^ERROR \((line \d+), column \d+\)", r"\1", problem)
    return "refers to variables or types that it does not hold"


def _find_states(where: str, model_description: Any) -> dict[str, Any]:
    """The continuous states in the order of their derivatives: by name, the derivative's variable.

    Units are about that leave out the attribute derivative, or list states as derivatives. Raises
    InputError for a derivative of nothing that is named.
    """
    variables = model_description.modelVariables
    derivatives = {v.derivative.name: v for v in variables if v.derivative is not None}
    names, unknown_names, states = {v.name for v in variables}, [], dict[str, Any]()
    for variable in (each.variable for each in model_description.derivatives):
        state = variable.derivative.name if variable.derivative is not None else ""
        if not state and variable.name in derivatives:
            state, variable = variable.name, derivatives[variable.name]
        by_name = re.fullmatch(r"der\((.+)\)", variable.name)
        if not state and by_name and by_name[1] in names:
            state = by_name[1]
        if state:
            states.setdefault(state, variable)
        else:
            unknown_names.append(variable.name)
    if unknown_names and model_description.modelExchange:
        reason = (
            f"{', '.join(unknown_names)}: have no attribute derivative, nor a name der(...) of a"
            " variable, so that nothing says which variables are states"
        )
        raise InputError(where, "ModelStructure", None, reason)
    return states


def _require_scalars(where: str, real_variables: Sequence[Any], states: Sequence[str]) -> None:
    """Raise InputError unless states and inputs are single numbers, each of a name of its own."""
    names = [v.name for v in real_variables]
    for variable in real_variables:
        if variable.causality != "input" and variable.name not in states:
            continue
        if variable.dimensions:
            reason = "is an array; a trial takes states and inputs that are single numbers"
            raise InputError(where, variable.name, None, reason)
        if not variable.name or names.count(variable.name) > 1:
            reason = "must be a name, and of one variable alone"
            raise InputError(where, "name of a variable", variable.name, reason)


def _find_rates(states: Mapping[str, Any], variables: Mapping[str, Any]) -> dict[str, str]:
    """The rate of each state that has one: by the reference of its derivative, else by units."""
    references = {variables[each].valueReference: each for each in states if each in variables}
    rates = {
        state: references[derivative.valueReference]
        for state, derivative in states.items()
        if references.get(derivative.valueReference, state) != state
    }
    if not rates:
        units = {each: variables[each].unit or "" for each in states if each in variables}
        per_second = [each for each, unit in units.items() if unit.endswith("/s")]
        others = [each for each in states if each not in per_second]
        if len(others) == len(per_second):
            rates = dict(zip(others, per_second, strict=True))
    return rates


def draft_mapping(name: str, description: FmuDescription) -> str:
    """The text of a draft mapping: states and their rates, by order where no rates are known.

    Raises InputError where these are not as many, or where no torque is an input.
    """
    states, half = description.states, len(description.states) // 2
    q, v = tuple(description.rates), tuple(description.rates.values())
    if not q:
        q, v = states[:half], states[half:]
    if not q or len(q) != len(v) or not description.inputs:
        reason = (
            f"has {len(states)} continuous states and {len(description.inputs)} real inputs, in"
            " which no coordinates, as many rates and torques can be seen: write q, v and torque"
            " of the mapping by hand"
        )
        raise InputError(name, "", None, reason)
    runs = '# The rigid level that a unit for Co-Simulation is compared with.\nlevel = "links"\n'
    fields = "\n".join(format_toml_fields({"q": [*q], "v": [*v], "torque": [*description.inputs]}))
    return (
        f"# Written by crosscheck trial --ask, from what {name} says of itself: check every name.\n"
        "# Coordinates in their order, their rates, and the drive's torques on the output side.\n"
        f"{fields}\n\n"
        '# What q are: gearing = "rigid", "lumped" or "free"; links = "relative" or "absolute";\n'
        '# gears = "displacements" or "angles"; or matrix = [[1, 0], [0, 1]].\n'
        'gearing = "rigid"\n'
        'links = "relative"\n' + runs * (description.kind == "co-simulation")
    )


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
        """The references by which FMI calls the variables of these names."""
        return [self.description.references[name] for name in names]

    def places(self, names: tuple[str, ...]) -> list[int]:
        """The places of the named states among the continuous states, from 0."""
        return [self.description.states.index(name) for name in names]


def load_unit(path: Path, mapping: Path, mechanism: Mechanism, folder: Path) -> MappedUnit:
    """The unit with its mapping, unpacked into an empty folder, not run. Raises InputError."""
    mapping_file = validate_record(MappingFile, read_toml(mapping), str(mapping))
    unpack_fmu(path, folder)
    description = read_description(str(path), folder)
    coordinates = Coordinates(**mapping_file.model_dump(exclude={"level", "q", "v", "torque"}))
    layout = supply("build_frame", mechanism.section)(coordinates, mechanism).layout
    size, joints = len(layout), len(layout.theta)
    states, kind = description.states, "a continuous state"
    if description.kind == "co-simulation":
        states, kind = tuple(description.references), "a real variable"
    _require_names(mapping, "q", mapping_file.q, size, states, kind)
    _require_names(mapping, "v", mapping_file.v, size, states, kind)
    _require_names(
        mapping, "torque", mapping_file.torque, joints, description.inputs, "a real input"
    )
    name = description.identifier
    places = (
        folder / "binaries" / folder_name / f"{name}{end}"
        for folder_name in _folders()
        for end in LIBRARIES
    )
    library = next((place for place in places if place.is_file()), None)
    if library is None:
        machine = f"{platform.system()} {platform.machine()}"
        raise InputError(str(path), "binaries", None, f"holds none of {name} for {machine}")
    names = mapping_file.q, mapping_file.v, mapping_file.torque
    return MappedUnit(folder, library, description, coordinates, mapping_file.level, *names)


def _require_names(
    mapping: Path,
    field: str,
    names: tuple[str, ...],
    count: int,
    available_names: tuple[str, ...],
    kind: str,
) -> None:
    """Raise InputError unless the names are `count` different ones of the unit's own."""
    if len(names) != count or len(set(names)) < count:
        raise InputError(str(mapping), field, list(names), f"must be {count} names, each once")
    for name in names:
        if name not in available_names:
            allowed = f"is not {kind} of the unit; there are {', '.join(available_names) or 'none'}"
            raise InputError(str(mapping), field, name, allowed)

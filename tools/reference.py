"""The tables of fields in docs/reference: `python -m tools.reference`."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

from crosscheck.models.arm.arm import Arm, Direct, Link, Planetary
from crosscheck.models.arm.mesh import Mesh
from crosscheck.models.arm.quantities import Data, format_number
from crosscheck.models.arm.stiffness import (
    FourierStiffness,
    SineStiffness,
    SquareStiffness,
    TableStiffness,
)
from crosscheck.models.experiment.scenario import (
    ConstantDrive,
    PdDrive,
    Scenario,
    SinusoidDrive,
    Start,
    TableDrive,
)
from crosscheck.models.refusals import REFUSALS
from crosscheck.models.robot.file import DirectDrive as DirectTransmission
from crosscheck.models.robot.file import Geared, LinkChange, PlanetaryTransmission, RobotFile
from crosscheck.models.robot.robot import RotorMesh
from crosscheck.output import write_files
from crosscheck.schema import FieldDescription, describe_fields
from crosscheck.studies.definition.definition import (
    Definition,
    GridAxis,
    HypercubeAxis,
    ListAxis,
    NormalAxis,
    Samples,
    StudyStarts,
    UniformAxis,
)
from crosscheck.studies.definition.quantities import (
    BandRms,
    ContactLoss,
    Crossing,
    FinalError,
    Function,
    NoContactShare,
    RigidDeviation,
    Settling,
    Size,
    SpectralPeak,
    Trajectories,
)

DOCS = Path(__file__).parents[1] / "docs" / "reference"
BEGIN, END = "<!-- fields: made by tools.reference -->\n", "<!-- end of fields -->\n"
FILES: dict[str, type[Data]] = {
    "arm-file.md": Arm,
    "scenario-file.md": Scenario,
    "studies.md": Definition,
    "robot-file.md": RobotFile,
}
HEADINGS: dict[type[Data], str] = {
    Arm: "The arm",
    Planetary: "Planetary joint",
    Direct: "Direct joint",
    Link: "Link",
    Mesh: "Mesh",
    SineStiffness: "Stiffness: sine",
    FourierStiffness: "Stiffness: Fourier",
    SquareStiffness: "Stiffness: square",
    TableStiffness: "Stiffness: table",
    Scenario: "The scenario",
    Start: "Start",
    ConstantDrive: "Drive: constant",
    PdDrive: "Drive: PD",
    SinusoidDrive: "Drive: sinusoid",
    TableDrive: "Drive: table",
    Definition: "The study",
    ListAxis: "Axis: list",
    GridAxis: "Axis: grid",
    HypercubeAxis: "Axis: Latin hypercube",
    NormalAxis: "Axis: normal",
    UniformAxis: "Axis: uniform",
    Samples: "Samples of a study",
    StudyStarts: "Starts of a study",
    Size: "Quantity: size",
    BandRms: "Quantity: RMS in a band",
    SpectralPeak: "Quantity: spectral peak",
    FinalError: "Quantity: final error",
    Crossing: "Quantity: crossing",
    Settling: "Quantity: settling",
    ContactLoss: "Quantity: loss of contact",
    NoContactShare: "Quantity: share of time apart",
    RigidDeviation: "Quantity: deviation from a rigid arm",
    Function: "Quantity: function",
    Trajectories: "Quantity: trajectories",
    RobotFile: "The robot",
    DirectTransmission: "Transmission: direct",
    Geared: "Transmission: geared",
    LinkChange: "Change of a link",
    PlanetaryTransmission: "Transmission: planetary",
    RotorMesh: "Mesh of a transmission",
}


def write_reference() -> None:
    """Renew the tables in all files. Raises InputError."""
    write_files({DOCS / name: renew_tables(name) for name in PAGES})


def renew_tables(name: str) -> str:
    """The text of a file of ``PAGES``, with its tables as the code has them now."""
    before, rest = (DOCS / name).read_text(encoding="utf-8").split(BEGIN)
    return before + BEGIN + PAGES[name]() + "\n" + END + rest.split(END)[1]


def format_field_tables(top: type[Data]) -> str:
    """A table of the fields of a record, and of each that it holds."""
    return "".join(f"{line}\n" for record in list_records_below(top) for line in _section(record))


def format_refusals() -> str:
    """A table of what commands, and functions of Python's, do not take of a sort of mechanism."""
    rows = [
        f"| `{each.command}` | `{each.option}` | {each.section} | {each.reason} |"
        for each in REFUSALS
    ]
    return "\n".join(["", "| of | not taken | with | since |", "|---|---|---|---|", *rows, ""])


PAGES: dict[str, Callable[[], str]] = {
    **{name: partial(format_field_tables, record) for name, record in FILES.items()},
    "command-line.md": format_refusals,
}


def list_records_below(record: type[Data]) -> list[type[Data]]:
    """The record and all records that it holds, each once, those above first."""
    records = [record]
    for holder in records:
        below = dict.fromkeys(inner for field in describe_fields(holder) for inner in field.records)
        records += [inner for inner in below if inner not in records]
    return records


def _section(record: type[Data]) -> Iterator[str]:
    yield ""
    yield f"### {HEADINGS[record]}"
    yield ""
    yield (inspect.getdoc(record) or "").replace("``", "`")
    yield ""
    yield "| field | meaning | unit | default | allowed |"
    yield "|---|---|---|---|---|"
    for field in describe_fields(record):
        cells = (
            f"`{field.name}`",
            field.meaning,
            field.unit,
            _default(field),
            _format_allowed(field),
        )
        yield f"| {' | '.join(cells)} |"


def _default(field: FieldDescription) -> str:
    if field.required:
        return "required"
    if field.default is None:
        return "none"
    return "see there" if field.records else f"`{_value(field.default)}`"


def _format_allowed(field: FieldDescription) -> str:
    """Its range, or the tables that it may be."""
    links = [f"[{HEADINGS[record]}](#{_anchor(HEADINGS[record])})" for record in field.records]
    if not links:
        return field.allowed
    record_links = " or ".join(", ".join(links).rsplit(", ", 1))
    return (
        f"a list of {field.lists}, each {record_links}"
        if field.lists
        else record_links + field.applies_to
    )


def _anchor(heading: str) -> str:
    return heading.lower().replace(":", "").replace(" ", "-")


def _value(value: object) -> str:
    """A default as TOML."""
    if isinstance(value, tuple):
        return f"[{', '.join(map(_value, value))}]"
    if isinstance(value, str):
        return f'"{value}"'
    if isinstance(value, bool):
        return str(value).lower()
    if value == {}:
        return "{}"
    assert isinstance(value, int | float)
    return format_number(value)


if __name__ == "__main__":
    write_reference()

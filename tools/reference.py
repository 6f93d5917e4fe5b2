"""The tables of fields in docs/reference: `python -m tools.reference`."""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable, Iterator
from functools import cache, partial
from pathlib import Path

from crosscheck.models.arm.arm import Arm, Direct, FreeArm, FreeBase, Link, Planetary
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
LEAST_ELSEWHERE = 5  # equal rows for which a reader is sent to another page
BEGIN, END = "<!-- fields: made by tools.reference -->\n", "<!-- end of fields -->\n"
FILES: dict[str, tuple[type[Data], ...]] = {
    "arm-file.md": (Arm, FreeArm),
    "scenario-file.md": (Scenario,),
    "studies.md": (Definition,),
    "robot-file.md": (RobotFile,),
}
HEADINGS: dict[type[Data], str] = {
    Arm: "The arm",
    Planetary: "Planetary joint",
    Direct: "Direct joint",
    Link: "Link",
    FreeArm: "Arm on a free base",
    FreeBase: "Free base",
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


def format_field_tables(page: str) -> str:
    """A table for each record of a file, but for those that an earlier page has."""
    records = [record for record, place in _find_places().items() if place == page]
    return "".join(f"{line}\n" for record in records for line in _section(record))


def format_refusals() -> str:
    """A table of options and arguments that one kind of mechanism cannot have."""
    rows = [
        f"| `{each.command}` | `{each.option}` | {each.section} | {each.reason} |"
        for each in REFUSALS
    ]
    return "\n".join(
        ["", "| command | option | not for | reason |", "|---|---|---|---|", *rows, ""]
    )


PAGES: dict[str, Callable[[], str]] = {
    **{name: partial(format_field_tables, name) for name in FILES},
    "command-line.md": format_refusals,
}


@cache
def _find_places() -> dict[type[Data], str]:
    """The page of each record: the first whose file may hold it."""
    places: dict[type[Data], str] = {}
    for page, tops in FILES.items():
        for top in tops:
            places |= {each: page for each in list_records_below(top) if each not in places}
    return places


def list_records_below(record: type[Data]) -> list[type[Data]]:
    """The record and all records that it holds, each once, those above first."""
    records = [record]
    for holder in records:
        below = dict.fromkeys(inner for field in describe_fields(holder) for inner in field.records)
        records += [inner for inner in below if inner not in records]
    return records


def _section(record: type[Data]) -> Iterator[str]:
    """Heading, description and table; a field of one allowed value is a part of the description."""
    every, model = _list_rows(record), _find_model(record)
    fixed = {name: cells[2] for name, cells in every.items() if re.fullmatch(r'"\w+"', cells[2])}
    rows = {name: cells for name, cells in every.items() if name not in fixed}
    shared = [name for name in rows if model and _list_rows(model).get(name) == rows[name]]
    about = [(inspect.getdoc(record) or "").replace("``", "`")]
    about += [f"Selected by `{name} = {value}`." for name, value in fixed.items()]
    if model and shared:
        names = ", ".join(f"`{name}`" for name in shared)
        about.append(f"As in {_link(model, _find_places()[record])}: {names}.")
    yield "\n" + "\n\n".join([f"### {HEADINGS[record]}", *about])
    own = {name: cells for name, cells in rows.items() if name not in shared}
    if own:
        yield "\n| field | meaning | default | allowed |\n|---|---|---|---|"
    for name, cells in own.items():
        yield f"| `{name}` | {' | '.join(cells)} |"


@cache
def _list_rows(record: type[Data]) -> dict[str, tuple[str, ...]]:
    """Cells of every field, by its name."""
    page = _find_places()[record]
    return {
        field.name: (field.meaning, _default(field), _format_allowed(field, page))
        for field in describe_fields(record)
    }


def _find_model(record: type[Data]) -> type[Data] | None:
    """The earlier record with the most equal rows, if it saves a reader some."""
    rows, places = _list_rows(record), _find_places()
    model, most = None, 1
    for earlier in list(places)[: list(places).index(record)]:
        equal = sum(_list_rows(earlier).get(name) == cells for name, cells in rows.items())
        if equal > most and (places[earlier] == places[record] or equal > LEAST_ELSEWHERE):
            model, most = earlier, equal
    return model


def _default(field: FieldDescription) -> str:
    if field.required:
        return "required"
    if field.default is None:
        return "none"
    return "see there" if field.records else f"`{_value(field.default)}`"


def _format_allowed(field: FieldDescription, page: str) -> str:
    """Its range, or the tables that it may be, as linked from a page."""
    links = [_link(record, page) for record in field.records]
    if not links:
        return field.allowed
    record_links = " or ".join(", ".join(links).rsplit(", ", 1))
    return (
        f"a list of {field.lists}, each {record_links}"
        if field.lists
        else record_links + field.applies_to
    )


def _link(record: type[Data], page: str) -> str:
    heading, place = HEADINGS[record], _find_places()[record]
    anchor = heading.lower().replace(":", "").replace(" ", "-")
    return f"[{heading}]({'' if place == page else place}#{anchor})"


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

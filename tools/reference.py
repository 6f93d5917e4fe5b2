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
from crosscheck.models.experiment.scenario import Scenario, Start
from crosscheck.models.refusals import REFUSALS
from crosscheck.models.robot.file import DirectDrive as DirectTransmission
from crosscheck.models.robot.file import Geared, LinkChange, PlanetaryTransmission, RobotFile
from crosscheck.models.robot.robot import RotorMesh
from crosscheck.output import write_files
from crosscheck.schema import FieldDescription, describe_fields
from crosscheck.studies.definition.definition import Definition, Samples, StudyStarts

DOCS = Path(__file__).parents[1] / "docs" / "reference"
LEAST_ELSEWHERE = 5  # equal rows for which a reader is sent to another page
FIELD_HEAD = "| field | meaning | default; range |\n|---|---|---|"
REQUIRED = "\\*"
OR_LIST = ", or list"  # a value for each joint or planet in place of one for all
BEGIN, END = "<!-- fields: made by tools.reference -->\n", "<!-- end of fields -->\n"
FILES: dict[str, tuple[type[Data], ...]] = {
    "arm-file.md": (Arm, FreeArm),
    "scenario-file.md": (Scenario,),
    "studies.md": (Definition,),
    "robot-file.md": (RobotFile,),
}


def list_kinds(record: type[Data], name: str) -> tuple[type[Data], ...]:
    """Records that a field may hold, each chosen by its kind."""
    return next(field.records for field in describe_fields(record) if field.name == name)


SECTIONS: dict[str, tuple[type[Data], ...]] = {
    "The arm": (Arm,),
    "Planetary joint": (Planetary,),
    "Direct joint": (Direct,),
    "Link": (Link,),
    "Arm on a free base": (FreeArm,),
    "Free base": (FreeBase,),
    "Mesh": (Mesh,),
    "Stiffness": list_kinds(Mesh, "stiffness"),
    "The scenario": (Scenario,),
    "Start": (Start,),
    "Drive": list_kinds(Scenario, "drive"),
    "The study": (Definition,),
    "Axis": list_kinds(Definition, "axes"),
    "Samples of a study": (Samples,),
    "Starts of a study": (StudyStarts,),
    "Quantity": list_kinds(Definition, "quantities"),
    "The robot": (RobotFile,),
    "Direct transmission": (DirectTransmission,),
    "Geared transmission": (Geared,),
    "Change of a link": (LinkChange,),
    "Planetary transmission": (PlanetaryTransmission,),
    "Mesh of a transmission": (RotorMesh,),
}
HEADINGS = {record: heading for heading, records in SECTIONS.items() for record in records}


def write_reference() -> None:
    """Renew the tables in all files. Raises InputError."""
    write_files({DOCS / name: renew_tables(name) for name in PAGES})


def renew_tables(name: str) -> str:
    """The text of a file of ``PAGES``, with its tables as the code has them now."""
    before, rest = (DOCS / name).read_text(encoding="utf-8").split(BEGIN)
    return before + BEGIN + PAGES[name]() + "\n" + END + rest.split(END)[1]


def format_field_tables(page: str) -> str:
    """A table for each record of a file, but for those that an earlier page has."""
    return "".join(
        f"{line}\n"
        for heading, kinds in SECTIONS.items()
        if _find_places()[kinds[0]] == page
        for line in (_section(*kinds) if len(kinds) == 1 else _section_of_kinds(heading, kinds))
    )


def format_refusals() -> str:
    """A table of options and arguments that one kind of mechanism cannot have."""
    reasons: dict[tuple[str, str], list[str]] = {}
    for each in REFUSALS:
        name = f"`{each.command} {each.option}`"
        reasons.setdefault((each.section, each.reason), []).append(name)
    rows = [
        f"| {', '.join(names)} | {section} | {reason} |"
        for (section, reason), names in reasons.items()
    ]
    return "\n".join(["", "| option | not for | reason |", "|---|---|---|", *rows, ""])


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
    fixed = {name: cells[-1] for name, cells in every.items() if re.fullmatch(r'"\w+"', cells[-1])}
    rows = {name: cells for name, cells in every.items() if name not in fixed}
    shared = [name for name in rows if model and _list_rows(model).get(name) == rows[name]]
    chosen = "".join(f"`{name} = {value}`: " for name, value in fixed.items())
    about = [chosen + _description(record)]
    if model and shared:
        names = ", ".join(f"`{name}`" for name in shared)
        about.append(f"As in {_link(model, _find_places()[record])}: {names}.")
    yield "\n" + "\n\n".join([f"### {HEADINGS[record]}", *about])
    own = {name: cells for name, cells in rows.items() if name not in shared}
    if own:
        yield "\n" + FIELD_HEAD
    for name, (mark, *cells) in own.items():
        yield f"| `{name}`{mark} | {' | '.join(cells)} |"


def _section_of_kinds(heading: str, kinds: tuple[type[Data], ...]) -> Iterator[str]:
    """Heading, a table of the kinds with the names of their fields, and one of all fields."""
    choice = next(name for name in ("kind", "law") if name in _list_rows(kinds[0]))
    yield f"\n### {heading}\n\n| {choice} | meaning | fields |\n|---|---|---|"
    holders: dict[tuple[str, ...], list[str]] = {}
    for record in kinds:
        rows = dict(_list_rows(record))
        kind = ", ".join(f"`{each}`" for each in re.findall(r'"(\w+)"', rows.pop(choice)[-1]))
        names = ", ".join(f"`{name}`{mark}" for name, (mark, *_) in rows.items())
        yield f"| {kind} | {' '.join(_description(record).split())} | {names} |"
        for name, cells in rows.items():
            holders.setdefault((name, *cells), []).append(kind)
    yield "\n" + FIELD_HEAD
    said = set[str]()
    for (name, mark, *cells), holding in holders.items():
        exception = f" of {', '.join(holding)}" if name in said else ""
        said.add(name)
        yield f"| `{name}`{mark}{exception} | {' | '.join(cells)} |"


def _description(record: type[Data]) -> str:
    return (inspect.getdoc(record) or "").replace("``", "`")


@cache
def _list_rows(record: type[Data]) -> dict[str, tuple[str, ...]]:
    """Cells of every field, by its name."""
    page = _find_places()[record]
    return {
        field.name: (
            REQUIRED * field.required,
            field.meaning,
            _format_default(field) + _abbreviate(_format_allowed(field, page)),
        )
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


def _format_default(field: FieldDescription) -> str:
    if field.required or field.default is None or field.records:
        return ""
    return f"`{_value(field.default)}`; "


def _format_allowed(field: FieldDescription, page: str) -> str:
    """Its range, or the tables that it may be, as linked from a page."""
    links = list(dict.fromkeys(_link(record, page) for record in field.records))
    if not links:
        return field.allowed.replace(field.applies_to or "\0", OR_LIST)
    record_links = " or ".join(", ".join(links).rsplit(", ", 1))
    return (
        f"a list of {field.lists}, each {record_links}"
        if field.lists
        else record_links + OR_LIST * bool(field.applies_to)
    )


def _abbreviate(allowed: str) -> str:
    """A range as 0…1 or ±1, and texts without the words that hold for all."""
    allowed = allowed.replace(" printable characters, not blanks alone", " characters")
    allowed = re.sub(r"-([\d.e]+) to \1\b", r"±\1", allowed)
    return re.sub(r"(?<=\d) to (?=[-\d])", "…", allowed).replace("0, or ", "0, ")


def _link(record: type[Data], page: str) -> str:
    heading, place = HEADINGS[record], _find_places()[record]
    anchor = heading.lower().replace(" ", "-")
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

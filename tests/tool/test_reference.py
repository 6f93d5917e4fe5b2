"""What the docs say of every kind of file is what the schema says, and their examples load."""

import re
from pathlib import Path

import pytest

from crosscheck.models.arm.arm import Arm
from crosscheck.models.arm.stiffness import TableStiffness
from crosscheck.models.files import read_raw_robot
from crosscheck.models.loading import load_arm, load_scenario, validate_record
from crosscheck.models.robot.file import RobotFile
from crosscheck.schema import describe_fields
from crosscheck.studies.definition.files import read_study
from tests.loops import require_items
from tools import reference
from tools.reference import DOCS, FILES, HEADINGS, list_records_below, renew_tables, write_reference

LOAD = {
    "arm-file.md": load_arm,
    "scenario-file.md": load_scenario,
    "studies.md": lambda file: read_study(Path(file)).definition,
    "robot-file.md": lambda file: validate_record(RobotFile, read_raw_robot(file), file),
}
RECORDS = [each for tops in FILES.values() for top in tops for each in list_records_below(top)]
BLOCKS = [
    pytest.param(name, block, id=f"{name} {number}")
    for name in FILES
    for number, block in enumerate(
        re.findall(r"```toml\n(.*?)```", (DOCS / name).read_text(encoding="utf-8"), flags=re.S)
    )
]


@pytest.mark.parametrize("name", reference.PAGES)
def test_tables_are_those_of_the_schema(name):
    text = (DOCS / name).read_text(encoding="utf-8")
    assert text == renew_tables(name), "stale: run python -m tools.reference"


def test_stale_tables_are_renewed(tmp_path, monkeypatch):
    current = {name: renew_tables(name) for name in reference.PAGES}
    for name, text in current.items():
        (tmp_path / name).write_text(
            re.sub(r"\\\*|robots follow", "whatever", text), encoding="utf-8"
        )
    monkeypatch.setattr(reference, "DOCS", tmp_path)
    write_reference()
    for name, text in require_items(current.items()):
        table = text[text.index(reference.BEGIN) :]
        assert (tmp_path / name).read_text(encoding="utf-8").endswith(table)


@pytest.mark.parametrize(("name", "block"), BLOCKS)
def test_every_example_is_a_whole_file(tmp_path, name, block):
    file = tmp_path / "example.toml"
    file.write_text(block, encoding="utf-8")
    assert LOAD[name](str(file)).name


@pytest.mark.parametrize("record", RECORDS)
def test_every_field_has_a_meaning_and_a_range(record):
    assert record in HEADINGS
    for field in describe_fields(record):
        assert re.fullmatch(r"\S.*\.", field.meaning), field.name
        assert field.allowed or field.records, field.name


def test_a_list_says_how_many_it_may_have():
    fields = {field.name: field for field in describe_fields(Arm)}
    assert fields["links"].lists == "1 to 7"
    (law,) = (field for field in describe_fields(TableStiffness) if field.name == "phase_cycles")
    assert law.allowed == "a list of 5 to 2000, each 0 to 1"


@pytest.mark.parametrize("record", RECORDS)
def test_the_unit_ends_the_name(record):
    for field in require_items(describe_fields(record)):
        unit = field.unit.replace("1/", " per ").replace("/", " per ").replace("^", "")
        assert field.name.endswith("_".join(unit.split())), field.name


GENERATED = DOCS.parent.resolve() / "generated"
PAGES = [*DOCS.parent.rglob("*.md"), *DOCS.parents[1].glob("*.md")]


LINKS = {
    path: links
    for path in sorted(PAGES)
    if (links := re.findall(r"\]\(((?!https://)[^)]+)\)", path.read_text(encoding="utf-8")))
}


@pytest.mark.parametrize("path", LINKS, ids=lambda path: path.name)
def test_links_lead_somewhere(path):
    for target in require_items(LINKS[path]):
        where, _, anchor = target.partition("#")
        there = (path.parent / where).resolve() if where else path
        # A page below `generated` is written by `make docs`, which fails on a link to nowhere.
        is_generated = there.is_relative_to(GENERATED)
        assert is_generated or there.exists(), target
        if anchor and not is_generated:  # of a heading, as web pages make it
            headings = re.findall(r"^#+ (.*)$", there.read_text(encoding="utf-8"), flags=re.M)
            words = (re.sub(r"[^\w -]", "", heading).lower() for heading in headings)
            assert anchor in {each.replace(" ", "-") for each in words}, target

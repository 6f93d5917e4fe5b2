"""Outputs replace results of their own kind and nothing else, least of all what is read."""

import os
import shutil
import subprocess
import sys
import threading
from pathlib import Path

import pytest

from crosscheck import file_types
from crosscheck.audit.errata import command as errata_command
from crosscheck.audit.page.report import FILES
from crosscheck.file_types import FILE_TYPES, identify_file_type, is_file_of_type
from crosscheck.findings import Agreement
from crosscheck.models.files import HERE
from crosscheck.models.inputs import (
    forget,
    input_size,
    is_input,
    open_input,
    read_content,
    read_input,
)
from crosscheck.output import write_files
from crosscheck.provenance import ROOT, record_provenance
from crosscheck.report.junit import format_junit
from tests.studies.studies import RIGHT
from tests.tool.test_bad_input import assert_one_line

MODEL = """\
from crosscheck.trial.input.equations import Coordinates, Equations

def model(arm):
    return Equations(bias=lambda q, v: 0 * q, coordinates=Coordinates(gearing="rigid"))
"""
SIMULATE = ("simulate", "arm.toml", "--model", "analytic:physical", "--scenario", "pd.toml")
WRITERS = {
    "validate --json": ("validate", "arm.toml", "--scenario", "pd.toml", "--json"),
    "validate --junit": ("validate", "arm.toml", "--scenario", "pd.toml", "--junit"),
    "simulate": (*SIMULATE, "--out"),
    "simulate --force": (*SIMULATE, "--force", "--out"),
    "errata": ("errata", "arm.toml", "--json"),
    "trial --json": ("trial", "mine.py:model", "arm.toml", "--scenario", "pd.toml", "--json"),
    "trial --junit": ("trial", "mine.py:model", "arm.toml", "--scenario", "pd.toml", "--junit"),
    "sweep": ("sweep", "study.toml", "--out"),
}
INPUTS = ("arm.toml", "pd.toml", "mine.py", "study.toml")


@pytest.fixture
def inputs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, no_work: None) -> Path:
    """A folder, the working one, with a file of each kind that is read; no work is done."""
    shutil.copy(HERE / "arms" / "paper-labelled.toml", tmp_path / "arm.toml")
    shutil.copy(HERE / "scenarios" / "pd.toml", tmp_path / "pd.toml")
    (tmp_path / "mine.py").write_text(MODEL)
    study = RIGHT.read_text().replace('"paper-labelled"', '"arm.toml"').replace('"pd"', '"pd.toml"')
    (tmp_path / "study.toml").write_text(study)
    monkeypatch.setattr(sys, "dont_write_bytecode", False)  # as Python is if nobody says otherwise
    monkeypatch.chdir(tmp_path)
    return tmp_path


def contents(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir() if path.is_file()}


@pytest.mark.parametrize("name", INPUTS)
@pytest.mark.parametrize("writer", WRITERS)
def test_no_input_is_written_onto(crosscheck, inputs, writer, name):
    (inputs / "linked").symlink_to(name)
    os.link(name, "hard")
    before = contents(inputs)
    for file in (name, "linked", "hard"):
        assert_one_line(crosscheck(*WRITERS[writer], file))
    assert contents(inputs) == before


def read_pieces(path: Path) -> None:
    with open_input(path, 10):
        pass


@pytest.mark.parametrize(
    ("read", "remembered"),
    [
        (lambda path: read_content(path, 10), True),
        (lambda path: read_content(path, 10, remembered=False), False),
        (lambda path: read_input(path, 10), True),
        (read_pieces, True),
        (input_size, True),
    ],
)
def test_a_file_is_an_input_however_it_is_read(tmp_path, read, remembered):
    file, linked = tmp_path / "file", tmp_path / "linked"
    file.write_text("content")
    linked.symlink_to(file)
    forget()
    read(linked)
    assert is_input(file) is remembered
    forget()
    assert not is_input(file)


@pytest.mark.parametrize("writer", WRITERS)
def test_no_file_of_another_kind_is_replaced(crosscheck, inputs, writer):
    (inputs / "letter").write_text('{\n "schema_version": 1,\n "dear": "reader"\n}\n')
    before = contents(inputs)
    assert_one_line(crosscheck(*WRITERS[writer], "letter"), "letter", "exists")
    assert contents(inputs) == before


@pytest.mark.parametrize(
    ("command", "name"),
    [(("run", "--quick"), "index.html"), (("run", "--quick"), "agreement.json")]
    + [(("paper",), name) for name in ("paper.html", "claims.json", "errata.html")]
    + [(("errata",), "errata.html")],
)
def test_a_folder_of_somebody_elses_files_is_left_alone(crosscheck, inputs, command, name):
    (inputs / "out").mkdir()
    (inputs / "out" / name).write_text("<!doctype html><title>mine</title>")
    assert_one_line(crosscheck(*command, "--out", "out"), name, "exists and is not")
    assert [path.name for path in (inputs / "out").iterdir()] == [name]


def test_a_record_is_no_place_for_another_file_and_no_letter_is_a_record(crosscheck, inputs):
    shutil.copy(ROOT / "baselines" / "paper-labelled-quick.json", inputs)
    for option in ("--json", "--junit"):
        answer = crosscheck("validate", option, "paper-labelled-quick.json")
        assert_one_line(answer, "paper-labelled-quick.json", "exists and is not")
    (inputs / "paper-labelled-quick.json").write_text("a letter")
    answer = crosscheck("baseline", "accept", "--quick", "--dir", ".")
    assert_one_line(answer, "paper-labelled-quick.json", "exists and is not a record")


def test_a_result_of_the_same_kind_is_replaced(short, crosscheck, tmp_path, monkeypatch):
    monkeypatch.setattr(errata_command, "simulate_errata", lambda *_: [])
    run, errata = tmp_path / "run.nc", tmp_path / "errata.json"
    for _ in range(2):
        assert short().code == crosscheck("errata", "--json", errata).code == 0
    assert identify_file_type(run.read_bytes()) is file_types.TRAJECTORY
    assert identify_file_type(errata.read_bytes()) is file_types.ERRATA
    assert_one_line(crosscheck("errata", "--json", run), "run.nc", "exists")


def test_what_a_cross_check_writes_is_recognised_by_its_content(labelled):
    agreement = Agreement([], record_provenance(labelled, 0, True))
    baselines = ROOT / "baselines"
    assert identify_file_type(agreement.to_json().encode()) is file_types.AGREEMENT
    assert identify_file_type(format_junit(agreement).encode()) is file_types.JUNIT
    for path in baselines.glob("*.json"):
        assert identify_file_type(path.read_bytes()) is file_types.RECORD
    pages = {
        "page": file_types.PAGE,
        "trial": file_types.TRIAL_PAGE,
        "paper": file_types.PAPER_PAGE,
    }
    for name, kind in pages.items():
        file = ROOT / "crosscheck" / "report" / "templates" / f"{name}.html.j2"
        assert identify_file_type(file.read_bytes()) is kind


def test_marks_are_seen_wherever_they_stand_in_a_file(tmp_path):
    kind, file = FILE_TYPES[0], tmp_path / "file"
    file.write_bytes(kind.begins + b"x" * 60 + kind.holds[0] + b"y" * 100 + kind.holds[1])
    assert is_file_of_type(file, kind)
    file.write_bytes(kind.begins + b"x" * 60 + kind.holds[0])
    assert not is_file_of_type(file, kind)
    file.write_bytes(b"x" + kind.begins + b"".join(kind.holds))
    assert not is_file_of_type(file, kind)


def test_what_became_another_file_meanwhile_is_not_replaced(tmp_path):
    content = FILE_TYPES[0].begins + b"".join(FILE_TYPES[0].holds)
    write_files({tmp_path / "a": content})
    write_files({tmp_path / "a": content})
    (tmp_path / "a").write_text("mine")
    with pytest.raises(ValueError, match="exists and is not"):
        write_files({tmp_path / "a": content})


def test_a_pipe_is_written_into(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    content, found = FILE_TYPES[0].begins + b"".join(FILE_TYPES[0].holds), []
    reader = threading.Thread(target=lambda: found.append((tmp_path / "pipe").read_bytes()))
    reader.start()
    write_files({tmp_path / "pipe": content})
    reader.join(10)
    assert found == [content]


def test_standard_output_is_written_into_whatever_it_is(tmp_path):
    script = "from pathlib import Path; from crosscheck.output import write_files\n"
    script += "from crosscheck.file_types import FILE_TYPES; print('before')\n"
    script += (
        "write_files({Path('/dev/stdout'): FILE_TYPES[0].begins + b''.join(FILE_TYPES[0].holds)})\n"
    )
    script += "print('after')"
    command = [sys.executable, "-c", script]
    piped = subprocess.run(command, capture_output=True, check=True).stdout
    with (tmp_path / "file").open("wb") as file:
        subprocess.run(command, stdout=file, check=True)
    assert (tmp_path / "file").read_bytes() == piped
    assert piped.startswith(b"before\n" + FILE_TYPES[0].begins)
    assert piped.endswith(b"after\n")


def test_every_file_of_the_papers_folder_has_a_kind():
    assert set(FILES.values()) <= set(FILE_TYPES)

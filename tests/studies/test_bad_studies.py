"""Bad studies: one line that says where, what and what is allowed; exit code 2; nothing written."""

import re
import tomllib
from contextlib import nullcontext
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from syrupy.assertion import SnapshotAssertion

import crosscheck
from crosscheck.models.errors import InputError
from crosscheck.provenance import ROOT
from crosscheck.studies.batches import batch_store
from crosscheck.studies.definition.files import read_study
from crosscheck.studies.definition.functions import read_source
from crosscheck.studies.members.members import require_members
from tests.obstacles import OBSTACLES
from tests.studies.studies import RIGHT, ROBOT_STUDY, study
from tests.tool.test_bad_input import assert_one_line

STUDY = RIGHT.read_text(encoding="utf-8")
TABLES = tomllib.loads(Path(__file__).with_name("bad_studies.toml").read_text(encoding="utf-8"))
PEAK = 'kind = "peak"\nsignal = "theta_ddot"'
MINE = 'kind = "user_function"\nfunction = "mine.py:f"\nreturns = { a = "m" }'


def _file(folder: Path, old: str, new: str) -> Path:
    assert old in STUDY
    file = folder / "study.toml"
    file.write_text(STUDY.replace(old, new, 1), encoding="utf-8")
    return file


@pytest.mark.parametrize(
    ("section", "case"), [(each, case) for each in ("studies", "robots") for case in TABLES[each]]
)
def test_one_line_says_what_is_wrong(section, case, refuse, snapshot: SnapshotAssertion):
    text = STUDY if section == "studies" else ROBOT_STUDY
    given = TABLES[section][case]
    for old, new in zip(given[::2], given[1::2], strict=True):
        assert old in text
        text = text.replace(old, new, 1)
    line = refuse("sweep study.toml --out out.nc --jobs 1", {"study.toml": text})
    line = re.sub(r"\d+\.\d{7,}|[\d.,]+ GB(?= are free)", "#", line)  # a draw, the disk
    assert line.replace(str(ROOT), "...") == snapshot


def test_the_largest_of_many_samples_is_tried_before_any_run():
    """A link that is as long as all but one of 2,001 centres of mass are far."""
    axis = {"path": "arm.links.0.com_m", "kind": "uniform", "relative_tolerance": 0.5}
    places = study([axis], samples={"count": 2001}).axes[0].values[:, 0]
    *_, second, largest = np.sort(places)
    for length, refusal in ((largest, nullcontext()), (second, pytest.raises(InputError))):
        settings = {"arm.links.0.length_m": float(length)}
        with refusal:
            require_members(study([axis], samples={"count": 2001}, settings=settings))


def test_room_is_what_the_disk_has_for_a_result_and_its_batches(tmp_path, monkeypatch):
    batch_store.require_room(tmp_path / "out.nc", 1000, 10)
    monkeypatch.setattr(batch_store.shutil, "disk_usage", lambda folder: SimpleNamespace(free=1900))
    with pytest.raises(InputError, match="10 members"):
        batch_store.require_room(tmp_path / "out.nc", 1000, 10)


def test_a_file_of_somebody_elses_is_left_alone(sweep, crosscheck, tmp_path):
    file, out = _file(tmp_path, PEAK, PEAK), tmp_path / "out.nc"
    out.write_text("mine")
    for more in ([], ["--resume"]):
        assert_one_line(sweep(file, *more))
    folder = tmp_path / "other.nc.batches"
    folder.mkdir()
    (folder / "letter").write_text("mine")
    assert_one_line(crosscheck("sweep", file, "--out", tmp_path / "other.nc"))
    assert (out.read_text(), (folder / "letter").read_text()) == ("mine", "mine")
    assert_one_line(crosscheck("sweep", file, "--out", file))
    assert file.read_text() == STUDY


@pytest.mark.parametrize("case", TABLES["functions"])
def test_a_function_that_cannot_be_used_is_named(
    case, sweep, tmp_path, monkeypatch, snapshot: SnapshotAssertion
):
    monkeypatch.chdir(tmp_path)
    Path("mine.py").write_text(TABLES["functions"][case], encoding="utf-8")
    answer = sweep(_file(Path(), PEAK, MINE), "--jobs", 1, "--run-code")
    assert_one_line(answer)
    assert {path.name for path in tmp_path.iterdir()} <= {"mine.py", "study.toml", "__pycache__"}
    assert answer.err.replace(str(tmp_path), "...") == snapshot


@pytest.mark.parametrize(
    ("function", "said"),
    [
        ("mine.py", "must be module:function or file.py:function"),
        ("mine.py:1f", "must be module:function or file.py:function"),
        (":f", "must be module:function or file.py:function"),
        ("crosscheck.no_module:f", "no module crosscheck.no_module with a source file"),
        ("_json:f", "no module _json with a source file"),
        ("folder:f", "no module folder with a source file"),
    ],
)
def test_a_function_without_a_source_is_named(function, said, tmp_path, monkeypatch):
    """A module of machine code has none, and neither has a folder without a module."""
    (tmp_path / "folder").mkdir()
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(InputError, match=re.escape(said)) as refused:
        read_source(function, tmp_path)
    assert refused.value.value == function


@pytest.mark.parametrize("jobs", [1, 2])
@pytest.mark.parametrize("case", TABLES["lost"])
def test_a_function_that_does_not_come_back_ends_the_study(case, jobs, sweep, tmp_path, impatient):
    code, fragment = TABLES["lost"][case]
    (tmp_path / "mine.py").write_text(code, encoding="utf-8")
    left, _, err = sweep(_file(tmp_path, PEAK, MINE), "--jobs", jobs, "--run-code")
    assert (left, err.count("\n")) == (3, 1)
    assert fragment in err
    assert sorted(path.name for path in tmp_path.iterdir()) == ["mine.py", "study.toml"]


def test_python_gets_the_same():
    axes = {"arm.payload_mass_kg": []}
    with pytest.raises(InputError, match="at least"):
        crosscheck.sweep("paper-labelled", axes, scenario="pd", measures=[{"kind": "peak"}])


@pytest.mark.parametrize("what", ["folder", "pipe", "dangling", "loop"])
@pytest.mark.parametrize("place", ["study", "function", "out", "batches", "mark"])
def test_what_is_no_file_is_one_line(sweep, tmp_path, place, what):
    file = _file(tmp_path, PEAK, MINE if place == "function" else PEAK)
    folder = tmp_path / "out.nc.batches"
    (tmp_path / "elsewhere").mkdir()
    if place == "mark":
        folder.mkdir()
    named = {
        "study": tmp_path / "other.toml",
        "function": tmp_path / "mine.py",
        "out": tmp_path / "out.nc",
        "batches": folder,
        "mark": folder / batch_store.MARK,
    }[place]
    if what == "folder":
        (named if place != "batches" else named / "a letter").mkdir(parents=True)
    elif what == "dangling":
        named.symlink_to("elsewhere/nowhere")
    else:
        OBSTACLES[what](named)
    chosen = named if place == "study" else file
    for more in ([], ["--resume"]):
        answer = sweep(chosen, "--jobs", 1, "--run-code", *more)
        if place == "out" and what == "dangling":  # a link to a file that is going to be
            assert answer.code == 0
            return
        assert_one_line(answer)
    assert not list((tmp_path / "elsewhere").iterdir())


def test_batches_that_a_killed_study_left_beside_its_result_go(sweep, tmp_path):
    file, out = _file(tmp_path, PEAK, PEAK), tmp_path / "out.nc"
    code, said, _ = sweep(file, "--jobs", 1)
    assert code == 0
    count = read_study(file).count
    assert re.search(rf"^wrote {out}: {count} members, {count} run in [\d.]+ s, ", said, re.M)
    assert_one_line(sweep(file), "exists already")
    before = out.read_bytes()
    folder, digest = tmp_path / "out.nc.batches", read_study(file).digest
    for owner, left in ((digest, False), ("0" * 64, True)):
        folder.mkdir()
        (folder / batch_store.MARK).write_text(f"{owner}\n{'0' * 32}\n")
        (folder / f"{'0' * 32}.kept").write_text("half")
        code, said, err = sweep(file, "--jobs", 1, "--resume")
        assert (code, err) == (0, "")
        assert "is complete" in said
        assert folder.exists() == left
        assert out.read_bytes() == before


def test_what_the_mark_does_not_list_is_left_alone(sweep, tmp_path):
    file = _file(tmp_path, PEAK, PEAK)
    folder = tmp_path / "out.nc.batches"
    folder.mkdir()
    study = read_study(file)
    (folder / batch_store.MARK).write_text(f"{study.digest}\n{'0' * 32}\ntorn")
    letters = {f"{'1' * 32}.kept", "torn.kept", f"{'2' * 32}.json", ".crosscheck-notes", "letter"}
    for name in letters:
        (folder / name).write_text("mine")
    (folder / f"{'0' * 32}.kept").symlink_to("letter")
    code, _, err = sweep(file, "--jobs", 1, "--resume")
    assert (code, err) == (0, "")
    assert {path.name for path in folder.iterdir()} == letters
    assert {path.read_text() for path in folder.iterdir()} == {"mine"}

"""What is kept is private, is what was put there, or is made again with one line that says so."""

import json
import os
import random
import signal
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import pytest

from crosscheck.audit.experiments.study import Question, Records, Study
from crosscheck.models.directories import PrivacyError, cache_folder, require_private
from crosscheck.models.errors import InputError
from crosscheck.runner.store import Store, clear
from tests.obstacles import obstruct
from tests.processes import in_child, reachable

KEY, OTHER = "0" * 32, "f" * 32
CONTENT = json.dumps(list(range(5000))).encode()  # several blocks of a disk


@dataclass(frozen=True)
class Square(Question[dict[str, float]]):
    """Without a simulation."""

    number: float

    cost = 0.0

    def records(self) -> Records:
        return ()

    def answer(self) -> dict[str, float]:
        return {"square": self.number**2}


def asked(folder: Path, *numbers: float) -> list[float]:
    """The squares, by way of the folder."""
    found = Study(folder).answer_questions([Square(number) for number in numbers], "squares")
    return [answer["square"] for answer in found]


def entry(folder: Path) -> Path:
    (kept,) = folder.glob("*.kept")
    return kept


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A store with one entry."""
    assert asked(tmp_path / "store", 3.0) == [9.0]
    return tmp_path / "store"


def test_folder_and_entries_are_the_users_alone(folder):
    assert folder.stat().st_mode & 0o777 == 0o700
    assert entry(folder).stat().st_mode & 0o777 == 0o600
    folder.chmod(0o777)
    with pytest.raises(PrivacyError, match="written by others"), require_private(entry(folder)):
        pass
    asked(folder, 3.0)
    assert folder.stat().st_mode & 0o777 == 0o700


def a_folder(path: Path) -> None:
    path.unlink()
    path.mkdir()
    (path / "of mine").touch()


def a_link(path: Path) -> None:
    path.rename(path.with_name("elsewhere"))
    path.symlink_to("elsewhere")


def of_another_result(path: Path) -> None:
    asked(path.parent, 2.0)
    (other,) = (kept for kept in path.parent.glob("*.kept") if kept != path)
    path.write_bytes(other.read_bytes())


DAMAGES: dict[str, Callable[[Path], object]] = {
    "truncated": lambda path: path.write_bytes(path.read_bytes()[:-1]),
    "longer": lambda path: path.write_bytes(path.read_bytes() + b" "),
    "another_number": lambda path: path.write_bytes(path.read_bytes().replace(b"9", b"8")),
    "empty": lambda path: path.write_bytes(b""),
    "garbage": lambda path: path.write_bytes(random.Random(7).randbytes(5000)),
    "headless": lambda path: path.write_bytes(b'{"square": 8.0}'),
    "a_folder": a_folder,
    "a_pipe": obstruct("pipe"),
    "a_link": a_link,
    "a_dead_link": obstruct("dangling"),
    "a_device": obstruct("device"),
    "of_another_result": of_another_result,
}


@pytest.mark.parametrize("damage", DAMAGES)
def test_what_does_not_fit_is_made_again_with_one_line(folder, capfd, damage):
    path = entry(folder)
    DAMAGES[damage](path)
    signal.alarm(20)  # a pipe must not hang it
    assert asked(folder, 3.0) == [9.0]
    signal.alarm(0)
    said = capfd.readouterr().err
    assert said.count("\n") == 1
    assert said.startswith(f"crosscheck: {path}: does not fit: ")
    assert asked(folder, 3.0) == [9.0]
    assert path.is_file()
    assert not path.is_symlink()
    aside = [each.name for each in folder.glob("*.set-aside-*/*")]  # what others put there
    assert aside == ["of mine"] * (damage == "a_folder")
    assert capfd.readouterr().err == ""


def test_no_single_byte_can_change_unseen(tmp_path, capfd):
    """One block of zeros or one byte, anywhere, drawn anew each time."""
    seed = random.SystemRandom().randrange(2**32)
    print(f"seed {seed}")
    draw = random.Random(seed)
    store = Store(tmp_path)
    for _ in range(200):
        store.put(KEY, CONTENT)
        path = tmp_path / f"{KEY}.kept"
        whole = path.read_bytes()
        at = draw.randrange(len(whole))
        size, byte = draw.choice([(1, draw.randrange(256)), (512, 0)])
        broken = (whole[:at] + bytes([byte]) * size + whole[at + size :])[: len(whole)]
        path.write_bytes(broken)
        if broken == whole:
            assert store.get(KEY, bytes) == CONTENT
        else:
            with pytest.raises(KeyError):
                store.get(KEY, bytes)


def test_what_cannot_be_decoded_is_missing(tmp_path, capsys):
    store = Store(tmp_path)
    store.put(KEY, b"no JSON")
    with pytest.raises(KeyError):
        store.get(KEY, json.loads)
    assert capsys.readouterr().err.count("\n") == 1
    with pytest.raises(KeyError):
        store.get(OTHER, json.loads)
    assert capsys.readouterr().err == ""


def test_an_unreadable_entry_is_made_again(tmp_path):
    folder = reachable(tmp_path) / "store"
    tmp_path.chmod(0o777)

    def remade() -> None:
        asked(folder, 3.0)
        entry(folder).chmod(0)
        assert asked(folder, 3.0) == [9.0]
        assert entry(folder).stat().st_mode & 0o777 == 0o600

    assert in_child(remade, nobody=True)


@pytest.mark.skipif(os.geteuid() != 0, reason="only root can give a folder away")
def test_another_users_folder_is_not_trusted(folder, capfd):
    os.chown(folder, 65534, -1)
    assert asked(folder, 3.0) == [9.0]
    said = capfd.readouterr().err
    assert said.count("\n") == 1
    assert "belongs to another user; simulations are not kept" in said


@pytest.mark.parametrize(
    ("place", "counts", "why"), [("file", (4, 0), "Not a directory"), ("gone", (3, 1), "")]
)
def test_a_place_that_takes_nothing_costs_the_keeping_alone(tmp_path, capfd, place, counts, why):
    """A folder below a file cannot be made; one that is gone is made again."""
    (tmp_path / "file").touch()
    folder = tmp_path / place / "store"
    study = Study(folder)
    if place == "gone":
        folder.rmdir()
    for numbers in ((2.0, 3.0), (2.0,), (5.0,)):
        found = study.answer_questions([Square(number) for number in numbers], "squares")
        assert found == [{"square": number**2} for number in numbers]
    assert (study.computed_count, study.cached_count) == counts
    line = f"crosscheck: {folder}: cannot be written: {why}; simulations are not kept\n"
    assert capfd.readouterr().err == (line if why else "")


def test_what_a_killed_study_left_goes_when_the_store_is_opened(tmp_path):
    script = f"""
import os, signal
from pathlib import Path
from crosscheck import output
from crosscheck.runner.store import Store
output.os.replace = lambda *names: os.kill(os.getpid(), signal.SIGKILL)
Store(Path({str(tmp_path)!r})).put({KEY!r}, b"half")
"""
    killed = subprocess.run([sys.executable, "-c", script], timeout=60, check=False)
    assert killed.returncode == -signal.SIGKILL
    assert len(list(tmp_path.iterdir())) == 1
    Store(tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_clearing_removes_what_is_the_stores_own(folder):
    mine = [folder / "notes.txt", folder / "report.json", folder / f"{KEY}.kept.bak"]
    for path in mine:
        path.touch()
    (folder / f"{KEY}.kept").mkdir()
    (folder / f"{OTHER}.json").touch()  # of an earlier version
    elsewhere = folder.parent / "elsewhere"
    elsewhere.touch()
    (folder / f"{OTHER}.nc").symlink_to(elsewhere)
    assert clear(folder) == 3
    assert sorted(folder.iterdir()) == sorted([*mine, folder / f"{KEY}.kept"])
    assert elsewhere.exists()
    assert clear(folder) == 0


def test_clearing_an_emptied_store_leaves_nothing(folder):
    assert clear(folder) == 1
    assert not folder.exists()
    assert clear(folder) == 0


def test_clearing_what_is_not_ours_is_one_line(tmp_path):
    def refused() -> None:
        with pytest.raises(InputError, match="cannot be cleared: Permission denied"):
            clear(tmp_path)

    reachable(tmp_path).chmod(0o755)
    (tmp_path / f"{KEY}.kept").touch()
    if os.geteuid() != 0:
        tmp_path.chmod(0o555)
    assert in_child(refused, nobody=True)
    tmp_path.chmod(0o755)


@pytest.mark.parametrize("given", ["", "relative/cache"])
def test_the_store_is_in_the_users_cache_folder(monkeypatch, tmp_path, given):
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setenv("XDG_CACHE_HOME", given)
    assert cache_folder() == tmp_path / ".cache" / "geararm-crosscheck"
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "x"))
    assert cache_folder() == tmp_path / "x" / "geararm-crosscheck"

"""Specialised kernels are kept in the user's cache folder, under a name of what they hold."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import pytest

from analytic.fast import compiled
from analytic.fast.compiled import module_of
from analytic.fast.program import Program
from models.places import own_folder, temporary_folder
from tests.processes import command_line

TEXT = "VALUE = 1\n"  # stands for a kernel: what is kept and run is any module's text
SHORT = ("simulate", "paper-labelled", "--model", "analytic:links", "--scenario", "pd")


def program(text: str = TEXT) -> Program:
    return Program(text, 1, (), (), ())


@pytest.fixture
def base(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """An empty cache folder of the user's, and nothing remembered of another."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    for function in (own_folder, temporary_folder, module_of):
        function.cache_clear()
    yield tmp_path / "geararm-crosscheck"
    for function in (own_folder, temporary_folder, module_of):
        function.cache_clear()


def file_of(module: ModuleType) -> Path:
    assert module.__file__ is not None
    return Path(module.__file__)


def again(text: str = TEXT) -> ModuleType:
    """As another process finds it."""
    module_of.cache_clear()
    return module_of(program(text))


def test_a_kernel_is_kept_in_a_private_folder(base):
    file = file_of(again())
    assert file.parent == base / "kernels"
    assert file.parent.stat().st_mode & 0o777 == 0o700
    assert file.read_text() == TEXT
    assert [path.name for path in file.parent.glob("*.draft")] == []


def test_a_kept_kernel_is_not_written_again(base):
    file = file_of(again())
    written = file.stat()
    assert file_of(again()).stat().st_ino == written.st_ino
    assert file.stat().st_mtime_ns == written.st_mtime_ns


def test_other_text_is_another_file(base):
    assert file_of(again()) != file_of(again("VALUE = 2\n"))


@pytest.mark.parametrize(
    "damage", [b"VALUE = 666\n", b"", b"VALUE", b"\xff\xfe", b"raise OSError\n"]
)
def test_a_damaged_kernel_is_written_again_and_not_run(base, damage):
    file = file_of(again())
    file.write_bytes(damage)
    found = again()
    assert (file_of(found), found.VALUE) == (file, 1)
    assert file.read_text() == TEXT


def test_code_that_is_compiled_into_a_kernel_counts(base, monkeypatch):
    before = file_of(again())
    source = compiled.inspect.getsource
    monkeypatch.setattr(compiled.inspect, "getsource", lambda module: source(module) + "# other")
    assert file_of(again()) != before


@pytest.mark.parametrize("name", [".", "kernels"])
def test_where_no_folder_can_be_the_kernel_is_kept_for_this_run(base, name):
    taken = base / name
    taken.parent.mkdir(parents=True, exist_ok=True)
    if taken.exists():
        taken.rmdir()
    taken.write_text("in the way")
    found = again()
    assert found.VALUE == 1
    assert base not in file_of(found).parents
    assert taken.read_text() == "in the way"


def test_a_run_needs_no_cache_folder(tmp_path):
    env = {"HOME": "/dev/null/home", "XDG_CACHE_HOME": "", "TMPDIR": str(tmp_path)}
    out = tmp_path / "run.nc"
    answer = command_line(*SHORT, "--t-end", "0.0002", "--out", out, env=env)
    assert (answer.returncode, answer.stderr) == (0, "")
    assert out.exists()
    assert not list(tmp_path.glob("geararm-*"))  # a folder for one process goes with it

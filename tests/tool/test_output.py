"""What is written is there whole or not at all; what cannot be written is reported beforehand."""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from crosscheck.models.errors import InputError
from crosscheck.models.trajectory import encode_netcdf
from crosscheck.output import draft, require_file, write_files, write_text
from crosscheck.runner.interruption import cleanup_callbacks
from tests.obstacles import OBSTACLES
from tests.processes import command_line, in_child, limit_files, reachable, warm_command_line
from tests.tool.test_bad_input import assert_one_line

LARGEST = 20_000  # bytes that a file may have on the "full disk"
SIMULATE = ("simulate", "paper-labelled", "--model", "analytic:links", "--scenario", "pd")


@pytest.fixture
def umask() -> Iterator[Callable[[int], int]]:
    before = os.umask(0o022)
    yield os.umask
    os.umask(before)


def mode(path: Path) -> int:
    return path.stat().st_mode & 0o777


@pytest.mark.parametrize(("mask", "left"), [(0o077, 0o600), (0o022, 0o644), (0o002, 0o664)])
def test_files_are_as_open_as_the_umask_says(umask, tmp_path, mask, left):
    umask(mask)
    write_files({tmp_path / "a": "text", tmp_path / "b": b"\0"})
    assert [mode(tmp_path / name) for name in "ab"] == [left, left]


def test_a_replaced_file_keeps_its_permissions(umask, tmp_path):
    file = tmp_path / "private"
    file.touch()
    for permissions in (0o600, 0o666):
        file.chmod(permissions)
        write_text(file, "mine")
        assert mode(file) == permissions


def test_a_link_stays_a_link(tmp_path):
    (tmp_path / "there").mkdir()
    for target in ("old", "not yet"):
        (tmp_path / "there" / "old").write_text("old")
        link = tmp_path / f"link to {target}"
        link.symlink_to(Path("there") / target)
        write_text(link, "new")
        assert link.is_symlink()
        assert (tmp_path / "there" / target).read_text() == "new"


def obstacles(folder: Path) -> dict[str, str]:
    """Name of something that no file can replace -> what is said of it."""
    (folder / "file").touch()
    for name in ("folder", "pipe", "loop", "device"):
        OBSTACLES[name](folder / name)
    return {
        "folder": "is a folder; a file name is expected",
        "pipe": "is not an ordinary file",
        "loop": "is a link that leads back to itself",
        "device": "is not an ordinary file",
        "file/below": "is a file; a folder is expected",
    }


def test_what_no_file_can_replace_is_refused_in_one_line(tmp_path):
    said = obstacles(tmp_path)
    before = sorted(tmp_path.iterdir())
    for name, words in said.items():
        with pytest.raises(InputError, match=words):
            write_text(tmp_path / name, "text")
    assert sorted(tmp_path.iterdir()) == before


def test_a_write_protected_file_is_refused(tmp_path):
    file = reachable(tmp_path) / "protected"
    file.write_text("mine")
    file.chmod(0o444)

    def refused() -> None:
        with pytest.raises(InputError, match="is write-protected"):
            require_file(file)

    assert in_child(refused, nobody=True)


@pytest.mark.parametrize(
    "command",
    [
        (*SIMULATE, "--out", "{}"),
        ("errata", "--json", "{}"),
        ("validate", "--quick", "--json", "{}"),
        ("validate", "--quick", "--junit", "{}"),
    ],
    ids=lambda command: command[0],
)
@pytest.mark.parametrize("name", ["folder", "loop", "device", "file/below"])
@pytest.mark.usefixtures("no_work")
def test_it_is_refused_before_the_work(crosscheck, tmp_path, command, name):
    words = obstacles(tmp_path)[name]
    arguments = [argument.format(tmp_path / name) for argument in command]
    assert_one_line(crosscheck(*arguments), str(tmp_path / name.partition("/")[0]), words)


@pytest.mark.parametrize("command", ["run", "paper"])
@pytest.mark.parametrize("name", ["file", "folder"])
@pytest.mark.usefixtures("no_work")
def test_a_report_that_cannot_be_written_is_refused_before_the_work(
    crosscheck, tmp_path, command, name
):
    obstacles(tmp_path)
    page = {"run": "index.html", "paper": "paper.html"}[command]
    (tmp_path / "folder" / page).mkdir()
    words = {"file": "a folder is expected", "folder": "is a folder; a file name is expected"}
    assert_one_line(crosscheck(command, "--out", tmp_path / name), str(tmp_path), words[name])


@pytest.mark.parametrize(
    "command",
    [
        ("compare", "{record}", "paper-labelled", "--out", "{}"),
        ("compare", "{record}", "paper-labelled", "--json", "{}/compare.json"),
        ("validate", "--quick", "--json", "{}/agreement.json"),
        (*SIMULATE, "--out", "{}/run.nc"),
    ],
    ids=lambda command: f"{command[0]} {command[-1]}",
)
def test_a_command_that_is_refused_makes_no_folder(crosscheck, tmp_path, monkeypatch, command):
    def refuse(*_: object) -> None:
        raise InputError("work", "", None, "is refused")

    for work in ("cli.simulation.perform_all", "cli.commands.run_with_progress"):
        monkeypatch.setattr(f"crosscheck.{work}", refuse)
    record, new = tmp_path / "record.csv", tmp_path / "new" / "folder"
    record.write_text("a,b\n1,2\n")
    answer = crosscheck(*(word.format(new, record=record) for word in command))
    assert answer.code == 2
    assert [path.name for path in tmp_path.iterdir()] == ["record.csv"]


@pytest.mark.parametrize("error", [InputError("a", "", None, "is bad"), KeyboardInterrupt()])
def test_folders_made_for_a_file_that_is_not_published_are_removed(tmp_path, error):
    (tmp_path / "old").mkdir()
    with pytest.raises(type(error)), draft(tmp_path / "old" / "new" / "folder"):
        raise error
    assert list(tmp_path.iterdir()) == [tmp_path / "old"]
    assert list((tmp_path / "old").iterdir()) == []


@pytest.mark.usefixtures("no_work")
def test_one_file_for_two_things_is_refused(crosscheck, tmp_path):
    (tmp_path / "link").symlink_to("new/a")
    arguments = ("validate", "--json", tmp_path / "new" / "a", "--junit", tmp_path / "link")
    assert_one_line(crosscheck(*arguments), "link: is in use for two things")
    assert not (tmp_path / "new").exists()


def test_several_files_appear_together_or_not_at_all(tmp_path):
    (tmp_path / "old").write_text("old")

    def both_refused() -> None:
        limit_files(LARGEST)
        with pytest.raises(InputError, match="large: cannot be written: File too large"):
            write_files({tmp_path / "old": "new", tmp_path / "large": bytes(LARGEST + 1)})

    assert in_child(both_refused)
    assert [path.name for path in tmp_path.iterdir()] == ["old"]
    assert (tmp_path / "old").read_text() == "old"


@pytest.mark.slow
def test_a_trajectory_survives_a_full_disk_as_one_line(crosscheck, tmp_path):
    out = tmp_path / "run.nc"
    arguments = (*SIMULATE, "--t-end", "0.002", "--out", out)
    assert crosscheck(*arguments).code == 0  # and all kernels are compiled
    assert out.stat().st_size > LARGEST
    out.unlink()
    answer = warm_command_line(*arguments, largest=LARGEST)
    assert (answer.returncode, answer.stdout) == (2, "")
    assert answer.stderr == f"crosscheck: {out}: cannot be written: File too large\n"
    assert list(tmp_path.iterdir()) == []


def test_netcdf_is_read_as_it_was_written(tmp_path):
    values = np.array([[0.1, np.nan], [1e-300, -np.inf]])
    run = xr.Dataset({"theta": (("time", "joint"), values, {"units": "rad"})}, attrs={"arm": "ä"})
    write_files({tmp_path / "run.nc": encode_netcdf(run)})
    assert xr.load_dataset(tmp_path / "run.nc", engine="h5netcdf").identical(run)


def test_what_a_killed_process_left_is_removed_and_what_a_living_one_writes_is_not(tmp_path):
    script = f"""
import os, time
from pathlib import Path
from crosscheck.output import draft
with draft(Path({str(tmp_path)!r})) as new:
    new.write(b"half")
    print("ready", flush=True)
    time.sleep(60)
"""
    with subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE) as process:
        assert process.stdout is not None
        process.stdout.readline()
        write_text(tmp_path / "mine", "1")
        assert len(list(tmp_path.iterdir())) == 2
        process.send_signal(signal.SIGKILL)
    write_text(tmp_path / "mine", "2")
    assert [path.name for path in tmp_path.iterdir()] == ["mine"]


def test_a_process_that_ends_without_unwinding_can_clear_up(tmp_path):
    with draft(tmp_path) as new:
        new.write(b"half")
        for clear in cleanup_callbacks:
            clear()
        assert list(tmp_path.iterdir()) == []
    assert cleanup_callbacks == []


def test_many_writers_of_one_file_leave_one_of_them(tmp_path):
    target, texts = tmp_path / "shared", [letter * 100_000 for letter in "abcd"]

    def write(text: str) -> None:
        until = time.monotonic() + 0.5
        while time.monotonic() < until:
            write_text(target, text)

    children = []
    for text in texts:
        child = os.fork()
        if child == 0:
            write(text)
            os._exit(0)
        children.append(child)
    assert [os.waitpid(child, 0)[1] for child in children] == [0] * 4
    assert target.read_text() in texts
    assert list(tmp_path.iterdir()) == [target]


def test_what_is_no_text_is_written_as_escapes(tmp_path):
    write_text(tmp_path / "page", "bytes in no encoding: \udce4; and ä")
    assert (tmp_path / "page").read_text(encoding="utf-8") == (
        r"bytes in no encoding: \udce4; and ä"
    )


def test_a_name_that_the_locale_does_not_have_is_one_line(tmp_path):
    script = "from pathlib import Path; from crosscheck.output import write_text\n"
    script += r"write_text(Path('\u00e4'), '')"
    bare = {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}
    answer = command_line(python=("-c", script), env=bare, cwd=tmp_path)
    assert answer.stderr.splitlines()[-1].endswith("this locale has no such file names")

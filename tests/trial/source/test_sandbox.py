"""What edited code cannot do: change anything outside its process, or take all of the machine."""

import os
import socket
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from crosscheck.runner.outcomes import Failure
from crosscheck.runner.workers import perform_all
from crosscheck.trial.source.sandbox import (
    MEMORY,
    enter_sandbox,
    freeze,
    limit_processor_time,
)


def write(folder):
    (folder / "new").write_text("x")


def append(folder):
    with open(folder / "kept", "a"):
        pass


def open_for_writing(folder):
    os.open(folder / "new", os.O_CREAT | os.O_WRONLY)


def remove(folder):
    (folder / "kept").unlink()


def rename(folder):
    (folder / "kept").rename(folder / "new")


def make_folder(folder):
    (folder / "new").mkdir()


def fork(folder):
    if os.fork() == 0:
        os._exit(0)


def start(folder):
    subprocess.run([sys.executable, "-c", ""], check=True)


def run_shell(folder):
    os.system("true")


def spawn(folder):
    os.posix_spawn(sys.executable, [sys.executable, "-c", ""], {})


def connect(folder):
    socket.socket()


def end_another(folder):
    os.kill(os.getppid(), 0)


def swallow(folder):
    try:
        write(folder)
    except Exception:
        return


def never_end(folder):
    with limit_processor_time(0.1):
        while True:
            pass


def take_all_memory(folder):
    np.ones(MEMORY)


FORBIDDEN = [
    write,
    append,
    open_for_writing,
    remove,
    rename,
    make_folder,
    fork,
    start,
    run_shell,
    spawn,
    connect,
    end_another,
    swallow,
]


@dataclass(frozen=True)
class Deed:
    """A task of doing something in the sandbox."""

    what: str
    folder: Path
    cost: float = 1.0
    key: str = "deed"

    def perform(self):
        enter_sandbox(20)
        return globals()[self.what](self.folder)


def do(what, folder):
    (result,) = perform_all([Deed(what.__name__, folder)], 1).values()
    return result


@pytest.mark.parametrize("deed", FORBIDDEN, ids=lambda deed: deed.__name__)
def test_what_changes_anything_is_refused(tmp_path, deed):
    (tmp_path / "kept").write_text("as it was", encoding="utf-8")
    result = do(deed, tmp_path)
    assert isinstance(result, Failure)
    assert result.kind == "RefusedAction"
    assert [each.name for each in tmp_path.iterdir()] == ["kept"]
    assert (tmp_path / "kept").read_text(encoding="utf-8") == "as it was"


@pytest.mark.parametrize(
    ("deed", "kind"), [(never_end, "TooSlow"), (take_all_memory, "MemoryError")]
)
def test_what_takes_too_much_is_stopped(tmp_path, deed, kind):
    result = do(deed, tmp_path)
    assert isinstance(result, Failure)
    assert kind in result.kind


def test_a_mechanism_is_frozen_to_its_last_array():
    @dataclass
    class Link:
        place: np.ndarray

    @dataclass
    class Machine:
        links: tuple[Link, ...]
        by_name: dict[str, list[np.ndarray]]

    machine = Machine((Link(np.zeros(3)),), {"a": [np.ones(2)]})
    freeze(machine)
    for array in (machine.links[0].place, machine.by_name["a"][0]):
        with pytest.raises(ValueError, match="read-only"):
            array += 1

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
from crosscheck.trial.source.sandbox import MEMORY, enter_sandbox, freeze, limit_processor_time


def swallow(folder):
    try:
        (folder / "new").write_text("x")
    except Exception:
        return


def never_end(folder):
    with limit_processor_time(0.1):
        while True:
            pass


PYTHON = [sys.executable, "-c", ""]
FORBIDDEN = {
    "write": lambda folder: (folder / "new").write_text("x"),
    "append": lambda folder: os.open(folder / "kept", os.O_APPEND | os.O_WRONLY),
    "open for writing": lambda folder: os.open(folder / "new", os.O_CREAT | os.O_WRONLY),
    "remove": lambda folder: (folder / "kept").unlink(),
    "rename": lambda folder: (folder / "kept").rename(folder / "new"),
    "make a folder": lambda folder: (folder / "new").mkdir(),
    "fork": lambda folder: os.fork() or os._exit(0),
    "start a process": lambda folder: subprocess.run(PYTHON, check=True),
    "run a shell": lambda folder: os.system("true"),
    "spawn": lambda folder: os.posix_spawn(sys.executable, PYTHON, {}),
    "connect": lambda folder: socket.socket(),
    "end another": lambda folder: os.kill(os.getppid(), 0),
    "swallow": swallow,
}
ENDLESS = {"TooSlow": never_end, "MemoryError": lambda folder: np.ones(MEMORY)}


@dataclass(frozen=True)
class Deed:
    """A task of doing something in the sandbox."""

    what: str
    folder: Path
    cost: float = 1.0
    key: str = "deed"

    def perform(self):
        enter_sandbox(20)
        return (FORBIDDEN | ENDLESS)[self.what](self.folder)


def do(what, folder):
    (result,) = perform_all([Deed(what, folder)], 1).values()
    return result


@pytest.mark.parametrize("deed", FORBIDDEN)
def test_what_changes_anything_is_refused(tmp_path, deed):
    (tmp_path / "kept").write_text("as it was", encoding="utf-8")
    result = do(deed, tmp_path)
    assert isinstance(result, Failure)
    assert result.kind == "RefusedAction"
    assert [each.name for each in tmp_path.iterdir()] == ["kept"]
    assert (tmp_path / "kept").read_text(encoding="utf-8") == "as it was"


@pytest.mark.parametrize("kind", ENDLESS)
def test_what_takes_too_much_is_stopped(tmp_path, kind):
    result = do(kind, tmp_path)
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

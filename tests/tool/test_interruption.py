"""Ctrl-C and termination: one line, 130 or 143 within two seconds, nothing left."""

import os
import pty
import random
import signal
import subprocess
import sys
import time
from contextlib import suppress
from itertools import cycle, product
from pathlib import Path

import psutil
import pytest

from crosscheck.provenance import ROOT
from crosscheck.runner.interruption import SHOW_CURSOR
from crosscheck.runner.supervision import _Supervision
from tests.draws import DRAWS, SAMPLE, fresh_seed
from tests.processes import command_line, wait_for

COMMANDS = {
    "validate": ["validate", "--quick", "--jobs", "2", "--json", "out/a.json"],
    "run": ["run", "--quick", "--jobs", "1", "--out", "out"],
    "simulate": [
        *["simulate", "paper-labelled", "--model", "exudyn:tree", "--scenario", "pd"],
        *["--out", "out/run.nc"],
    ],
    "paper": ["paper", "--figure", "10", "--out", "out", "--jobs", "2"],
}
WHOM = ("group", "program", "twice")
# In the suite every command and every way once, not every two of them: each starts a program.
PAIRS = [*(zip(COMMANDS, cycle(WHOM)) if DRAWS == SAMPLE else product(COMMANDS, WHOM))]
SAID = {signal.SIGINT: "interrupted", signal.SIGTERM: "terminated"}


def _start(command: str, folder: Path) -> subprocess.Popen[str]:
    """The command in a folder of its own, with a group of processes of its own."""
    (folder / "out").mkdir()
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "XDG_CACHE_HOME": str(folder / "cache")}
    return subprocess.Popen(
        [sys.executable, "-m", "crosscheck", *COMMANDS[command]],
        cwd=folder,
        env=environment,
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        start_new_session=True,
    )


def _listens(pid: int) -> bool:
    """Whether a process has a handler for SIGTERM, which Python itself has none for."""
    try:
        status = Path(f"/proc/{pid}/status").read_text()
    except OSError:  # it has ended
        return False
    caught = int(status.partition("SigCgt:")[2].split()[0], 16)
    return bool(caught >> (signal.SIGTERM - 1) & 1)


def _members(group: int) -> list[int]:
    """Processes of a group that are still there."""
    found = []
    for process in psutil.process_iter(["status"]):
        with suppress(ProcessLookupError):
            if os.getpgid(process.pid) == group and process.info["status"] != psutil.STATUS_ZOMBIE:
                found.append(process.pid)
    return found


@pytest.mark.slow
@pytest.mark.campaign
@pytest.mark.parametrize(
    ("command", "whom", "first"), [(*pair, place % 2) for place, pair in enumerate(PAIRS)]
)
def test_a_signal_at_any_moment_ends_the_program_in_one_line(command, whom, first, tmp_path):
    """Both signals take turns, each time at another moment; first: the place of that of the first.

    One time takes a few seconds: there is one of them for a whole sample of other campaigns.
    """
    draw = random.Random(f"{fresh_seed()} {command} {whom}")
    for time_ in range(max(1, DRAWS // SAMPLE)):
        folder = tmp_path / str(time_)
        folder.mkdir()
        delay = draw.choice([draw.uniform(0.0, 0.5), draw.uniform(0.5, 2.0)])
        number = [*SAID][(first + time_) % 2]
        _ends_in_one_line(command, whom, number, delay, folder)


def _ends_in_one_line(
    command: str, whom: str, number: signal.Signals, delay: float, folder: Path
) -> None:
    program = _start(command, folder)
    wait_for(lambda: _listens(program.pid), program)  # until then it is the interpreter's own start
    time.sleep(delay)
    send = os.killpg if whom == "group" else os.kill
    send(program.pid, number)
    if whom == "twice":
        time.sleep(0.05)
        if program.poll() is None:
            os.kill(program.pid, number)
    # 2 s on a machine that does nothing else.
    out, err = program.communicate(timeout=30)
    assert (program.returncode, out, err) == (128 + number, "", f"crosscheck: {SAID[number]}\n"), (
        delay
    )
    assert list((folder / "out").iterdir()) == []
    until = time.monotonic() + 30
    while _members(program.pid) and time.monotonic() < until:
        time.sleep(0.05)
    assert _members(program.pid) == []


SWALLOWED = """
import os, signal, time, weakref
from crosscheck.runner.interruption import advice, listen
advice.append("go on")
class Thing: pass
def at_its_end(_):
    os.kill(os.getpid(), signal.SIGTERM)
    time.sleep(0.1)
listen()
thing = Thing()
reference = weakref.ref(thing, at_its_end)
del thing
time.sleep(20)
"""


def test_an_interrupt_that_python_can_only_report_ends_the_program_in_one_line():
    """Imports have such callbacks: where KeyboardInterrupt is raised in one, Python goes on.

    On a terminal the cursor is shown again.
    """
    here, there = pty.openpty()
    streams = {"capture_output": False, "stdout": subprocess.PIPE, "stderr": there}
    ended = command_line(python=("-c", SWALLOWED), env={"PYTHONPATH": str(ROOT)}, **streams)
    os.close(there)
    assert ended.returncode == 143
    assert os.read(here, 999) == b"\x1b[?25hcrosscheck: terminated; go on\r\n"


def test_blame_shows_the_cursor_again_where_it_goes_to_a_terminal(monkeypatch, capsys):
    for terminal, shown in ((1, ""), (2, SHOW_CURSOR)):
        monkeypatch.setattr(os, "isatty", lambda descriptor, own=terminal: descriptor == own)
        assert _Supervision(0, 0)._report_blame("ended", 3) == 3
        assert capsys.readouterr() == ("", f"{shown}crosscheck: ended\n")

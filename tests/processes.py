"""The program and pieces of it in processes of their own."""

import atexit
import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import pytest


class Answer(NamedTuple):
    """What a command left behind."""

    code: int
    out: str
    err: str


Command = Callable[..., Answer]
ROOT = Path(__file__).parents[1]
NOBODY = 65534
# What only those commands import that need it, beside numbers and what they are kept in.
ENGINES = {"pinocchio", "exudyn", "sympy", "matplotlib", "h5py", "h5netcdf", "jinja2"}
HEAVY = {*ENGINES, "numpy", "scipy", "numba", "llvmlite", "xarray", "pandas"}
SHOW_LOADED = (
    "import sys; sys.argv = ['crosscheck', *sys.argv[1:]]; import atexit;"
    "atexit.register(lambda: print('loaded', *sorted(sys.modules)));"
    "from crosscheck.cli.app import main; main()"
)


def command_line(
    *arguments: object,
    env: dict[str, str] | None = None,
    python: tuple[str, ...] = ("-m", "crosscheck"),
    **more: object,
) -> subprocess.CompletedProcess[str]:
    """``python -m crosscheck *arguments``; ``env`` changes the environment, "" removes."""
    around = {name: value for name, value in (os.environ | (env or {})).items() if value}
    options: dict[str, object] = {"capture_output": True, "text": True, "timeout": 120}
    command = [sys.executable, *python, *map(str, arguments)]
    return subprocess.run(command, env=around, check=False, **(options | more))  # type: ignore[call-overload]


def wait_for(
    has_happened: Callable[[], bool], *programs: subprocess.Popen[Any], within_s: float = 60.0
) -> None:
    """Wait until it has; fails at once where one of the programs has ended without it."""
    until = time.monotonic() + within_s
    while True:
        ended = [program for program in programs if program.poll() is not None]
        if has_happened():
            return
        if ended:
            pytest.fail(f"ended with {ended[0].returncode}: {ended[0].communicate()}")
        if time.monotonic() > until:
            pytest.fail(f"nothing within {within_s:.0f} s")
        time.sleep(0.005)


def limit_files(largest: int) -> None:
    """Let this process write no file of more than so many bytes."""
    resource.setrlimit(resource.RLIMIT_FSIZE, (largest, largest))


@cache
def _warm() -> subprocess.Popen[str]:
    """A process that waits for commands, see tests.warm; it ends with this one."""
    warm = subprocess.Popen(
        [sys.executable, str(Path(__file__).with_name("warm.py"))],
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    atexit.register(warm.communicate)  # which ends its input
    return warm


def warm_command_line(
    *arguments: object,
    folder: Path | None = None,
    env: dict[str, str] | None = None,
    largest: int | None = None,
) -> subprocess.CompletedProcess[str]:
    """``crosscheck *arguments`` in a process forked from one that has imported all it needs.

    For what does not ask how a process begins: its imports, its working memory, and variables that
    are read at import are those of the other. ``env`` changes the environment; ``largest`` is how
    many bytes a file may have, as on a full disk.
    """
    words, warm = [*map(str, arguments)], _warm()
    assert warm.stdin is not None
    assert warm.stdout is not None
    with tempfile.TemporaryDirectory() as kept:
        out, err = Path(kept, "out"), Path(kept, "err")
        command = {
            "arguments": words,
            "folder": str(folder or Path.cwd()),
            "environment": {**os.environ, **(env or {})},
            "out": str(out),
            "err": str(err),
            "largest": largest or resource.RLIM_INFINITY,
        }
        print(json.dumps(command), file=warm.stdin, flush=True)
        code = json.loads(warm.stdout.readline())
        texts = (file.read_text(encoding="utf-8") for file in (out, err))
        return subprocess.CompletedProcess(words, code, *texts)


@cache
def modules_loaded_by(*arguments: object) -> set[str]:
    """Names of all modules that a command has loaded when it ends."""
    answer = command_line(*arguments, python=("-c", SHOW_LOADED))
    assert answer.returncode == 0, answer.stderr
    return set(answer.stdout.rsplit("loaded ", 1)[1].split())


def in_child(work: Callable[[], None], nobody: bool = False) -> bool:
    """Whether ``work`` comes to its end in a forked process; as another user if we may."""
    child = os.fork()
    if child == 0:
        code = 1
        try:
            if nobody and os.geteuid() == 0:
                os.setgid(NOBODY)
                os.setuid(NOBODY)
            work()
            code = 0
        finally:
            os._exit(code)
    return os.waitpid(child, 0)[1] == 0


def reachable(folder: Path) -> Path:
    """The folder, which others may now enter by its name."""
    for part in (folder, *folder.parents):
        if part.stat().st_uid == os.geteuid() and not part.stat().st_mode & 0o001:
            part.chmod(part.stat().st_mode | 0o001)
    return folder

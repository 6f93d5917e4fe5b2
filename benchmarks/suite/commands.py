"""Part 7: where the time of the commands goes: imports, derivation, integration, drawing."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Callable, Sequence
from pathlib import Path
from statistics import median

from benchmarks.suite.machine import ROOT
from benchmarks.suite.profiled import CATEGORIES, WAITING
from benchmarks.suite.rows import Row, absent_row
from benchmarks.suite.timing import Times, measure_seconds, print_progress, run_in_turn

TABLE = "commands"
LIMIT_S = 90.0
TARGETS_S = {"list": 0.5, "simulate": 1.5}  # that a user waits, on a machine that does nothing else
MOST = 5  # repeats
SHARES = (*(kind for kind in CATEGORIES if kind != WAITING), "imports", "other")
SIMULATE = ("simulate", "paper-labelled", "--model", "analytic:physical", "--scenario", "pd")
ANSWER_CODES = (0, 1)  # that some check differs is an answer, too
PROFILER = str(Path(__file__).with_name("profiled.py"))


def measure(repeats: int) -> list[Row]:
    """`list` and `simulate` repeatedly; `run`, which takes longer, once as a user runs it first,
    and once in one process, watched. With one repeat that is short."""
    run = ("run", *(("--quick",) if repeats == 1 else ()))
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        brief = {"list": ("list",), "simulate": (*SIMULATE, "--out", str(folder / "run.nc"))}
        runs = {name: _run(words) for name, words in brief.items()}
        rows = [_wall(name, times) for name, times in run_in_turn(runs, min(repeats, MOST)).items()]
        for name, words in brief.items():
            rows += _shares(name, words, folder, min(repeats, 3))
        return [*rows, *measure_long_command("run", run, folder, LIMIT_S)]


def measure_long_command(
    name: str, words: Sequence[str], folder: Path, limit_s: float
) -> list[Row]:
    """Once with nothing kept from before, and once in one process, watched, with all that is kept;
    each within a time limit [s]."""
    written, rows = (*words, "--out", str(folder / "out")), list[Row]()
    steps: tuple[Callable[[], list[Row]], ...] = (
        lambda: [_cold(name, written, folder, limit_s)],
        lambda: _shares(name, (*written, "--jobs", "1"), folder, 1, limit_s),
    )
    for step in steps:
        try:
            rows += step()
        except subprocess.TimeoutExpired:
            rows.append(absent_row(TABLE, f"crosscheck {name}", f"it took more than {limit_s:g} s"))
        print_progress(f"crosscheck {name}: {rows[-1].quantity}")
    return rows


def _run(words: Sequence[str], limit_s: float = LIMIT_S, **more: str) -> Callable[[], None]:
    command = [sys.executable, "-m", "crosscheck", *words]
    return lambda: _run_to_end(command, limit_s, more)


def _run_to_end(command: Sequence[str], limit_s: float, more: dict[str, str]) -> None:
    """Runs a command to its end. Raises TimeoutExpired."""
    around = environment() | more
    done = subprocess.run(command, cwd=ROOT, env=around, capture_output=True, timeout=limit_s)
    assert done.returncode in ANSWER_CODES, done.stderr.decode()


def environment() -> dict[str, str]:
    """This process's, with the project's folder to import from."""
    return dict(os.environ, PYTHONPATH=str(ROOT))


def _wall(name: str, times: Times) -> Row:
    row = Row(TABLE, f"crosscheck {name}", "wall time", times.median, "s", spread=times.spread)
    target_s = TARGETS_S.get(name)
    if target_s is None:
        return row
    return row._replace(against=f"{target_s:g} s", ratio=times.median / target_s, target=1.0)


def _cold(name: str, words: Sequence[str], folder: Path, limit_s: float) -> Row:
    kept = {"XDG_CACHE_HOME": str(folder / f"{name}-cache")}
    return _wall(f"{name}, cold", Times((measure_seconds(_run(words, limit_s, **kept)),)))


def _shares(
    name: str, words: Sequence[str], folder: Path, repeats: int, limit_s: float = LIMIT_S
) -> list[Row]:
    """Seconds of all processes by what they are for, results kept from before; waiting for another
    process apart."""
    profiles = [_run_profiled(words, folder, limit_s) for _ in range(repeats)]
    whole = median(sum(each.values()) for each in profiles)
    case, rows = f"crosscheck {name}, its processes", []
    for kind in SHARES:
        seconds = median(each.get(kind, 0.0) for each in profiles)
        rows.append(Row(TABLE, case, kind, seconds, "s", "all of them", seconds / whole))
    return rows


def _run_profiled(words: Sequence[str], folder: Path, limit_s: float) -> dict[str, float]:
    kept = {"XDG_CACHE_HOME": str(folder / "watched-cache")}
    with tempfile.TemporaryDirectory() as place:
        command = [sys.executable, PROFILER, place, "crosscheck", *words]
        _run_to_end(command, limit_s, kept)
        seconds: Counter[str] = Counter()
        for file in Path(place).glob("*.json"):
            seconds.update(json.loads(file.read_text()))
    seconds.pop(WAITING, None)
    return dict(seconds)

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
from benchmarks.suite.profiled import KINDS, WAITING
from benchmarks.suite.rows import Row
from benchmarks.suite.timing import Times, in_turn, seconds_of

TABLE = "commands"
PAPER_S = 300.0  # asked of the whole paper, with nothing kept from before
SHARES = (*(kind for kind in KINDS if kind != WAITING), "imports", "other")
SIMULATE = ("simulate", "paper-labelled", "--model", "analytic:physical", "--scenario", "pd")
ENDED = (0, 1)  # that some check differs is an answer, too
PROFILER = str(Path(__file__).with_name("profiled.py"))


def measure(repeats: int) -> list[Row]:
    """`list` and `simulate` repeatedly; `run` and `paper`, which take minutes, once as a user runs
    them first, and once in one process, watched. With one repeat these are short."""
    quick = repeats == 1
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        out = ("--out", str(folder / "out"))
        brief = {"list": ("list",), "simulate": (*SIMULATE, "--out", str(folder / "run.nc"))}
        long = {
            "run": ("run", *out, *(("--quick",) if quick else ())),
            "paper": ("paper", *out, *(("--figure", "6") if quick else ())),
        }
        times = in_turn({name: _run(words) for name, words in brief.items()}, repeats)
        rows = [_wall(name, found) for name, found in times.items()]
        rows += [_cold(name, words, folder, quick) for name, words in long.items()]
        for name, words in brief.items():
            rows += _shares(name, words, folder, min(repeats, 3))
        for name, words in long.items():
            rows += _shares(name, (*words, "--jobs", "1"), folder, 1)
    return rows


def _run(words: Sequence[str], **more: str) -> Callable[[], None]:
    def run() -> None:
        command = [sys.executable, "-m", "crosscheck", *words]
        done = subprocess.run(command, cwd=ROOT, env=environment() | more, capture_output=True)
        assert done.returncode in ENDED, done.stderr.decode()

    return run


def environment() -> dict[str, str]:
    """This process's, with the project's folder to import from."""
    return dict(os.environ, PYTHONPATH=str(ROOT))


def _wall(name: str, times: Times) -> Row:
    return Row(TABLE, f"crosscheck {name}", "wall time", times.median, "s", spread=times.spread)


def _cold(name: str, words: Sequence[str], folder: Path, quick: bool) -> Row:
    """Once, with no result and nothing compiled kept from before."""
    kept = {"XDG_CACHE_HOME": str(folder / f"{name}-cache")}
    row = _wall(f"{name}, cold", Times((seconds_of(_run(words, **kept)),)))
    if quick or name != "paper":
        return row
    return row._replace(against=f"{PAPER_S:g} s", ratio=row.value / PAPER_S, target=1.0)


def _shares(name: str, words: Sequence[str], folder: Path, repeats: int) -> list[Row]:
    """Seconds of all processes by what they are for, results kept from before; waiting for another
    process apart."""
    found = [_watched(words, folder) for _ in range(repeats)]
    whole = median(sum(each.values()) for each in found)
    case, rows = f"crosscheck {name}, its processes", []
    for kind in SHARES:
        seconds = median(each.get(kind, 0.0) for each in found)
        rows.append(Row(TABLE, case, kind, seconds, "s", "all of them", seconds / whole))
    return rows


def _watched(words: Sequence[str], folder: Path) -> dict[str, float]:
    kept = {"XDG_CACHE_HOME": str(folder / "watched-cache")}
    with tempfile.TemporaryDirectory() as place:
        command = [sys.executable, PROFILER, place, "crosscheck", *words]
        done = subprocess.run(command, cwd=ROOT, env=environment() | kept, capture_output=True)
        assert done.returncode in ENDED, done.stderr.decode()
        seconds: Counter[str] = Counter()
        for file in Path(place).glob("*.json"):
            seconds.update(json.loads(file.read_text()))
    seconds.pop(WAITING, None)
    return dict(seconds)

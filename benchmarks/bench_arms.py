"""What a user waits for: whole processes, from start to end, against the times asked of them.

Run as ``python benchmarks/bench_arms.py`` from the project's folder. The medians are of wall clock;
on a machine that is busy otherwise they are longer than the program's own.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import median

ROOT = Path(__file__).parent.parent
# Equations of motion of six geared joints, evaluated and integrated once.
SIX_JOINTS = """
from crosscheck.registry import build
from crosscheck.sizing import pd_scenario, sizes_of
from crosscheck.template import example_arm

arm = example_arm("six", 6)
scenario = pd_scenario(sizes_of(arm))
short = scenario.model_copy(update={"duration_s": 100 * scenario.step_s})
build("analytic:physical", arm, short).simulate()
"""
CROSSCHECK = (sys.executable, "-m", "crosscheck")
SIMULATE = (
    *(*CROSSCHECK, "simulate", "paper-labelled", "--model", "analytic:physical"),
    *("--scenario", "pd", "--t-end", "0.01", "--out"),
)


@dataclass(frozen=True)
class Wait:
    """A command that a user waits for: seconds asked, and measured run by run."""

    what: str
    asked_s: float
    measured_s: tuple[float, ...]

    def __str__(self) -> str:
        found, spread = median(self.measured_s), (min(self.measured_s), max(self.measured_s))
        verdict = "" if found < self.asked_s else "  too long"
        runs = f"{spread[0]:.2f} to {spread[1]:.2f} s, {len(self.measured_s)} runs"
        return f"{self.what:<46}{self.asked_s:>7.1f} s{found:>9.2f} s   {runs}{verdict}"


def timed(command: Sequence[str], repeats: int, folder: Path | None = None) -> tuple[float, ...]:
    """Wall clock of every run [s]; folder: where numba keeps what it compiles, if not as usual."""
    environment = dict(os.environ, PYTHONPATH=str(ROOT))
    if folder is not None:
        environment["NUMBA_CACHE_DIR"] = str(folder)
    found = []
    for _ in range(repeats):
        began = time.perf_counter()
        subprocess.run(command, env=environment, check=True, stdout=subprocess.DEVNULL)
        found.append(time.perf_counter() - began)
    return tuple(found)


def fresh(command: Sequence[str], repeats: int) -> tuple[float, ...]:
    """The same, each run with nothing compiled before it."""
    found: tuple[float, ...] = ()
    for _ in range(repeats):
        with tempfile.TemporaryDirectory() as folder:
            found += timed(command, 1, Path(folder))
    return found


def waits(folder: Path) -> list[Wait]:
    """All that is asked; what a run writes goes into the folder."""
    six, simulate = (sys.executable, "-c", SIX_JOINTS), (*SIMULATE, str(folder / "run.nc"))
    compiled = folder / "compiled"
    for command in (six, simulate):
        timed(command, 1, compiled)
    return [
        Wait("six geared joints, the first time", 60.0, fresh(six, 3)),
        Wait("six geared joints, compiled before", 2.0, timed(six, 7, compiled)),
        Wait("crosscheck list", 0.5, timed((*CROSSCHECK, "list"), 7)),
        Wait("crosscheck simulate, 0.01 s, compiled before", 1.5, timed(simulate, 7, compiled)),
    ]


if __name__ == "__main__":
    print(f"{'':<46}{'asked':>9}{'median':>11}   spread")
    with tempfile.TemporaryDirectory() as place:
        for wait in waits(Path(place)):
            print(wait)

"""What a user waits for: whole processes, from start to end, against the times asked of them.

Run as ``python benchmarks/bench_arms.py`` from the project's folder. What is asked is of wall clock
on a machine that does nothing else; processor time tells how busy it was.
"""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import median

ROOT = Path(__file__).parent.parent
# Equations of motion of six geared joints, evaluated and integrated once; of three planets each.
SIX_JOINTS = """
from crosscheck.registry import build
from crosscheck.cli.template import example_arm
from crosscheck.models.loading import load_scenario
from crosscheck.models.experiment.scenario import switches

arm = example_arm("six", 6)
joints = tuple(joint.model_copy(update={{"planet_count": 3}}) for joint in arm.joints)
scenario = load_scenario("constant-torque").model_copy(update={{"duration_s": 1e-3}})
six = arm.model_copy(update={{"joints": joints}})
build("analytic:physical", six, scenario, switches(planets="{planets}")).simulate()
"""
CROSSCHECK = (sys.executable, "-m", "crosscheck")
SIMULATE = (
    *(*CROSSCHECK, "simulate", "paper-labelled", "--model", "analytic:physical"),
    *("--scenario", "pd", "--t-end", "0.01", "--out"),
)


@dataclass(frozen=True)
class Run:
    """One run of a process [s]: by the clock, and of processors, its children's included."""

    clock_s: float
    processor_s: float


@dataclass(frozen=True)
class Wait:
    """A command that a user waits for: seconds asked, and its runs."""

    what: str
    limit_s: float
    runs: tuple[Run, ...]

    def __str__(self) -> str:
        clock, processor = [r.clock_s for r in self.runs], [r.processor_s for r in self.runs]
        verdict = "" if median(clock) < self.limit_s else "  too long"
        return (
            f"{self.what:<46}{self.limit_s:>7.1f} s{median(clock):>9.2f} s"
            f"{median(processor):>11.2f} s   {min(clock):.2f} to {max(clock):.2f} s,"
            f" {len(clock)} runs{verdict}"
        )


def time_runs(command: Sequence[str], repeats: int, folder: Path | None = None) -> tuple[Run, ...]:
    """Every run of a command; folder: where what is compiled is kept, if not as usual."""
    environment = dict(os.environ, PYTHONPATH=str(ROOT))
    if folder is not None:
        environment["XDG_CACHE_HOME"] = str(folder)
    runs = []
    for _ in range(repeats):
        began, used = time.perf_counter(), processor_s()
        subprocess.run(command, env=environment, check=True, stdout=subprocess.DEVNULL)
        runs.append(Run(time.perf_counter() - began, processor_s() - used))
    return tuple(runs)


def processor_s() -> float:
    """What all processes that have ended took of processors [s]."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def time_fresh_runs(command: Sequence[str], repeats: int) -> tuple[Run, ...]:
    """The same, each run with nothing compiled before it."""
    runs: tuple[Run, ...] = ()
    for _ in range(repeats):
        with tempfile.TemporaryDirectory() as folder:
            runs += time_runs(command, 1, Path(folder))
    return runs


def measure_waits(folder: Path) -> list[Wait]:
    """All that is asked; what a run writes goes into the folder."""
    simulate, compiled = (*SIMULATE, str(folder / "run.nc")), folder / "compiled"
    lumped, free = (
        (sys.executable, "-c", SIX_JOINTS.format(planets=planets)) for planets in ("lumped", "free")
    )
    for command in (lumped, free, simulate):
        time_runs(command, 1, compiled)
    return [
        Wait("six geared joints, the first time", 60.0, time_fresh_runs(lumped, 3)),
        Wait("six geared joints, compiled before", 2.0, time_runs(lumped, 7, compiled)),
        Wait("the same, three free planets each, first time", 60.0, time_fresh_runs(free, 3)),
        Wait("the same, compiled before", 2.0, time_runs(free, 7, compiled)),
        Wait("crosscheck list", 0.5, time_runs((*CROSSCHECK, "list"), 7)),
        Wait("crosscheck simulate, 0.01 s, compiled before", 1.5, time_runs(simulate, 7, compiled)),
    ]


if __name__ == "__main__":
    print(f"{'':<46}{'asked':>9}{'median':>11}{'processor':>13}   spread")
    with tempfile.TemporaryDirectory() as place:
        for wait in measure_waits(Path(place)):
            print(wait)

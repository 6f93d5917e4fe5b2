"""Part 5: studies of 1,000 and 10,000 members: rate, memory, and what the machinery adds.

Members differ in the play of their teeth; of each the peaks of three signals are kept. What is held
against the bare kernel is the command as a user waits for it, its start included.
"""

from __future__ import annotations

import math
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

from benchmarks.suite.lanes import run_and_discard
from benchmarks.suite.machine import ROOT
from benchmarks.suite.memory import PeakMemory
from benchmarks.suite.rows import Row
from benchmarks.suite.timing import Times, measure_seconds, print_progress
from crosscheck.studies.definition.files import read_study

TABLE = "studies"
GIGABYTE = 1e9
OVER_KERNEL = 1.1  # of the kernel's time
WORKERS = 2
FILE = """schema_version = 1
name = "members"
arm = "paper-labelled"
scenario = "pd"
settings = {{ "scenario.duration_s" = {duration} }}
samples = {{ count = {members}, seed = 1 }}

[[axes]]
path = "arm.joints.*.*_mesh.backlash_m"
kind = "uniform"
relative_tolerance = 0.2
each = true
"""
PEAK = '\n[[quantities]]\nkind = "peak"\nsignal = "{}"\njoint = {}\n'
PEAKS = (("theta_ddot", 1), ("theta_ddot", 2), ("F_sp", 1))


class Size(NamedTuple):
    """A study; within_s: how long it may take [s], inf where nothing is asked."""

    members: int
    duration_s: float
    repeats: int
    within_s: float = math.inf
    checked: bool = False  # against what is asked of memory and overhead

    @property
    def name(self) -> str:
        """What the rows call it."""
        return f"{self.members:,} members, PD {self.duration_s:g} s"


def measure(repeats: int) -> list[Row]:
    """With one repeat, fewer members for a shorter time."""
    sizes = (Size(64, 0.3, 1), Size(256, 0.3, 1))
    if repeats > 1:
        sizes = (Size(1_000, 3.0, 3, within_s=15.0), Size(10_000, 3.0, 1, 120.0, checked=True))
    return [row for size in sizes for row in _rows(size)]


def _rows(size: Size) -> Iterator[Row]:
    with tempfile.TemporaryDirectory() as place:
        file = Path(place, "study.toml")
        peaks = "".join(PEAK.format(*peak) for peak in PEAKS)
        file.write_text(FILE.format(members=size.members, duration=size.duration_s) + peaks)
        cores = os.cpu_count() or 1
        bare = _bare(file, cores)
        next(bare)  # compiles
        here = [(next(bare), _study(file, "--jobs", str(cores))) for _ in range(size.repeats)]
        yield from _study_rows(size, f"--jobs {cores}", here)
        yield _bare_row(size, cores, [kernel for kernel, _ in here])


class StudyRun(NamedTuple):
    """A study by the command line: its time [s] and the most memory [bytes]."""

    seconds: float
    bytes: float


def _bare(file: Path, threads: int) -> Iterator[float]:
    """Seconds that the ensemble kernel takes for the same members, again and again; the first time
    some of them alone."""
    study = read_study(file, run_code=False)
    cases = list(study.cases(0, study.count))
    models = [case.make_model() for case in cases]
    run_and_discard(models[:threads], threads)
    yield math.nan
    while True:
        seconds = measure_seconds(lambda: run_and_discard(models, threads))
        print_progress(f"bare kernel: {study.count / seconds:.0f} members a second")
        yield seconds


def _study(file: Path, *more: str) -> StudyRun:
    out = file.with_name("study.nc")
    out.unlink(missing_ok=True)
    words = ("sweep", str(file), "--out", str(out), *more)
    with PeakMemory() as memory:
        seconds = measure_seconds(_command(words))
    print_progress(f"{' '.join(more)}: {seconds:.1f} s")
    return StudyRun(seconds, memory.bytes)


def _command(words: tuple[str, ...]) -> Callable[[], object]:
    command, around = [sys.executable, "-m", "crosscheck", *words], {"PYTHONPATH": str(ROOT)}
    return lambda: subprocess.run(
        command, cwd=ROOT, env={**os.environ, **around}, capture_output=True, check=True
    )


def _study_rows(size: Size, how: str, runs: list[tuple[float, StudyRun]]) -> Iterator[Row]:
    """Of runs of a study, each with the bare kernel's time beside it."""
    case = f"{size.name}, {how}"
    kernel = Times(tuple(seconds for seconds, _ in runs))
    times = Times(tuple(run.seconds for _, run in runs))
    within, over = times.median / size.within_s, times.median_ratio(kernel)
    row = Row(TABLE, case, "wall time of the command", times.median, "s", spread=times.spread)
    target_fields = {"against": f"{size.within_s:g} s", "ratio": within, "target": 1.0}
    yield row._replace(**target_fields) if math.isfinite(size.within_s) else row
    yield Row(TABLE, case, "rate", size.members / times.median, "members/s")
    target = OVER_KERNEL if size.checked else None
    yield row._replace(
        quantity="all of it", against="bare ensemble kernel", ratio=over, target=target
    )
    held = max(run.bytes for _, run in runs) / GIGABYTE
    most = 1.0 if size.checked else None
    yield Row(TABLE, case, "peak memory, all processes", held, "GB", "1 GB", held, most)


def _bare_row(size: Size, threads: int, seconds: list[float]) -> Row:
    times, case = Times(tuple(seconds)), f"{size.name}, bare ensemble kernel, {threads} threads"
    rate = size.members / times.median
    return Row(TABLE, case, "rate", rate, "members/s", spread=times.spread)

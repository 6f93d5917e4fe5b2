"""Where the figures come from: machine, versions, compiler, revision."""

from __future__ import annotations

import os
import platform
import subprocess
from datetime import UTC, datetime
from pathlib import Path
from typing import NamedTuple

from benchmarks.suite.c_reference import FLAGS, NoCompiler, compiler_version
from crosscheck.provenance import PACKAGES, find_version

MORE = ("llvmlite", "scikit-sundae", "heyoka", "distributed")
ROOT = Path(__file__).parent.parent.parent


class Machine(NamedTuple):
    """What a reader needs to judge the figures, and to measure again."""

    made: str
    revision: str
    processor: str
    cores: int
    load: float
    system: str
    compiler: str
    versions: dict[str, str]
    repeats: int


def describe_machine(repeats: int) -> Machine:
    """Of now and here; load: processes that wanted a processor in the last minute."""
    versions = {name: find_version(name) or "absent" for name in (*PACKAGES, *MORE)}
    return Machine(
        made=datetime.now(UTC).isoformat(timespec="seconds"),
        revision=_revision(),
        processor=_processor(),
        cores=os.cpu_count() or 1,
        load=os.getloadavg()[0],
        system=f"{platform.system()} {platform.machine()}, Python {platform.python_version()}",
        compiler=_compiler(),
        versions=versions,
        repeats=repeats,
    )


def _processor() -> str:
    """Its name, as the system tells it."""
    table = Path("/proc/cpuinfo")
    if table.exists():
        for line in table.read_text().splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()


def _compiler() -> str:
    try:
        return f"{compiler_version()} {' '.join(FLAGS[:2])}"
    except NoCompiler as reason:
        return str(reason)


def _revision() -> str:
    command = ["git", "-C", str(ROOT), "describe", "--always", "--dirty", "--abbrev=12"]
    try:
        done = subprocess.run(command, capture_output=True, text=True, check=True)
    except (OSError, subprocess.SubprocessError):
        return "no revision"
    return done.stdout.strip()

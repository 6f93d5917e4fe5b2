"""How much memory the processes started here held at most, all together."""

from __future__ import annotations

import os
import threading
from pathlib import Path

LOOK_S = 0.1
PROCESSES = Path("/proc")


class PeakMemory:
    """Within its block, of every process that descends from this one; pages that several share
    count once. nan where the system does not tell."""

    def __init__(self) -> None:
        self.bytes = 0.0 if (PROCESSES / "self" / "smaps_rollup").exists() else float("nan")
        self._over = threading.Event()
        self._looking = threading.Thread(target=self._look, daemon=True)

    def __enter__(self) -> PeakMemory:
        self._looking.start()
        return self

    def __exit__(self, *raised: object) -> None:
        self._over.set()
        self._looking.join()

    def _look(self) -> None:
        while not self._over.wait(LOOK_S):
            self.bytes = max(
                self.bytes, float(sum(map(_proportional_size, _descendants(os.getpid()))))
            )


def _descendants(of: int) -> list[int]:
    """Their ids."""
    parents = {int(p.name): _parent(p) for p in PROCESSES.iterdir() if p.name.isdigit()}
    processes = [of]
    for ancestor in processes:  # which grows meanwhile
        processes += [process for process, parent in parents.items() if parent == ancestor]
    return processes[1:]


def _parent(process: Path) -> int:
    try:
        return int((process / "stat").read_text().rpartition(")")[2].split()[1])
    except OSError:  # it has ended
        return -1


def _proportional_size(process: int) -> int:
    """Bytes of a process, with its part of what it shares."""
    try:
        lines = (PROCESSES / str(process) / "smaps_rollup").read_text().splitlines()
    except OSError:
        return 0
    return next((1024 * int(line.split()[1]) for line in lines if line.startswith("Pss:")), 0)

"""``python -m benchmarks.suite [--part NAME]... [--quick]``: everything, or some parts of it.

Everything is printed, and written to benchmarks/results.json and results.png. Some parts alone, or
quick ones, write nothing: what is side by side in a file was measured in one run.
"""

from __future__ import annotations

import argparse
import importlib
import sys
import time

from benchmarks.suite.machine import describe_machine
from benchmarks.suite.report import format_markdown, write
from benchmarks.suite.rows import Row

# Name of every part, and its module here: a part whose packages are missing is not imported.
PARTS = {
    "single": "single",
    "ensemble": "lanes",
    "precision": "work_precision",
    "connectors": "exudyn_connectors",
    "studies": "studies",
    "sizes": "arm_sizes",
    "commands": "commands",
    "robots": "robots",
    "robot-kernels": "robot_kernels",
    "recordings": "recordings",
    "paper": "paper",
}
OPTIONAL_PART = "paper"  # takes as long as all others
REPEATS = 7


def main() -> None:
    """Measure what is asked, tell it, and write it where everything was measured."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.suite", description=__doc__)
    parser.add_argument("--part", action="append", choices=PARTS, help="only this one")
    parser.add_argument("--paper", action="store_true", help="the whole paper, too")
    parser.add_argument("--quick", action="store_true", help="every run once, fewer points")
    chosen = parser.parse_args()
    repeats, rows = 1 if chosen.quick else REPEATS, list[Row]()
    for part in chosen.part or [each for each in PARTS if each != OPTIONAL_PART or chosen.paper]:
        print(part, file=sys.stderr, flush=True)
        began = time.perf_counter()
        rows += importlib.import_module(f"benchmarks.suite.{PARTS[part]}").measure(repeats)
        print(f"{part}: {time.perf_counter() - began:.0f} s", file=sys.stderr)
    here = describe_machine(repeats)
    print(format_markdown(rows, here))
    if not (chosen.part or chosen.quick):
        write(rows, here)


if __name__ == "__main__":
    main()

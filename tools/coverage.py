"""docs/project/coverage.md: how much of each folder's code the suite runs, by `make coverage`."""

from __future__ import annotations

import json
import subprocess
import sys
from collections import Counter
from datetime import date
from pathlib import Path

ROOT = Path(__file__).parents[1]
PAGE = ROOT / "docs" / "project" / "coverage.md"
HEAD = """# Coverage

How many of the statements of each folder the test suite runs: {date}, revision {revision}, by
`make coverage`. Kernels are machine code made from text, and forces in Exudyn are compiled by
Numba: coverage sees neither, planted faults (`tests/faults`) do.

| folder | statements | run |
|---|---|---|
"""


def write_page(report: Path) -> None:
    """Write the page from the JSON report of coverage."""
    statements, run = Counter[str](), Counter[str]()
    for name, file in json.loads(report.read_text(encoding="utf-8"))["files"].items():
        parts = Path(name).parts[:-1]
        for folder in {"/".join(parts[:2]), "all"}:
            statements[folder] += file["summary"]["num_statements"]
            run[folder] += file["summary"]["covered_lines"]
    rows = [
        f"| {folder} | {count} | {run[folder] / count:.1%} |".replace("%", " %")
        for folder, count in sorted(statements.items(), key=lambda item: (item[0] == "all", item))
        if count
    ]
    words = ["git", "rev-parse", "--short=12", "HEAD"]
    revision = subprocess.run(words, cwd=ROOT, check=True, capture_output=True, text=True)
    head = HEAD.format(date=date.today().isoformat(), revision=revision.stdout.strip())
    PAGE.write_text(head + "\n".join(rows) + "\n", encoding="utf-8")


if __name__ == "__main__":
    write_page(Path(sys.argv[1]))

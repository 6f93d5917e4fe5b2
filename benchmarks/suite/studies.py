"""Part 5: studies of 1,000 and 10,000 members: rate, memory, and what the machinery adds."""

from __future__ import annotations

import importlib.util

from benchmarks.suite.rows import Row, absent

TABLE = "studies"


def measure(repeats: int) -> list[Row]:
    """Says so where the program has no studies yet."""
    if importlib.util.find_spec("crosscheck.sweep") is None:
        return [absent(TABLE, "1,000 and 10,000 members", "crosscheck.sweep does not exist")]
    raise NotImplementedError

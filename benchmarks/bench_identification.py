"""How often `compare` says of a robot what is true: ``python -m benchmarks.bench_identification``.

Recordings of kinds in tests/measured/statements.py, by default 100 of each: how many are told as
they are, of how many something false is said, and how many 95 % intervals of a rotor cover it.
Motions and noise of no two kinds are the same.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator

from tests.measured.statements import KINDS, judge

SEEDS = 100


def count_statements(seeds: int) -> Iterator[str]:
    """A line for each kind."""
    for number, (name, kind) in enumerate(KINDS.items()):
        own = range(number * seeds, (number + 1) * seeds)
        told, false, covered = map(sum, zip(*(judge(kind, seed) for seed in own), strict=True))
        yield f"{name}: truth told {told}, something false {false}, interval covers {covered}"


if __name__ == "__main__":
    for line in count_statements(int(sys.argv[1]) if len(sys.argv) > 1 else SEEDS):
        print(line, flush=True)

"""How often intervals of gains and zeros hold what is true: ``-m benchmarks.bench_refinement [N]``.

Links are drawn anew for every recording, from what its file is stated to know of them (2 %).
"""

from __future__ import annotations

import sys
from collections import Counter

from tests.measured.unknowns import estimate_unknowns

SEEDS = 100


def count_intervals(seeds: int) -> Counter[str]:
    """Of so many recordings, those whose 95 % intervals hold what is true, by the unknown."""
    held: Counter[str] = Counter()
    for seed in range(seeds):
        for each, value in estimate_unknowns(seed):
            held[each.term.name] += abs(each.value - value) < each.half_width
    return held


if __name__ == "__main__":
    count = int(sys.argv[1]) if len(sys.argv) > 1 else SEEDS
    for name, number in count_intervals(count).items():
        print(f"{name}: {number} of {count}")

"""How often `crosscheck compare` names the level and covers the payload that made a record.

Run as ``python -m benchmarks.bench_measured [seeds]`` from the project's folder; 100 seeds take
some ten minutes. Each seed makes two records of 10 s at 1 kHz with noise of 1e-5 rad and 0.1 N m:
one of the arm as its file has it, whose level is asked, and one with a payload heavier by 2 %,
whose payload is asked. Levels take turns. Prints what was named and covered, with 95 % intervals of
the shares (Clopper and Pearson).
"""

from __future__ import annotations

import sys
from collections import Counter

from scipy.stats import binomtest

from crosscheck.measured.parameters import changed
from crosscheck.models.arm.arm import Arm
from crosscheck.models.loading import load_arm
from crosscheck.registry import RIGID_LEVELS
from tests.measured.records import compared, level, record_of

SEEDS = 100
ROWS = 10_000
PAYLOAD, HEAVIER = "arm.payload_mass_kg", 1.02


def named(arm: Arm, true: str, seed: int) -> str:
    """What a record of the arm as its file has it is said to be: right, wrong or undecided."""
    found = compared(record_of(level(arm, true), seed, rows=ROWS), arm)
    if not found.decided:
        return "undecided"
    return "right" if found.best.name == true else "wrong"


def covered(arm: Arm, true: str, seed: int) -> str:
    """Where the 95 % interval of the payload lies that explains a record of a heavier one."""
    heavier = changed(arm, {PAYLOAD: HEAVIER * arm.payload_mass_kg})
    found = compared(record_of(level(heavier, true), seed, rows=ROWS), arm)
    for repair in found.repairs:
        estimate = repair.estimate
        if (repair.level, estimate.parameter.path) == (true, PAYLOAD):
            apart = abs(estimate.value - heavier.payload_mass_kg)
            return "covers it" if apart < estimate.half_width else "does not cover it"
    return "not named"


def main(seeds: int) -> None:
    """Print both counts."""
    arm = load_arm("paper-labelled")
    turns = [(RIGID_LEVELS[seed % len(RIGID_LEVELS)], seed) for seed in range(seeds)]
    for title, ask, good in (
        ("level of the record", named, "right"),
        ("payload heavier by 2 %, 95 % interval", covered, "covers it"),
    ):
        counts = Counter(ask(arm, true, seed) for true, seed in turns)
        shares = binomtest(counts[good], seeds).proportion_ci(0.95)
        told = ", ".join(f"{name} {count}" for name, count in counts.most_common())
        print(f"{title}: {told}; {good} in {shares.low:.3f} to {shares.high:.3f} of all")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else SEEDS)

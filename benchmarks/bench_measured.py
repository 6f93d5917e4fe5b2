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

from crosscheck.models.arm.arm import Arm
from crosscheck.models.loading import load_arm
from crosscheck.recordings.parameters import change_parameters
from crosscheck.registry import RIGID_LEVELS
from tests.measured.records import compared, level, record_of

SEEDS = 100
ROWS = 10_000
PAYLOAD, HEAVIER = "arm.payload_mass_kg", 1.02


def classify_record(arm: Arm, true: str, seed: int) -> str:
    """What a record of the arm as its file has it is said to be: right, wrong or undecided."""
    comparison = compared(record_of(level(arm, true), seed, rows=ROWS), arm)
    if not comparison.decided:
        return "undecided"
    return "right" if comparison.best.name == true else "wrong"


def check_payload_interval(arm: Arm, true: str, seed: int) -> str:
    """Where the 95 % interval of the payload lies that explains a record of a heavier one."""
    heavier = change_parameters(arm, {PAYLOAD: HEAVIER * arm.payload_mass_kg})
    comparison = compared(record_of(level(heavier, true), seed, rows=ROWS), arm)
    for repair in comparison.repairs:
        estimate = repair.estimate
        if (repair.level, estimate.parameter.path) == (true, PAYLOAD):
            error_kg = abs(estimate.value - heavier.payload_mass_kg)
            return "covers it" if error_kg < estimate.half_width else "does not cover it"
    return "not named"


def print_counts(seeds: int) -> None:
    """Print both counts."""
    arm = load_arm("paper-labelled")
    turns = [(RIGID_LEVELS[seed % len(RIGID_LEVELS)], seed) for seed in range(seeds)]
    for title, ask, good in (
        ("level of the record", classify_record, "right"),
        ("payload heavier by 2 %, 95 % interval", check_payload_interval, "covers it"),
    ):
        counts = Counter(ask(arm, true, seed) for true, seed in turns)
        shares = binomtest(counts[good], seeds).proportion_ci(0.95)
        summary = ", ".join(f"{name} {count}" for name, count in counts.most_common())
        print(f"{title}: {summary}; {good} in {shares.low:.3f} to {shares.high:.3f} of all")


if __name__ == "__main__":
    print_counts(int(sys.argv[1]) if len(sys.argv) > 1 else SEEDS)

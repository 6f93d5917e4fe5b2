"""How often `crosscheck compare` is right: ``python -m benchmarks.bench_measured [WHAT] [SEEDS]``.

``arm``, the usual one: whether it names the level and covers the payload that made a record. Each
seed makes two records of 10 s at 1 kHz with noise of 1e-5 rad and 0.1 N m: one of the arm as its
file has it, whose level is asked, and one with a payload heavier by 2 %, whose payload is asked.
Levels take turns; shares have 95 % intervals (Clopper and Pearson). 100 seeds, as many as there are
where none are stated, take some ten minutes.

``robot``: of recordings of the kinds in tests/measured/statements.py, of how many what is true is
said, of how many something false, and how many 95 % intervals of a rotor cover it. Motions
and noise of no two kinds are the same.

``unknowns``: how often intervals of gains and zeros hold what is true. Links are drawn anew for
every recording, from what its file is stated to know of them (2 %).
"""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Callable, Iterator

from scipy.stats import binomtest

from crosscheck.identification.mechanism import PlanarArm
from crosscheck.models.loading import load_arm
from crosscheck.registry import RIGID_LEVELS
from tests.measured.records import judged, level, list_explanations, record_of
from tests.measured.statements import KINDS, judge
from tests.measured.unknowns import estimate_unknowns

SEEDS = 100
ROWS = 10_000
PAYLOAD, HEAVIER = "arm.payload_mass_kg", 1.02


def classify_record(arm: PlanarArm, true: str, seed: int) -> str:
    """What a record of the arm as its file has it is said to be: right, wrong or undecided."""
    names = list_explanations(judged(record_of(level(arm.arm, true), seed, rows=ROWS), arm))
    if names == [(true, "")]:
        return "right"
    return "undecided" if (true, "") in names or not names else "wrong"


def check_payload_interval(arm: PlanarArm, true: str, seed: int) -> str:
    """Where the 95 % interval of the payload lies that explains a record of a heavier one."""
    heavier = arm.change({PAYLOAD: HEAVIER * arm.arm.payload_mass_kg})
    judgement = judged(record_of(level(heavier.arm, true), seed, rows=ROWS), arm)
    for each in judgement.explanations:
        if each.estimate and (each.level, each.parameter and each.parameter.path) == (
            true,
            PAYLOAD,
        ):
            error_kg = abs(each.estimate.value - heavier.arm.payload_mass_kg)
            return "covers it" if error_kg < each.estimate.half_width else "does not cover it"
    return "not named"


def count_levels_and_payloads(seeds: int) -> Iterator[str]:
    """A line for the levels, and one for the payloads."""
    arm = PlanarArm(load_arm("paper-labelled"))
    turns = [(RIGID_LEVELS[seed % len(RIGID_LEVELS)], seed) for seed in range(seeds)]
    for title, ask, good in (
        ("level of the record", classify_record, "right"),
        ("payload heavier by 2 %, 95 % interval", check_payload_interval, "covers it"),
    ):
        counts = Counter(ask(arm, true, seed) for true, seed in turns)
        shares = binomtest(counts[good], seeds).proportion_ci(0.95)
        summary = ", ".join(f"{name} {count}" for name, count in counts.most_common())
        yield f"{title}: {summary}; {good} in {shares.low:.3f} to {shares.high:.3f} of all"


def count_statements(seeds: int) -> Iterator[str]:
    """A line for each kind of a robot's recordings."""
    for number, (name, kind) in enumerate(KINDS.items()):
        own = range(number * seeds, (number + 1) * seeds)
        true, false, covered = map(sum, zip(*(judge(kind, seed) for seed in own), strict=True))
        yield f"{name}: true {true}, something false {false}, interval covers {covered}"


def count_intervals(seeds: int) -> Iterator[str]:
    """A line for each unknown: recordings whose 95 % intervals hold what is true."""
    held: Counter[str] = Counter()
    for seed in range(seeds):
        for each, value in estimate_unknowns(seed):
            held[each.term.name] += abs(each.value - value) < each.half_width
    yield from (f"{name}: {number} of {seeds}" for name, number in held.items())


COUNTS: dict[str, Callable[[int], Iterator[str]]] = {
    "arm": count_levels_and_payloads,
    "robot": count_statements,
    "unknowns": count_intervals,
}


def main(what: str = "arm", seeds: str = str(SEEDS)) -> None:
    """Print the counts of what is asked."""
    for line in COUNTS[what](int(seeds)):
        print(line, flush=True)


if __name__ == "__main__":
    main(*sys.argv[1:])

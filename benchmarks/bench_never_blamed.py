"""How often right equations are blamed: models of the project in random coordinates of random arms.

Run as ``python benchmarks/bench_never_blamed.py [pairs]`` from the project's folder; 200 pairs of
an arm and a map take some ten minutes. A pair is a whole trial: own checks, every engine, every
entry.
"""

from __future__ import annotations

import sys
from collections import Counter
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from crosscheck.models.arm.arm import Arm
from crosscheck.planning.sizing import make_unequal_gains_scenario
from crosscheck.trial.coordinates.build import LAYOUTS
from crosscheck.trial.input.equations import Coordinates
from crosscheck.trial.request import TrialRequest
from crosscheck.trial.trial import run_arm_trial
from tests.arms import random_arm
from tests.trial.test_trial import equations_of, in_frame

PAIRS = 200
LEVELS = ("links", "carriers", "armature", "coupled")
LENGTH_M = 0.05  # of a displacement beside a radian
WORST = 5  # decades of condition


class Pair(NamedTuple):
    """Right equations: whose, on which arm, in which coordinates, of which kind."""

    kind: str
    arm: Arm
    model: str
    coordinates: Coordinates


def draw_pair(seed: int) -> Pair:
    """One at random."""
    draw = np.random.default_rng(seed)
    arm, gearing = random_arm(seed, most_joints=4), str(draw.choice(["rigid", "lumped", "free"]))
    engines = ["analytic:physical", "pinocchio:gears"]
    if gearing == "rigid":
        engines = [f"{engine}:{level}" for engine in ("analytic", "pinocchio") for level in LEVELS]
    kind = str(draw.choice([*MAPS]))
    return Pair(kind, arm, str(draw.choice(engines)), MAPS[kind](draw, arm, gearing))


def _sizes(arm: Arm, gearing: str) -> np.ndarray:
    return np.where(LAYOUTS[gearing](arm).angular, 1.0, LENGTH_M)


def _draw_rotation(draw: np.random.Generator, n: int) -> np.ndarray:
    return np.linalg.qr(draw.normal(size=(n, n)))[0]


def draw_named(draw: np.random.Generator, arm: Arm, gearing: str) -> Coordinates:
    """Absolute or relative, displacements or gear angles."""
    links, gears = draw.choice(["relative", "absolute"]), draw.choice(["displacements", "angles"])
    return Coordinates(gearing, str(links), str(gears))


def draw_matrix(draw: np.random.Generator, arm: Arm, gearing: str) -> Coordinates:
    """A full matrix of a condition up to 1e5."""
    sizes = _sizes(arm, gearing)
    spread = np.geomspace(1, 10 ** -draw.uniform(0, WORST), sizes.size)
    full = _draw_rotation(draw, sizes.size) * spread @ _draw_rotation(draw, sizes.size)
    return Coordinates(gearing, matrix=sizes[:, None] * full)


def draw_units(draw: np.random.Generator, arm: Arm, gearing: str) -> Coordinates:
    """Coordinates in millionths and millions."""
    sizes = _sizes(arm, gearing)
    lower = np.tril(draw.normal(size=(sizes.size, sizes.size))) + 2 * np.eye(sizes.size)
    scaled = lower * 10 ** draw.uniform(-6, 6, sizes.size)
    return Coordinates(gearing, matrix=sizes[:, None] * scaled)


def draw_order(draw: np.random.Generator, arm: Arm, gearing: str) -> Coordinates:
    """The project's, in another order."""
    n = len(LAYOUTS[gearing](arm))
    return Coordinates(gearing, matrix=np.eye(n)[draw.permutation(n)])


def draw_curved(draw: np.random.Generator, arm: Arm, gearing: str) -> Coordinates:
    """A function that bends every coordinate and mixes them."""
    sizes = _sizes(arm, gearing)
    bends = draw.uniform(0.1, 0.6, sizes.size)
    mixed = np.eye(sizes.size) + 0.2 * np.tril(draw.normal(size=(sizes.size, sizes.size)), -1)
    return Coordinates(gearing, function=lambda x: sizes * (mixed @ (x + bends * np.sin(x))))


MAPS = {
    "named": draw_named,
    "matrix": draw_matrix,
    "units": draw_units,
    "order": draw_order,
    "curved": draw_curved,
}


def find_false_alarms(pair: Pair) -> list[str]:
    """The checks that are red and the entries that are called wrong."""
    moved = in_frame(pair.model, pair.coordinates, pair.arm, make_unequal_gains_scenario(pair.arm))
    equations = replace(equations_of(moved), coordinates=pair.coordinates)
    trial = run_arm_trial(TrialRequest("yours", equations, pair.arm, quick=True))
    return [finding.id for finding in trial.agreement.disagreeing] + [
        str(w.place) for w in trial.wrong_entries
    ]


def count_false_alarms() -> None:
    """Print how many pairs of each kind were tried, and which were blamed."""
    pairs = int(sys.argv[1]) if len(sys.argv) > 1 else PAIRS
    tally: Counter[str] = Counter()
    wrong = 0
    for seed in range(pairs):
        pair = draw_pair(seed)
        tally[pair.kind] += 1
        if false_alarms := find_false_alarms(pair):
            wrong += 1
            joints = len(pair.arm.joints)
            print(
                f"seed {seed}: {pair.kind}, {pair.model}, {joints} joints:"
                f" {', '.join(false_alarms)}"
            )
        print(f"{seed + 1} of {pairs}", end="\r", file=sys.stderr)
    print(", ".join(f"{count} {kind}" for kind, count in tally.items()))
    print(f"{wrong} of {pairs} right models blamed")


if __name__ == "__main__":
    count_false_alarms()

"""Which rigid level a rigid model is, or is closest to, and what it lacks to be the next."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from crosscheck.registry import RIGID_LEVELS
from crosscheck.trial.judge.places import deviations
from crosscheck.trial.judge.sizes import NaturalSizes

BRINGS = {
    "links": "links and payload",
    "carriers": "masses at the joints: rings, carriers, planets, suns, motors",
    "armature": "the gears' reflected inertia, on the diagonal",
    "coupled": "the gears' spin, coupled to the turning of their base",
}


@dataclass(frozen=True)
class Rung:
    """A rigid level beside a model: how many entries of M differ, the largest and the mean."""

    level: str
    entries: int
    largest: float
    mean: float

    @property
    def brings(self) -> str:
        """What it has beyond the level below."""
        return BRINGS[self.level]


def ladder(yours: np.ndarray, levels: Mapping[str, np.ndarray], sizes: NaturalSizes) -> list[Rung]:
    """Every level's mass matrix (count, n, n) against one handed over, in the levels' order."""
    rungs = []
    for level in RIGID_LEVELS:
        if level in levels:
            found = deviations(yours, levels[level], sizes.mass)
            count = int((~(found <= sizes.tolerance("mass_matrix"))).sum())
            rungs.append(Rung(level, count, float(found.max()), float(found.mean())))
    return rungs


def closest(rungs: list[Rung]) -> Rung:
    """The level that fewest entries differ from; of several the one that is least apart."""
    return min(rungs, key=lambda rung: (rung.entries, rung.mean))

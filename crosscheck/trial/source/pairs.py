"""Two edits whose effects add up to what is missing.

Idea: where two errors are in two terms of a sum, what two edits do to the answer is the sum of what
each does. Difficulty: of ten thousand edits there are fifty million pairs. Remedy: effects are
projected on one drawn direction, sorted, and the partner of each is looked up in its place.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

SEED = 3  # of the direction
MOST_NEAR = 50  # partners of one edit that are compared


def list_additive_pairs(effects: np.ndarray, missing: np.ndarray) -> Iterator[tuple[int, int]]:
    """Pairs of rows of effects (edits, entries) whose sum is what is missing (entries,).

    All are divided by what is allowed: a sum may miss each entry by one.
    """
    direction = np.random.default_rng(SEED).uniform(0.5, 1.0, missing.size)
    projected = effects @ direction
    order = np.argsort(projected)
    ascending, allowed = projected[order], direction.sum()
    partners = missing @ direction - projected
    begins = np.searchsorted(ascending, partners - allowed)
    ends = np.minimum(np.searchsorted(ascending, partners + allowed), begins + MOST_NEAR)
    for first in np.flatnonzero(begins < ends):
        near = order[begins[first] : ends[first]]
        misses = np.abs(effects[near] + effects[first] - missing).max(axis=1)
        yield from ((int(first), int(second)) for second in near[misses <= 1] if second > first)

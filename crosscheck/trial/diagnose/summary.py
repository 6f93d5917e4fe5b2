"""The same error in several entries told once, and a bias that only follows from a wrong M."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence

import numpy as np

from crosscheck.trial.diagnose.explain import NOISES
from crosscheck.trial.diagnose.keys import TermKey
from crosscheck.trial.diagnose.waves import Observed
from crosscheck.trial.judge.places import EntryPlace, TermError, Wrong

Entries = Mapping[tuple[int, int], Mapping[TermKey, float]]
FOLLOWS = 1e-9  # of a bias entry's difference, beside its noise


def told_once(wrong: Sequence[Wrong]) -> list[list[Wrong]]:
    """Those that the same errors explain together, in the order of their first entries."""
    found: defaultdict[object, list[Wrong]] = defaultdict(list)
    for number, each in enumerate(wrong):
        errors = each.explanation.errors if each.explanation else ()
        found[tuple(map(alike, errors)) or number].append(each)
    return list(found.values())


def alike(error: TermError) -> object:
    """What errors in other entries must share: of a swap, what is swapped; else the term too."""
    if error.kind == "swapped":
        return error.kind, error.yours, error.right
    term = error.term.coefficient.removeprefix("-")
    return error.kind, error.yours, error.right, error.by, term, error.term.angle


def bias_of(mass: Entries, turns: np.ndarray) -> dict[EntryPlace, dict[TermKey, float]]:
    """What differences of M, cosines and sines alone, do to a bias that follows from M.

    turns (joints, n): d theta / d x.
    """
    total: defaultdict[EntryPlace, defaultdict[TermKey, float]] = defaultdict(
        lambda: defaultdict(float)
    )
    for (i, j), waves in mass.items():
        for key, coefficient in waves.items():
            other = TermKey(key.wave, "sin" if key.function == "cos" else "cos")
            sign = -1 if key.function == "cos" else 1
            slopes = sign * coefficient * (np.array(key.wave) @ turns)
            for k in map(int, np.flatnonzero(slopes)):
                total[EntryPlace("bias", i, rates=_pair(j, k))][other] += slopes[k]
                total[EntryPlace("bias", k, rates=_pair(i, j))][other] -= slopes[k] / 2
    return {place: dict(waves) for place, waves in total.items()}


def _pair(j: int, k: int) -> tuple[int, int]:
    return min(j, k), max(j, k)


def follows(observed: Observed, expected: Mapping[TermKey, float]) -> bool:
    """Whether a bias entry's difference is what the differences of M make it."""
    keys = {*observed.coefficients, *expected}
    return all(
        abs(observed.coefficients.get(key, 0.0) - expected.get(key, 0.0))
        <= NOISES * observed.noise.get(key, 0.0) + FOLLOWS * abs(expected.get(key, 0.0))
        for key in keys
    )

"""Two numbers of an arm exchanged throughout a part of the equations: every pair is tried."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations, permutations
from typing import NamedTuple

import numpy as np

from crosscheck.trial.diagnose.candidates import find_reflecting_joint
from crosscheck.trial.diagnose.harmonic_fit import evaluate_entry
from crosscheck.trial.diagnose.polynomial import EntryTerms
from crosscheck.trial.diagnose.values import parse_symbol
from crosscheck.trial.judge.entries import Term, TermError

ALIKE = 1e-9  # of an entry's size or difference, what an exchange may leave of it


class SampledEntry(NamedTuple):
    """Yours minus right of an entry, (K,), which is 0 of a right one, and the terms that belong.

    values: the arm's quantities; angles (K, joints); signals (K,) by name; size: of the entry.
    """

    difference: np.ndarray
    size: float
    terms: EntryTerms
    values: Mapping[str, float]
    angles: np.ndarray
    signals: Mapping[str, np.ndarray]

    def is_made_by(self, instead: Mapping[str, str], *, reflected: bool = False) -> bool:
        """Whether other quantities in the place of some make the difference, or none in it.

        reflected: in the terms of reflected inertia alone.
        """
        values = {**self.values, **{name: self.values[other] for name, other in instead.items()}}
        inside = tuple(
            each
            for each in self.terms
            if not instead.keys().isdisjoint(each.symbols)
            and (find_reflecting_joint(each) or not reflected)
        )
        yours, right = (
            evaluate_entry(inside, numbers, self.angles, self.signals)
            for numbers in (values, self.values)
        )
        left = np.abs(self.difference - (yours - right)).max()
        return bool(left <= ALIKE * max(float(np.abs(self.difference).max()), self.size))


def find_exchange(samples: Sequence[SampledEntry]) -> tuple[str, str] | None:
    """The first two quantities of one kind whose exchange makes all entries of a part as they are.

    None too where one in the place of the other is enough. samples: every entry of the part on
    every arm, the most wrong ones first.
    """
    for first, second in _list_pairs(samples):
        both = {first: second, second: first}
        if all(each.is_made_by(both) for each in samples) and not any(
            all(each.is_made_by({name: both[name]}) for each in samples) for name in both
        ):
            return first, second
    return None


def find_reflected_exchange(samples: Sequence[SampledEntry]) -> TermError | None:
    """Reflected inertia of a joint where another's belongs, or both exchanged."""
    by_joint = defaultdict[int, set[str]](set)
    for product in (product for each in samples for product in each.terms):
        by_joint[find_reflecting_joint(product)].update(product.symbols)
    for first, second in permutations(sorted(joint for joint in by_joint if joint), 2):
        renamed, reverse = (
            {name: f"{parse_symbol(name).stem}{b}" for name in by_joint[a]}
            for a, b in ((first, second), (second, first))
        )
        right, yours = (f"the reflected inertia of joint {j}" for j in (first, second))
        if all(each.is_made_by(renamed, reflected=True) for each in samples):
            return TermError("swapped", Term("M", latex="M"), yours, right)
        if all(each.is_made_by(renamed | reverse, reflected=True) for each in samples):
            return TermError("exchanged", Term(""), right, yours)
    return None


def _list_pairs(samples: Sequence[SampledEntry]) -> Iterator[tuple[str, str]]:
    """Quantities of the same kind of two bodies or joints that the entries have."""
    symbols = dict.fromkeys(s for each in samples for p in each.terms for s in p.symbols)
    for first, second in combinations(sorted(symbols), 2):
        stems = {parse_symbol(first).stem, parse_symbol(second).stem}
        if len(stems) == 1 or stems == {"m", "m_payload"}:
            yield first, second

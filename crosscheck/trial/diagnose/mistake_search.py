"""Search for mistakes of a derivation that explain what is wrong in a part, on every arm."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from crosscheck.trial.diagnose.mistakes import ALL, ENERGY, Derivation, Words
from crosscheck.trial.diagnose.terms.candidates import FACTORS
from crosscheck.trial.judge.entries import Part, TermError

ALIKE = 1e-9  # largest residual of a mistake, relative to an entry's size or difference
FEW = slice(0, 4)  # states at which every mistake is tried
MOST_MATCHES = 40
TIMES = np.array([0.0, -1.0, *FACTORS])  # a term may be there
NEARLY = 1e-6  # between a factor and one of these
NOTHING = 1e-12  # largest effect that counts as none, relative to an entry's size
# The parts in which a mistake behind accelerations may be.
BEHIND: tuple[tuple[Part, ...], ...] = (ALL, ENERGY, ("force",), ("bias",), ("mass_matrix",))


class PartDifference(NamedTuple):
    """Yours minus right of a part on one arm (K, ...), by sizes of the entries (...).

    tolerance: relative, of rounding. Behind accelerations (K, n) at rates (K, n) the difference is
    that of the force M a + h.
    """

    derivation: Derivation
    difference: np.ndarray
    sizes: np.ndarray
    tolerance: float
    accelerations: np.ndarray | None = None
    rates: np.ndarray | None = None

    def predict(self, chosen: Sequence[Words], states: slice, parts: Sequence[Part]) -> np.ndarray:
        """Change of a part, or of the parts behind accelerations, by mistakes (mistakes, K, ..)."""
        changes = self.derivation.predict(chosen, states, parts)
        if self.accelerations is None or self.rates is None:
            (change,) = changes.values()
            return change
        total = np.zeros((len(chosen), *self.difference[states].shape))
        a, u = self.accelerations[states], self.rates[states]
        if "mass_matrix" in parts:
            total -= np.einsum("skij,kj->ski", changes["mass_matrix"], a)
        if "bias" in parts:
            total -= np.einsum("skijl,kj,kl->ski", changes["bias"], u, u)
        return total + changes["force"] if "force" in parts else total


class MatchingMistake(NamedTuple):
    """A mistake that makes wrong entries of these parts.

    covers: which entries (...); is_whole: whether it makes all that is wrong, and nothing else;
    parts: in which of the equations it is seen.
    """

    error: TermError
    covers: np.ndarray
    is_whole: bool
    parts: tuple[Part, ...]


def find_mistakes(
    arms: Sequence[PartDifference], wrong: np.ndarray, parts: tuple[Part, ...]
) -> list[MatchingMistake]:
    """Mistakes that make some of the wrong entries (...), on every arm: those of the most first.

    arms: the user's first.
    """
    first = arms[0]
    every = [*first.derivation.mistakes]
    screen = _match(first, every, FEW, parts, wrong)
    order = [
        number
        for number in np.flatnonzero(
            screen.covers.any(axis=tuple(range(1, wrong.ndim + 1)))
        ).tolist()
        if all(every[number] in arm.derivation.mistakes for arm in arms)
    ]
    order.sort(key=lambda number: (-screen.covers[number].sum(), not screen.is_whole[number]))
    order = order[:MOST_MATCHES]
    if not order:
        return []
    by, chosen = screen.by[order], [every[number] for number in order]
    covers, is_whole = wrong, np.ones(len(order), dtype=bool)
    for arm in arms:
        matched = _match(arm, chosen, slice(None), parts, wrong, by)
        covers, is_whole = covers & matched.covers, is_whole & matched.is_whole
    changes = first.derivation.predict(chosen, FEW, ALL)
    matching = [
        MatchingMistake(
            first.derivation.mistakes[words].make_error(float(times)),
            made,
            bool(whole),
            tuple(part for part in ALL if changes[part][number].any()),
        )
        for number, (words, times, made, whole) in enumerate(
            zip(chosen, by, covers, is_whole, strict=True)
        )
        if made.any()
    ]
    return sorted(matching, key=lambda each: (-each.covers.sum(), not each.is_whole))


class _Match(NamedTuple):
    by: np.ndarray  # (mistakes,)
    covers: np.ndarray  # (mistakes, ...)
    is_whole: np.ndarray  # (mistakes,)


def _match(
    arm: PartDifference,
    chosen: Sequence[Words],
    states: slice,
    parts: tuple[Part, ...],
    wrong: np.ndarray,
    by: np.ndarray | None = None,
) -> _Match:
    """Wrong entries that mistakes explain; factors of terms are fitted unless they are given."""
    change = arm.predict(chosen, states, parts) / arm.sizes
    difference = arm.difference[states] / arm.sizes
    squares = (change**2).sum(axis=1)
    there = squares > NOTHING**2
    if by is None:
        is_term = np.array([arm.derivation.mistakes[words].is_term for words in chosen])
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            each = np.where(there, (change * difference).sum(axis=1) / squares + 1, np.nan)
        each = np.where(is_term.reshape(-1, *(1,) * wrong.ndim), each, 2.0)
        by = _choose_factors(each[:, wrong])
    allowed = max(ALIKE, arm.tolerance)
    left = np.abs(difference - (by.reshape(-1, *(1,) * (change.ndim - 1)) - 1) * change)
    sure = allowed * np.maximum(np.abs(difference).max(axis=0), 1.0)
    is_made = (left.max(axis=1) <= sure) & ~np.isnan(by).reshape(-1, *(1,) * wrong.ndim)
    needed = (np.abs(difference).max(axis=0) <= sure) | there
    return _Match(by, is_made & needed & wrong, is_made.all(axis=tuple(range(1, wrong.ndim + 1))))


def _choose_factors(each: np.ndarray) -> np.ndarray:
    """The usual factor that fits most entries, by mistake; each (mistakes, entries) are fits."""
    near = np.abs(each[..., None] - TIMES) <= NEARLY
    votes = near.sum(axis=1)
    return np.where(votes.any(axis=1), TIMES[votes.argmax(axis=1)], np.nan)

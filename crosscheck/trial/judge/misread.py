"""Answers that are right but for their units or their order: told before entry after entry is."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import permutations
from typing import Literal

import numpy as np

from crosscheck.trial.input.calls import MATRICES
from crosscheck.trial.input.equations import AnswerTable
from crosscheck.trial.judge.places import PARTS, EntryPlace, Part, place_of

DEGREES = 180 / math.pi
FACTORS = tuple(f**power for f in (1000.0, DEGREES) for power in (1, -1, 2, -2))
NEAR = 0.02  # of a factor: an error beside it is looked at by itself
MOST = 0.8  # of the states, at which an entry shows it
SIZABLE = 1e-3  # of an entry's own root mean square: what is smaller shows nothing
FITS, DIFFERS = 1e-6, 1e-2  # of the sizes, in half of the numbers


@dataclass(frozen=True)
class Misread:
    """A part whose numbers are right but for their unit or order.

    Its entries at ``places`` are ``factor`` times the right ones, in most states; or its numbers
    are right in another order than the rows have them (factor None).
    """

    part: Part
    kind: Literal["unit", "order"]
    places: tuple[EntryPlace, ...] = ()
    factor: float | None = None


def misread(
    yours: Mapping[str, np.ndarray], right: Mapping[str, np.ndarray], table: AnswerTable | None
) -> tuple[Misread, ...]:
    """Parts that are right but for unit or order.

    yours, right: answers (states, ...) by part, and the right ones; table: the answers of files,
    whose order may be wrong.
    """
    found: list[Misread] = []
    for quantity, own in yours.items():
        found += _units(quantity, own, right[quantity])
        if table is not None and quantity in ("mass_matrix", "force", "acceleration"):
            found += _order(quantity, own, right[quantity], table)
    return tuple(found)


def _units(quantity: str, yours: np.ndarray, right: np.ndarray) -> Iterator[Misread]:
    """The entries that are one of FACTORS times the right ones at most states, by factor."""
    by_factor: dict[float, list[EntryPlace]] = {}
    for index in np.ndindex(yours.shape[1:]):
        own, expected = yours[(slice(None), *index)], right[(slice(None), *index)]
        there = np.abs(expected) > SIZABLE * np.sqrt((expected**2).mean())
        if not there.any():
            continue
        with np.errstate(over="ignore"):  # of numbers that are wrong by all means
            ratios = own[there] / expected[there]
            near = (f for f in FACTORS if (np.abs(ratios / f - 1) < NEAR).mean() > MOST)
            factor = next(near, None)
        if factor is not None:
            by_factor.setdefault(factor, []).append(place_of(quantity, index))
    for factor, places in by_factor.items():
        yield Misread(PARTS[quantity], "unit", tuple(places), factor)


def _order(
    quantity: str, yours: np.ndarray, right: np.ndarray, table: AnswerTable
) -> Iterator[Misread]:
    """The part, if its numbers fit once they are read in another order."""
    size = np.sqrt((right**2).mean()) or 1.0
    if np.median(np.abs(yours - right)) < DIFFERS * size:
        return
    values, n = table.values[quantity], right.shape[1]
    if np.isnan(values).any():  # rows were left out: nothing was flattened as a whole
        return
    lengths = (len(values), n, n) if quantity in MATRICES else (len(values), n)
    for order in permutations(range(len(lengths))):
        for flat in (values.ravel(), values.ravel(order="F")):
            shape = [lengths[axis] for axis in order]
            read = flat.reshape(shape).transpose(np.argsort(order))[table.at[quantity]]
            if np.median(np.abs(read - right)) < FITS * size:
                yield Misread(PARTS[quantity], "order")
                return

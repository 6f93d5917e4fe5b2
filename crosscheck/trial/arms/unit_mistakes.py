"""Answers that are right but for their units or their order: reported before single entries."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import permutations
from typing import Literal

import numpy as np

from crosscheck.trial.input.calls import MATRICES
from crosscheck.trial.input.equations import AnswerTable
from crosscheck.trial.judge.entries import PARTS, EntryPlace, Part, entry_place

DEGREES = 180 / math.pi
FACTORS = tuple(f**power for f in (1000.0, DEGREES) for power in (1, -1, 2, -2))
NEAR = 0.02  # relative tolerance of a factor: other errors are reported beside it
MOST = 0.8  # least share of the states at which an entry shows the factor
SIZABLE = 1e-3  # least value that is compared, relative to its entry's root mean square
FITS = 1e-6  # largest median difference of right values, relative to their rms


@dataclass(frozen=True)
class UnitMistake:
    """A part whose numbers are right but for their unit or order.

    Its entries at ``places`` are ``factor`` times the right ones, in most states; or its numbers
    are right in another order than the rows have them (factor None).
    """

    part: Part
    kind: Literal["unit", "order"]
    places: tuple[EntryPlace, ...] = ()
    factor: float | None = None


def find_unit_mistakes(
    user_values: Mapping[str, np.ndarray],
    reference_values: Mapping[str, np.ndarray],
    table: AnswerTable | None,
) -> tuple[UnitMistake, ...]:
    """Parts that are right but for unit or order.

    user_values, reference_values: answers (states, ...) by part, and the right ones; table: the
    answers of files, whose order may be wrong.
    """
    mistakes: list[UnitMistake] = []
    for quantity, values in user_values.items():
        mistakes += _find_unit_factors(quantity, values, reference_values[quantity])
        if table is not None and quantity in ("mass_matrix", "gravity", "force", "acceleration"):
            mistakes += _find_order_mistake(quantity, values, reference_values[quantity], table)
    return tuple(mistakes)


def _find_unit_factors(
    quantity: str, user_values: np.ndarray, reference_values: np.ndarray
) -> Iterator[UnitMistake]:
    """The entries that are one of FACTORS times the right ones at most states, by factor."""
    by_factor: dict[float, list[EntryPlace]] = {}
    for index in np.ndindex(user_values.shape[1:]):
        user_entry, reference_entry = (
            user_values[(slice(None), *index)],
            reference_values[(slice(None), *index)],
        )
        there = np.abs(reference_entry) > SIZABLE * np.sqrt((reference_entry**2).mean())
        if not there.any():
            continue
        with np.errstate(over="ignore"):  # of numbers that are wrong by all means
            ratios = user_entry[there] / reference_entry[there]
            near = (f for f in FACTORS if (np.abs(ratios / f - 1) < NEAR).mean() > MOST)
            factor = next(near, None)
        if factor is not None:
            by_factor.setdefault(factor, []).append(entry_place(quantity, index))
    for factor, places in by_factor.items():
        yield UnitMistake(PARTS[quantity], "unit", tuple(places), factor)


def _find_order_mistake(
    quantity: str, user_values: np.ndarray, reference_values: np.ndarray, table: AnswerTable
) -> Iterator[UnitMistake]:
    """The part, if its numbers fit once they are read in another order."""
    size = np.sqrt((reference_values**2).mean()) or 1.0
    if np.median(np.abs(user_values - reference_values)) < FITS * size:
        return
    values, n = table.values[quantity], reference_values.shape[1]
    if np.isnan(values).any():  # rows were left out: nothing was flattened as a whole
        return
    lengths = (len(values), n, n) if quantity in MATRICES else (len(values), n)
    for order in permutations(range(len(lengths))):
        for flat in (values.ravel(), values.ravel(order="F")):
            shape = [lengths[axis] for axis in order]
            read = flat.reshape(shape).transpose(np.argsort(order))[table.at[quantity]]
            if np.median(np.abs(read - reference_values)) < FITS * size:
                yield UnitMistake(PARTS[quantity], "order")
                return

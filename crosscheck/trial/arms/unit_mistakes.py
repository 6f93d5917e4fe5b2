"""Answers that are right but for their units or their order: reported before single entries."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from itertools import permutations

import numpy as np

from crosscheck.trial.input.calls import MATRICES
from crosscheck.trial.input.equations import AnswerTable
from crosscheck.trial.judge.entries import EntryPlace, entry_place, list_entries

DEGREES = 180 / math.pi
UNITS = {"1000": 1000.0, "180/pi": DEGREES}
FACTORS = {
    by**power: words if power == 1 else f"({words})^{power}"
    for words, by in UNITS.items()
    for power in (1, -1, 2, -2)
}
NEAR = 0.02  # relative tolerance of a factor: other errors are reported beside it
MOST = 0.8  # least share of the states at which an entry shows the factor
SIZABLE = 1e-3  # least value that is compared, relative to its entry's root mean square
ORDERED = "mass_matrix", "gravity", "force", "acceleration"  # parts of tables
FITS = 1e-6  # largest median difference of right values, relative to their rms


def describe_unit_mistakes(
    user_values: Mapping[str, np.ndarray],
    reference_values: Mapping[str, np.ndarray],
    table: AnswerTable | None,
    names: Sequence[str],
) -> Iterator[str]:
    """Sentences on parts whose numbers are right but for unit or order.

    user_values, reference_values: answers (states, ...) by part, and the right ones; table: the
    answers of files, whose order may be wrong; names: of the coordinates.
    """
    for quantity, values in user_values.items():
        factors = _find_unit_factors(quantity, values, reference_values[quantity])
        for factor, places in factors.items():
            times = f"{list_entries(places, names)}: {FACTORS[factor]} times"
            yield f"{times} what the models say at every state: another unit?"
        if table is None or quantity not in ORDERED:
            continue
        if _has_other_order(quantity, values, reference_values[quantity], table):
            part = "M" if quantity == "mass_matrix" else quantity
            how = "flattened the other way?"
            yield f"{part} agrees once its numbers are read in another order: {how}"


def _find_unit_factors(
    quantity: str, user_values: np.ndarray, reference_values: np.ndarray
) -> dict[float, list[EntryPlace]]:
    """The entries that are one of FACTORS times the right ones at most states, by factor."""
    by_factor: dict[float, list[EntryPlace]] = {}
    for index in np.ndindex(user_values.shape[1:]):
        at = (slice(None), *index)
        user_entry, reference_entry = user_values[at], reference_values[at]
        there = np.abs(reference_entry) > SIZABLE * np.sqrt((reference_entry**2).mean())
        if not there.any():
            continue
        with np.errstate(over="ignore"):  # of numbers that are wrong by all means
            ratios = user_entry[there] / reference_entry[there]
            near = (f for f in FACTORS if (np.abs(ratios / f - 1) < NEAR).mean() > MOST)
            factor = next(near, None)
        if factor is not None:
            by_factor.setdefault(factor, []).append(entry_place(quantity, index))
    return by_factor


def _has_other_order(
    quantity: str, user_values: np.ndarray, reference_values: np.ndarray, table: AnswerTable
) -> bool:
    """Whether numbers of a part fit once they are read in another order."""
    size = np.sqrt((reference_values**2).mean()) or 1.0
    if np.median(np.abs(user_values - reference_values)) < FITS * size:
        return False
    values, n = table.values[quantity], reference_values.shape[1]
    if np.isnan(values).any():  # rows were left out: nothing was flattened as a whole
        return False
    lengths = (len(values), n, n) if quantity in MATRICES else (len(values), n)
    for order in permutations(range(len(lengths))):
        for flat in (values.ravel(), values.ravel(order="F")):
            shape = [lengths[axis] for axis in order]
            read = flat.reshape(shape).transpose(np.argsort(order))[table.at[quantity]]
            if np.median(np.abs(read - reference_values)) < FITS * size:
                return True
    return False

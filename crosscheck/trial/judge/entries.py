"""Which entries differ, each on its own scale."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from crosscheck.trial.judge.places import EntryPlace, Part, Wrong
from crosscheck.trial.judge.sizes import NaturalSizes

PARTS: dict[str, Part] = {
    "mass_matrix": "mass_matrix",
    "rate_terms": "bias",
    "bias": "bias",
    "force": "force",
    "acceleration": "acceleration",
}


def deviations(one: np.ndarray, other: np.ndarray, size: np.ndarray) -> np.ndarray:
    """Largest difference of every entry over the states, relative to its size: shape of size.

    one, other (count, ...): the states along the first axis.
    """
    return np.abs(one - other).max(axis=0) / size


def wrong_entries(
    quantity: str, yours: np.ndarray, right: np.ndarray, sizes: NaturalSizes
) -> Iterator[Wrong]:
    """The entries of a part that differ by more than rounding, the largest difference first."""
    found = deviations(yours, right, sizes.of(quantity))
    beyond = np.argwhere(~(found <= sizes.tolerance(quantity)))
    for index in sorted(map(tuple, beyond.tolist()), key=lambda at: -found[at]):
        yield Wrong(place_of(quantity, index), float(found[index]))


def place_of(quantity: str, index: tuple[int, ...]) -> EntryPlace:
    """The place of an entry of a part's array."""
    part, row = PARTS[quantity], index[0]
    if quantity == "mass_matrix":
        return EntryPlace(part, row, column=index[1])
    if quantity == "rate_terms":
        return EntryPlace(part, row, rates=(index[1], index[2]))
    return EntryPlace(part, row)

"""Where in equations of motion something stands, and what is wrong there."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from crosscheck.trial.judge.sizes import NaturalSizes

Part = Literal["mass_matrix", "bias", "force", "acceleration"]
SHOWN = 8  # of a list of places; the report has them all
PARTS: dict[str, Part] = {
    "mass_matrix": "mass_matrix",
    "rate_terms": "bias",
    "bias": "bias",
    "force": "force",
    "acceleration": "acceleration",
}


@dataclass(frozen=True)
class EntryPlace:
    """An entry, counted from 0: M[row, column]; bias[row] in v_j v_k, j <= k; force[row]."""

    part: Part
    row: int
    column: int | None = None
    rates: tuple[int, int] | None = None


@dataclass(frozen=True)
class Term:
    """coefficient * cosine or sine of an angle sum: what stands in an entry for too much or little.

    coefficient, angle, signal: text as one writes it (``m_payload L2 L1``, ``theta_1 - theta_2``,
    ``F_sp1``), empty for 1, no angle, none; latex: the whole term.
    """

    coefficient: str
    wave: Literal["", "cos", "sin"] = ""
    angle: str = ""
    signal: str = ""
    latex: str = ""


@dataclass(frozen=True)
class TermError:
    """A term of an entry as it must be, and what stands there instead.

    kind: ``sign``, ``factor`` (``by``: yours over right), ``dropped``, ``swapped`` (``yours`` where
    ``right`` belongs), ``angle`` (the same of an angle sum), ``extra``. term: the right one, of
    ``extra`` the one too many.
    """

    kind: Literal["sign", "factor", "dropped", "swapped", "angle", "extra"]
    term: Term
    yours: str = ""
    right: str = ""
    by: float | None = None


@dataclass(frozen=True)
class Explanation:
    """Errors that together make a difference, and what they leave of it, relative to that.

    others: explanations that fit as well with the arm's numbers (equal lengths, say), likeliest
    first. seen_in: in words, where the errors are, if not in this entry: entries in other
    coordinates, in which they are fewer.
    """

    errors: tuple[TermError, ...]
    left_over: float
    others: tuple[tuple[TermError, ...], ...] = ()
    seen_in: str = ""


@dataclass(frozen=True)
class Wrong:
    """An entry that is wrong: by how much (relative to the entry's natural size), and perhaps why.

    difference: yours minus right in numbers, of an entry that nothing explains. latex: the same
    typeset, of symbolic equations. shown_on: name of the arm that shows it, where the one on trial
    cannot.
    """

    place: EntryPlace
    relative: float
    explanation: Explanation | None = None
    difference: tuple[Term, ...] = ()
    latex: str = ""
    shown_on: str = ""
    notes: tuple[str, ...] = field(default=())


def named(place: EntryPlace, names: Sequence[str]) -> str:
    """Such as M[phi_1, phi_2], bias[phi_1] of phi_1' phi_2', force[phi_1]."""
    row = names[place.row]
    if place.part == "mass_matrix":
        assert place.column is not None  # of a matrix
        return f"M[{row}, {names[place.column]}]"
    if place.rates is not None:
        j, k = place.rates
        rates = f"{names[j]}'^2" if j == k else f"{names[j]}' {names[k]}'"
        return f"bias[{row}] of {rates}"
    return f"{place.part}[{row}]"


def listed(places: Sequence[EntryPlace], names: Sequence[str]) -> str:
    """Several of them, the first few by name; '' for none."""
    shown = ", ".join(named(place, names) for place in places[:SHOWN])
    rest = len(places) - SHOWN
    return f"wrong: {shown}{f' and {rest} more' if rest > 0 else ''}" if places else ""


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

"""Places in equations of motion by the names of the user's coordinates."""

from __future__ import annotations

from collections.abc import Sequence

from crosscheck.trial.judge.places import EntryPlace

SHOWN = 8  # of a list of places; the report has them all


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

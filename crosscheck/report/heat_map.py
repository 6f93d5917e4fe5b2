"""A quantity entry by entry: a tick where it agrees, else how far it is off in per cent."""

from __future__ import annotations

import bisect
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from crosscheck.findings import EntryDifferences
from crosscheck.registry import model_names
from crosscheck.report.formatting import format_percent

TICK = "\N{CHECK MARK}"
DECADES = (1e-6, 1e-4, 1e-2)  # relative differences between the shades of a cell
PALEST = 1e-6  # relative difference of the palest colour; 1 has the darkest
MANY = 8  # columns whose names are written upwards


@dataclass(frozen=True)
class HeatCell:
    """A cell: its text, its shade from 0 for an entry that agrees to 4 for 1 % and more.

    depth: of its colour, from 0 for the palest to 100; logarithmic. None for an entry that agrees.
    """

    text: str
    shade: int
    depth: int | None = None


@dataclass(frozen=True)
class HeatMap:
    """A table of entries with the names of its rows and columns; no column names for a vector."""

    title: str
    rows: tuple[str, ...]
    columns: tuple[str, ...]
    cells: tuple[tuple[HeatCell, ...], ...]

    @property
    def is_wide(self) -> bool:
        """Whether its columns are too many for names beside each other."""
        return len(self.columns) > MANY

    @property
    def described(self) -> str:
        """The map in a phrase, for those who cannot see it."""
        count = sum(map(len, self.cells))
        return f"{self.title}: {self.wrong} of {count} entries differ"

    @property
    def wrong(self) -> int:
        """How many entries differ."""
        return sum(cell.shade > 0 for row in self.cells for cell in row)


def make_heat_map(
    title: str, names: Sequence[str], relative: np.ndarray, tolerance: float
) -> HeatMap:
    """The map of relative differences of a matrix (n, n), or a vector (n,), in n coordinates.

    tolerance: the largest that is allowed.
    """
    rows = relative.reshape(len(names), -1).tolist()
    cells = tuple(tuple(make_heat_cell(value, tolerance) for value in row) for row in rows)
    return HeatMap(title, tuple(names), tuple(names) if relative.ndim == 2 else ("",), cells)


def make_heat_cell(value: float, tolerance: float) -> HeatCell:
    """The cell of a relative difference; what is no number differs."""
    if value <= tolerance:
        return HeatCell(TICK, 0)
    part = 1 - np.log(value) / np.log(PALEST) if value < 1 else 1.0  # what is no number: darkest
    depth = round(100 * max(part, 0.0))
    return HeatCell(format_percent(value), 1 + bisect.bisect_right(DECADES, value), depth)


def make_entry_maps(entries: Sequence[EntryDifferences]) -> list[HeatMap]:
    """M of the printed equations beside the corrected ones; of arms without, M of the latter."""
    masses = {each.model: each for each in entries if each.quantity == "mass_matrix"}
    forms = [name for name in masses if name in model_names("form")]
    titles = dict.fromkeys(forms, "mass matrix, as printed")
    other = "mass matrix, corrected" if forms else "mass matrix"
    shown = [(titles.get(n, other), each) for n, each in masses.items() if n not in forms[:-1]]
    return [make_heat_map(t, e.coordinates, np.array(e.relative), e.tolerance) for t, e in shown]

"""Tables in text files, read line by line: a line of names, then rows, numbers where asked for."""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from itertools import islice
from pathlib import Path

import numpy as np

from crosscheck.models.errors import InputError
from crosscheck.models.inputs import open_input

LARGEST_FILE = 2_000_000_000  # size of a file [bytes]
PIECE = 2**15  # rows that are read at a time


@dataclass(frozen=True)
class CsvTable:
    """A table in a file, its rows on disk, with names of its columns.

    separator: between columns; None for blanks, of which several are one.
    """

    path: Path
    names: tuple[str, ...]
    separator: str | None

    @property
    def where(self) -> str:
        """The file, as messages call it."""
        return str(self.path)

    def read_pieces(self, places: Sequence[int]) -> Iterator[np.ndarray]:
        """Columns at these places (rows, columns), so many rows at a time; others may hold words.

        An empty cell is no number. Raises InputError.
        """
        is_empty = True
        for lines in self._read_lines():
            is_empty = False
            yield self._parse(lines, places)
        if is_empty:
            raise InputError(self.where, "", None, "has no rows below the names of its columns")

    def count_rows(self) -> int:
        """The number of rows. Raises InputError."""
        return sum(map(len, self.read_pieces([])))

    def select_pieces(self, columns: Sequence[str]) -> Iterator[np.ndarray]:
        """Columns of these names (rows, columns), of no number where the name is empty.

        So many rows at a time. Raises InputError for a column that is not there, and after the last
        row for one that holds anything but numbers.
        """
        for name in filter(None, columns):
            if self.names.count(name) != 1:
                there = ", ".join(self.names)[:300]
                count = "is there twice" if name in self.names else f"is no column; it has {there}"
                raise InputError(self.where, name, None, count)
        measured = [place for place, name in enumerate(columns) if name]
        places = [self.names.index(columns[at]) for at in measured]
        rows, first_wrong = 0, np.zeros(len(columns), dtype=int)  # rows from 1; 0 without
        holds_number = np.zeros(len(columns), dtype=bool)
        for values in self.read_pieces(places):
            chosen = np.full((len(values), len(columns)), np.nan)
            chosen[:, measured] = values
            able = np.isfinite(chosen)
            here = np.where(able.all(axis=0), 0, rows + 1 + able.argmin(axis=0))
            first_wrong = np.where(first_wrong > 0, first_wrong, here)
            holds_number |= able.any(axis=0)
            rows += len(values)
            yield chosen
        wrong = [at for at in measured if first_wrong[at]]
        if wrong:
            place = min(wrong, key=lambda at: int(first_wrong[at]))
            name = columns[place]
            if not holds_number[place]:
                raise InputError(self.where, name, None, "is no number in any row: not measured?")
            field = f"{name}, row {first_wrong[place]}"
            raise InputError(self.where, field, None, "must be a number")

    def _read_lines(self) -> Iterator[list[str]]:
        """Lines that are not blank below the names, so many at a time, a dot before decimals."""
        with _open_text(self.path) as text:
            text.readline()
            lines = (line for line in text if not line.isspace())
            while piece := list(islice(lines, PIECE)):
                yield piece if self.separator == "," else [_point(line) for line in piece]

    def _parse(self, lines: list[str], places: Sequence[int]) -> np.ndarray:
        """Cells of lines at these places as numbers (rows, places). Raises InputError."""
        if any(_count_cells(line, self.separator) != len(self.names) for line in lines):
            raise self._find_bad_line(places)
        if not places:
            return np.empty((len(lines), 0))
        order, back = np.unique(places, return_inverse=True)
        read = partial(
            np.loadtxt, lines, delimiter=self.separator, ndmin=2, comments=None, quotechar='"'
        )
        try:
            values = read(usecols=order)
        except ValueError:
            try:
                values = read(usecols=order, converters=_read_cell)
            except ValueError:
                raise self._find_bad_line(places) from None
        return np.asarray(values[:, back])

    def _find_bad_line(self, places: Sequence[int]) -> InputError:
        """The error of the first line that has not a number at all of these places."""
        names = self.names
        with _open_text(self.path) as text:
            text.readline()
            for number, line in enumerate(text, 2):
                if line.isspace():
                    continue
                cells = _split(line if self.separator == "," else _point(line), self.separator)
                if len(cells) != len(names):
                    reason = f"has {len(cells)} columns, must have {len(names)}, as line 1"
                    return InputError(self.where, f"line {number}", None, reason)
                for place in sorted(places):
                    try:
                        _read_cell(cells[place])
                    except ValueError:
                        field = f"line {number}, {names[place]}"
                        return InputError(self.where, field, cells[place][:40], "must be a number")
        return InputError(self.where, "", None, "cannot be read as a table")


def open_table(path: Path) -> CsvTable:
    """The table in a text file: a line of names; commas, semicolons, tabs or blanks separate.

    A `#` may stand before the names. Where no commas separate, one may stand before decimals.
    Raises InputError.
    """
    with _open_text(path) as text:
        head = text.readline().strip().removeprefix("#")
    separator = next((each for each in (";", "\t", ",") if each in head), None)
    names = tuple(name.strip() for name in _split(head, separator)) or ("",)
    if all(re.fullmatch(r"[-+.,\deE]+", name) for name in names):
        reason = "holds numbers; must hold the columns' names"
        raise InputError(str(path), "line 1", None, reason)
    return CsvTable(path, names, separator)


def _split(line: str, separator: str | None) -> list[str]:
    """The cells of a line; a quoted one may hold the separator."""
    if '"' not in line:
        return [cell.strip() for cell in line.split(separator)]
    quoted = csv.reader([line.strip()], delimiter=separator or " ", skipinitialspace=True)
    return [cell.strip() for cell in next(quoted, [])]


def _count_cells(line: str, separator: str | None) -> int:
    if '"' in line or separator is None:
        return len(_split(line, separator))
    return line.count(separator) + 1


def _point(line: str) -> str:
    """The line with a dot before decimals."""
    return line.replace(",", ".")


def _read_cell(cell: str) -> float:
    """The number in a cell; none in an empty one. Raises ValueError."""
    return float(cell) if cell.strip() else np.nan


@contextmanager
def _open_text(path: Path) -> Iterator[io.TextIOWrapper]:
    """An input as text. Raises InputError, also for what turns out to be none while it is read."""
    try:
        with (
            open_input(path, LARGEST_FILE) as file,
            io.TextIOWrapper(file, encoding="utf-8-sig") as text,
        ):
            yield text
    except UnicodeDecodeError:
        reason = "is not UTF-8 text; a CSV file is expected"
        raise InputError(str(path), "", None, reason) from None

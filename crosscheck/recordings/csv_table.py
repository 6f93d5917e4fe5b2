"""Tables in text files, read line by line: a line of names, then rows, numbers where asked for."""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
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
        rows, is_empty = self._read_rows(places), True
        while piece := list(islice(rows, PIECE)):
            is_empty = False
            yield np.array(piece).reshape(len(piece), len(places))
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
                count = "two columns" if name in self.names else "no column"
                raise InputError(self.where, "", None, f"{count} {name}; it has {there}")
        measured = [place for place, name in enumerate(columns) if name]
        places = [self.names.index(columns[at]) for at in measured]
        rows, first_wrong, silent = 0, dict[int, int](), set(measured)  # rows from 1
        for values in self.read_pieces(places):
            chosen = np.full((len(values), len(columns)), np.nan)
            chosen[:, measured] = values
            for at, able in zip(measured, np.isfinite(values).T, strict=True):
                if able.any():
                    silent.discard(at)
                if not able.all():
                    first_wrong.setdefault(at, rows + 1 + int(able.argmin()))
            rows += len(values)
            yield chosen
        if first_wrong:
            place = min(first_wrong, key=first_wrong.__getitem__)
            name = columns[place]
            if place in silent:
                raise InputError(self.where, name, None, "holds no numbers: not measured?")
            field = f"{name}, data row {first_wrong[place]}"
            raise InputError(self.where, field, None, "must be a number")

    def _read_rows(self, places: Sequence[int]) -> Iterator[list[float]]:
        """The numbers at these places, in each line below the names that is not blank."""
        with _open_text(self.path) as text:
            text.readline()
            lines = (line for line in text if not line.isspace())
            for number, line in enumerate(lines, 1):
                decimal = line if self.separator == "," else line.replace(",", ".")
                cells, row = _split(decimal, self.separator), list[float]()
                if len(cells) != len(self.names):
                    reason = f"has {len(cells)} columns, must have {len(self.names)}, as line 1"
                    raise InputError(self.where, f"data row {number}", None, reason)
                for place in places:
                    try:
                        row.append(float(cells[place] or "nan"))
                    except ValueError:
                        field = f"{self.names[place]}, data row {number}"
                        shown = cells[place][:40]
                        raise InputError(self.where, field, shown, "must be a number") from None
                yield row


def open_table(path: Path) -> CsvTable:
    """The table in a text file: a line of names; commas, semicolons, tabs or blanks separate.

    A `#` may stand before the names. Where no commas separate, one may stand before decimals.
    Raises InputError.
    """
    with _open_text(path) as text:
        if not (line := text.readline()):
            raise InputError(str(path), "", None, "is empty; a CSV file is expected")
    head = line.strip().removeprefix("#")
    separator = next((each for each in (";", "\t", ",") if each in head), None)
    names = tuple(_split(head, separator)) or ("",)
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

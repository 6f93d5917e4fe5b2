"""Tables of numbers in CSV files, read line by line: a line of names, then rows of numbers."""

from __future__ import annotations

import io
import re
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

import numpy as np

from crosscheck.models.errors import InputError
from crosscheck.models.inputs import open_input

LARGEST_FILE = 2_000_000_000  # bytes
PIECE = 2**15  # rows that are read at a time


@dataclass(frozen=True)
class CsvTable:
    """A table of numbers in a file, its rows on disk, with names of its columns."""

    path: Path
    names: tuple[str, ...]
    separator: str

    @property
    def where(self) -> str:
        """The file, as messages call it."""
        return str(self.path)

    def read_pieces(self) -> Iterator[np.ndarray]:
        """All columns (rows, columns), so many rows at a time. Raises InputError."""
        is_empty = True
        with _open_text(self.path) as text:
            text.readline()
            lines = _select_lines(text, self.separator)
            while piece := list(islice(lines, PIECE)):
                values = self._parse(piece)
                if values.size:
                    is_empty = False
                    yield values
        if is_empty:
            raise InputError(self.where, "", None, "has no rows below the names of its columns")

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
        for values in self.read_pieces():
            chosen = np.full((len(values), len(columns)), np.nan)
            chosen[:, measured] = values[:, places]
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

    def _parse(self, lines: list[str]) -> np.ndarray:
        """Lines as rows of numbers, none for empty lines. Raises InputError."""
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # of lines without rows
                values = np.loadtxt(lines, delimiter=self.separator, ndmin=2, comments=None)
        except ValueError as error:
            raise _find_bad_line(self) or InputError(self.where, "", None, str(error)) from None
        if values.size and values.shape[1] != len(self.names):
            reason = f"names {len(self.names)} columns, the rows have {values.shape[1]}"
            raise InputError(self.where, "line 1", None, reason)
        return values


def open_table(path: Path) -> CsvTable:
    """The table in a CSV file: a line of names, commas, semicolons or tabs between columns.

    Where no commas separate, one may stand before decimals. Raises InputError.
    """
    with _open_text(path) as text:
        head = text.readline()
    separator = next((each for each in (";", "\t", ",") if each in head), ",")
    names = tuple(name.strip().strip('"') for name in head.split(separator))
    if all(re.fullmatch(r"[-+.,\deE]+", name) for name in names):
        reason = "holds numbers; must hold the columns' names"
        raise InputError(str(path), "line 1", None, reason)
    return CsvTable(path, names, separator)


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


def _select_lines(text: io.TextIOWrapper, separator: str) -> Iterator[str] | io.TextIOWrapper:
    """The lines that are left, a dot before decimals."""
    return text if separator == "," else (line.replace(",", ".") for line in text)


def _find_bad_line(table: CsvTable) -> InputError | None:
    """The error of the first line that is no row of numbers; None without."""
    where, names = table.where, table.names
    with _open_text(table.path) as text:
        text.readline()
        for number, line in enumerate(_select_lines(text, table.separator), 2):
            cells = line.strip().split(table.separator)
            if cells == [""]:
                continue
            if len(cells) != len(names):
                reason = f"has {len(cells)} columns, must have {len(names)}, as line 1"
                return InputError(where, f"line {number}", None, reason)
            for name, cell in zip(names, cells, strict=True):
                try:
                    float(cell)
                except ValueError:
                    field = f"line {number}, {name}"
                    return InputError(where, field, cell[:40], "must be a number")
    return None

"""Tables of numbers in CSV files, read line by line: a line of names, then rows of numbers."""

from __future__ import annotations

import io
import re
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from crosscheck.models.errors import InputError
from crosscheck.models.inputs import open_input

LARGEST_FILE = 2_000_000_000  # bytes


@dataclass(frozen=True)
class CsvTable:
    """A table of numbers (rows, columns) with names, from a file."""

    where: str
    names: tuple[str, ...]
    values: np.ndarray

    def select(self, columns: Sequence[str]) -> np.ndarray:
        """Columns of these names (rows, columns), of no number where the name is empty.

        Raises InputError for one that is not there.
        """
        for name in filter(None, columns):
            if self.names.count(name) != 1:
                there = ", ".join(self.names)[:300]
                count = "is there twice" if name in self.names else f"is no column; it has {there}"
                raise InputError(self.where, name, None, count)
        measured = [place for place, name in enumerate(columns) if name]
        chosen = np.full((len(self.values), len(columns)), np.nan)
        chosen[:, measured] = self.values[:, [self.names.index(columns[at]) for at in measured]]
        wrong = np.argwhere(~np.isfinite(chosen) & (np.array(columns) != ""))
        if wrong.size:
            row, column = map(int, wrong[0])
            name = columns[column]
            if not np.isfinite(chosen[:, column]).any():
                raise InputError(self.where, name, None, "is no number in any row: not measured?")
            raise InputError(self.where, f"{name}, row {row + 1}", None, "must be a number")
        return chosen


def read_table(path: Path) -> CsvTable:
    """The table in a CSV file: a line of names, commas, semicolons or tabs between columns.

    Where no commas separate, one may stand before decimals. Raises InputError.
    """
    where = str(path)
    with _open_text(path) as text:
        head = text.readline()
        separator = next((each for each in (";", "\t", ",") if each in head), ",")
        names = tuple(name.strip().strip('"') for name in head.split(separator))
        if all(re.fullmatch(r"[-+.,\deE]+", name) for name in names):
            raise InputError(where, "line 1", None, "holds numbers; must hold the columns' names")
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # of a table without rows
                lines = _select_lines(text, separator)
                values = np.loadtxt(lines, delimiter=separator, ndmin=2, comments=None)
        except UnicodeDecodeError:
            raise
        except ValueError as error:
            raise _find_bad_line(path, names, separator) or InputError(
                where, "", None, str(error)
            ) from None
    if not values.size:
        raise InputError(where, "", None, "has no rows below the names of its columns")
    if values.shape[1] != len(names):
        reason = f"names {len(names)} columns, the rows have {values.shape[1]}"
        raise InputError(where, "line 1", None, reason)
    return CsvTable(where, names, values)


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


def _find_bad_line(path: Path, names: Sequence[str], separator: str) -> InputError | None:
    """The error of the first line that is no row of numbers; None without."""
    where = str(path)
    with _open_text(path) as text:
        text.readline()
        for number, line in enumerate(_select_lines(text, separator), 2):
            cells = line.strip().split(separator)
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

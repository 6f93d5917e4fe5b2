"""Rows of numbers below a line of names, and the line of a file that is none."""

from __future__ import annotations

import io
import warnings
from collections.abc import Sequence

import numpy as np

from crosscheck.models.errors import InputError


def decode_csv(where: str, content: bytes) -> tuple[str, str]:
    """The line of names, and the text below it. Raises InputError."""
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise InputError(where, "", None, "is not UTF-8 text; a CSV file is expected") from None
    head, _, rest = text.partition("\n")
    return head, rest


def parse_rows(where: str, names: Sequence[str], text: str, separator: str) -> np.ndarray:
    """Numbers (rows, columns) of the text below the line of names. Raises InputError."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of a table without rows
            table = np.loadtxt(io.StringIO(text), delimiter=separator, ndmin=2, comments=None)
    except ValueError as error:
        raise _find_bad_line(where, names, text, separator) or InputError(
            where, "", None, str(error)
        ) from None
    if table.size and table.shape[1] != len(names):
        reason = f"names {len(names)} columns, the rows have {table.shape[1]}"
        raise InputError(where, "line 1", None, reason)
    return table


def _find_bad_line(
    where: str, names: Sequence[str], text: str, separator: str
) -> InputError | None:
    """The error of the first line that is no row of numbers; None without."""
    for number, line in enumerate(io.StringIO(text), 2):
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
                return InputError(where, f"line {number}, {name}", cell[:40], "must be a number")
    return None

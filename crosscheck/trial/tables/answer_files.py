"""Files of answers, opened here and nowhere else: CSV, MAT v5 and v7.3; every number is checked."""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from crosscheck.models.errors import InputError
from crosscheck.models.inputs import read_input
from crosscheck.runner.isolated_reading import (
    MOST_NUMBERS,
    TooManyNumbers,
    read_arrays,
    read_in_subprocess,
)
from crosscheck.trial.input.arrays import is_single_precision
from crosscheck.trial.input.calls import MATRICES
from crosscheck.trial.input.equations import SINGLE
from crosscheck.trial.tables.state_requests import (
    ARGUMENTS,
    LETTERS,
    ROW,
    SHORT,
    answer_columns,
    flag_column,
)

LARGEST_FILE = 500_000_000  # bytes
READING_S = 60.0
FEW = 20  # different numbers, that show nothing of how many digits a file has
SAMPLE = 2000
MOST_DIGITS, SINGLE_DIGITS = 15, 7


@dataclass(frozen=True)
class TableColumns:
    """Allowed contents of a file of answers for n coordinates.

    parts: that may be answered; arguments: columns that may stand beside, by argument;
    least_digits: significant ones that answers must have.
    """

    n: int
    parts: Sequence[str]
    arguments: Mapping[str, Sequence[str]]
    least_digits: int


@dataclass(frozen=True)
class AnswerFile:
    """The answers in a file.

    rows (rows,): their numbers, counted from 1; answers: by part (rows, entries), NaN where there
    is none; state_columns: other columns (rows,) by name, as the states have them; precision:
    relative rounding of the answers, 0 for that of double precision.
    """

    where: str
    rows: np.ndarray
    answers: Mapping[str, np.ndarray]
    state_columns: Mapping[str, np.ndarray]
    precision: float


def read_answers(path: Path, allowed: TableColumns) -> AnswerFile:
    """The answers in a file.

    Raises InputError naming file, row and column.
    """
    where = str(path)
    content = read_input(path, LARGEST_FILE)
    read = _read_mat if path.suffix == ".mat" else _read_csv
    columns, parts = read(where, content, allowed), allowed.parts
    rows, answers = columns.pop(ROW), {part: columns.pop(part) for part in parts if part in columns}
    if not answers:
        names = "; ".join(answer_columns(part, allowed.n)[0] + ", ..." for part in parts)
        raise InputError(where, "", None, f"has no answers; columns may be {names}")
    # That of the part whose numbers have the fewest digits.
    precision = max(_precision(where, values, allowed.least_digits) for values in answers.values())
    return AnswerFile(where, _row_numbers(where, rows), answers, columns, precision)


def _row_numbers(where: str, rows: np.ndarray) -> np.ndarray:
    numbers = np.asarray(rows, dtype=float).ravel()
    wrong = np.flatnonzero(~((numbers >= 1) & (numbers == np.round(numbers)) & (numbers < 2**53)))
    if wrong.size:
        value = float(numbers[wrong[0]])
        raise InputError(where, f"{ROW} (number {wrong[0] + 1})", value, "must be a row's number")
    whole = numbers.astype(np.int64)
    unlike, counts = np.unique(whole, return_counts=True)
    if (counts > 1).any():
        raise InputError(where, ROW, int(unlike[counts > 1][0]), "is there twice")
    return whole


def _precision(where: str, values: np.ndarray, least_digits: int) -> float:
    """Relative rounding of numbers; 0 for double's. Raises InputError for too few digits."""
    unlike = np.unique(values[np.isfinite(values)])
    if unlike.size < FEW:
        return 0.0
    if is_single_precision(unlike):
        if least_digits > SINGLE_DIGITS:
            reason = f"answers are of single precision; {least_digits} digits are needed"
            raise InputError(where, "", None, reason)
        return SINGLE
    sample = unlike[:: max(unlike.size // SAMPLE, 1)].tolist()
    digits = 1
    while digits <= MOST_DIGITS and any(float(f"{x:.{digits - 1}e}") != x for x in sample):
        digits += 1
    if digits < least_digits:
        reason = (
            f"answers have {digits} significant digits; must be at least {least_digits}, better 17"
        )
        raise InputError(where, "", None, reason)
    return 0.0 if digits > MOST_DIGITS else 0.5 * 10.0 ** (1 - digits)


def _read_csv(where: str, content: bytes, allowed: TableColumns) -> dict[str, np.ndarray]:
    """Columns of a CSV file by name; those of a part's answers together, (rows, entries)."""
    try:
        lines = csv.reader(io.StringIO(content.decode("utf-8-sig"), newline=""), strict=True)
        header = [name.strip() for name in next(lines, [])]
        _require_header(where, header, allowed)
        table = [_parse_numbers(where, header, line, lines.line_num) for line in lines if line]
    except UnicodeDecodeError:
        raise InputError(where, "", None, "is not UTF-8 text; a CSV file is expected") from None
    except csv.Error as error:
        raise InputError(where, "", None, f"is not a CSV file: {error}") from None
    if not table:
        raise InputError(where, "", None, "has no rows")
    columns = dict(zip(header, np.array(table).T, strict=True))
    for part in allowed.parts:
        names = answer_columns(part, allowed.n)
        there = [name for name in names if name in columns]
        if 0 < len(there) < len(names):
            missing = next(name for name in names if name not in columns)
            raise InputError(where, missing, None, f"is missing; {there[0]} is there")
        if there:
            columns[part] = np.stack([columns.pop(name) for name in names], axis=1)
    return columns


def _require_header(where: str, header: Sequence[str], allowed: TableColumns) -> None:
    """Raise InputError unless the first line names columns, each known, each once."""
    answers = [name for part in allowed.parts for name in answer_columns(part, allowed.n)]
    if header[:1] and header[0].startswith(ROW) and set(";\t") & set("".join(header)):
        raise InputError(where, "line 1", None, "columns must be separated by commas")
    if ROW not in header:
        reason = f"must name the columns: {ROW}, {answers[0]}, ..."
        raise InputError(where, "line 1", ",".join(header)[:40], reason)
    if len(header) > 1 and all(_is_number(name) for name in header if name != ROW):
        reason = "are numbers: the table is transposed; must be a state a row"
        raise InputError(where, f"line 1: what follows {ROW}", None, reason)
    allowed_columns = {
        ROW,
        *answers,
        *map(flag_column, allowed.parts),
        *(name for names in allowed.arguments.values() for name in names),
    }
    for place, name in enumerate(header):
        if name not in allowed_columns:
            usual = ", ".join([ROW, answers[0], "..."])
            raise InputError(where, "line 1", name, f"unknown column; allowed: {usual}")
        if name in header[:place]:
            raise InputError(where, "line 1", name, "is there twice")


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _parse_numbers(
    where: str, header: Sequence[str], line: Sequence[str], number: int
) -> list[float]:
    """The numbers of a line of a CSV file; NaN for an empty cell. Raises InputError."""
    if len(line) != len(header):
        reason = f"has {len(line)} columns, must have {len(header)}, as line 1"
        raise InputError(where, f"line {number}", None, reason)
    try:
        numbers = [float(text) if text.strip() else np.nan for text in line]
    except ValueError:
        name, text = next(
            pair
            for pair in zip(header, line, strict=True)
            if pair[1].strip() and not _is_number(pair[1])
        )
        raise InputError(where, f"line {number}, {name}", text, "must be a number") from None
    if not np.isfinite(numbers[header.index(ROW)]):
        raise InputError(where, f"line {number}, {ROW}", None, "must be a row's number")
    return numbers


def _read_mat(where: str, content: bytes, allowed: TableColumns) -> dict[str, np.ndarray]:
    read = read_in_subprocess(
        where, _mat_variables, where, content, within_s=READING_S, fails="is not a MAT file"
    )
    if ROW not in read:
        raise InputError(where, ROW, None, "is missing: the numbers of the rows that are answered")
    rows = read[ROW].ravel()
    columns = {ROW: rows}
    for part in allowed.parts:
        name = SHORT[part]
        if name in read:
            height = allowed.n if part in MATRICES else 1
            columns[part] = _reshape_by_row(where, name, read[name], len(rows), height, allowed.n)
    for argument, names in allowed.arguments.items():
        letter = LETTERS.get(argument, argument)
        if letter in read:
            beside = _reshape_by_row(where, letter, read[letter], len(rows), 1, len(names))
            columns |= dict(zip(names, beside.T, strict=True))
    return columns


def _mat_variables(where: str, content: bytes) -> dict[str, np.ndarray]:
    """Those variables of a MAT file, v5 or v7.3, that answers may have. Raises InputError."""
    names = {ROW, *SHORT.values(), *(LETTERS.get(each, each) for each in ARGUMENTS)}
    try:
        return read_arrays(content, names.intersection, as_matlab=True)
    except TooManyNumbers:
        reason = f"holds more than {MOST_NUMBERS} numbers"
        raise InputError(where, "", None, reason) from None
    except Exception as error:
        reason = f"is not a MAT file: {type(error).__name__}: {error}"
        raise InputError(where, "", None, reason) from None


def _reshape_by_row(
    where: str, name: str, values: Any, count: int, height: int, width: int
) -> np.ndarray:
    """A variable as (rows, height x width).

    One of matrices may also come as (rows, n, n) or (n, n, rows). Raises InputError.
    """
    if not isinstance(values, np.ndarray) or values.dtype.kind not in "biuf":
        raise InputError(where, name, None, "must be an array of real numbers")
    entries, shape = height * width, values.shape
    numbers = values.astype(np.float64)
    if shape in ((count, entries), (count, height, width)) or (
        entries == 1 and values.size == count
    ):
        return numbers.reshape(count, entries)
    if shape == (height, width, count):
        return numbers.transpose(2, 0, 1).reshape(count, entries)
    transposed = "transposed; " if shape == (entries, count) else ""
    reason = (
        f"is {' x '.join(map(str, shape))}: {transposed}must be {count} x {entries}, a state a row"
    )
    raise InputError(where, name, None, reason)

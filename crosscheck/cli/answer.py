"""What a command leaves: the files that were asked for, and its lines in the terminal."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path

from crosscheck.output import write_files
from crosscheck.report.words import printable

Asked = tuple[Path | None, Callable[[], str]]  # a file, None where none is; what makes its text


def write_asked(*asked: Asked) -> list[str]:
    """Write the files that were asked for; returns lines that name them. Raises InputError."""
    files: dict[Path, str | bytes] = {path: text() for path, text in asked if path is not None}
    write_files(files)
    return [f"wrote {printable(str(path))}" for path in files]


def answer(lines: Iterable[str], *asked: Asked) -> None:
    """Write the files, print the lines and name what was written. Raises InputError."""
    named = write_asked(*asked)
    for line in (*map(printable, lines), *named):
        print(line)

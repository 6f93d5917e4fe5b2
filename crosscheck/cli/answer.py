"""What a command leaves: the files that were asked for, and its lines in the terminal."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path

from crosscheck.output import write_files
from crosscheck.report.words import printable


def answer(lines: Iterable[str], *asked: tuple[Path | None, Callable[[], str]]) -> None:
    """Write the files, print the lines and name what was written. Raises InputError.

    asked: each file, None where it was not asked for, with what makes its text.
    """
    files: dict[Path, str | bytes] = {path: text() for path, text in asked if path is not None}
    write_files(files)
    for line in lines:
        print(printable(line))
    for path in files:
        print(f"wrote {printable(str(path))}")

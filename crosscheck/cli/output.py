"""Output of a command: the requested files, and its lines in the terminal."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path

from crosscheck.models.errors import make_printable
from crosscheck.output import write_files

# A path, None for no file, and the function that makes its text.
FileRequest = tuple[Path | None, Callable[[], str]]


def write_requested(*requests: FileRequest) -> list[str]:
    """Write the files that were asked for; returns lines that name them. Raises InputError."""
    files: dict[Path, str | bytes] = {path: text() for path, text in requests if path is not None}
    write_files(files)
    return [f"wrote {make_printable(str(path))}" for path in files]


def print_and_write(lines: Iterable[str], *requests: FileRequest) -> None:
    """Write the files, print the lines and the names of the files. Raises InputError."""
    named = write_requested(*requests)
    for line in (*map(make_printable, lines), *named):
        print(line)

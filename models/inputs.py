"""Files that a user names: opened in one place, which remembers what is read."""

from __future__ import annotations

import logging
import os
import stat
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from math import pi
from pathlib import Path
from typing import BinaryIO

from crosscheck.models.errors import InputError, make_printable

_inputs: set[str] = set()
_doubted: set[tuple[str, str]] = set()  # files and fields


def read_content(path: Path, largest: int, remembered: bool = True) -> bytes:
    """Content of a file; links are followed, and nothing is waited for.

    remembered: whether it is an input, which nothing may be written onto. Raises OSError, and
    ValueError for what is no file, or larger than so many bytes.
    """
    with _open(path) as file:
        content = file.read(largest + 1)
    if len(content) > largest:
        raise ValueError(f"more than {largest // 1_000_000} MB")
    if remembered:
        remember(path)
    return content


def read_input(path: Path, largest: int) -> bytes:
    """Content of an input of at most so many bytes. Raises InputError for what cannot be read."""
    with convert_read_errors(str(path)):
        return read_content(path, largest)


@contextmanager
def convert_read_errors(name: str) -> Iterator[None]:
    """Raise InputError of a file's name where it cannot be opened, read or decoded."""
    try:
        yield
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else error
        reason = "not UTF-8 text" if isinstance(error, UnicodeDecodeError) else reason
        raise InputError(name, "", None, f"cannot be read: {reason}") from None


@contextmanager
def open_input(path: Path, largest: int) -> Iterator[BinaryIO]:
    """An input of at most so many bytes, to be read piece by piece.

    Raises InputError for what cannot be opened.
    """
    with convert_read_errors(str(path)):
        file = _open(path)
    with file:
        if os.fstat(file.fileno()).st_size > largest:
            reason = f"cannot be read: more than {largest // 1_000_000} MB"
            raise InputError(str(path), "", None, reason)
        remember(path)
        yield file


def input_size(path: Path) -> int:
    """Size [bytes] of a file that another process is going to read, remembered as an input.

    Raises OSError, and ValueError for what is no file.
    """
    with _open(path) as file:
        remember(path)
        return os.fstat(file.fileno()).st_size


def _open(path: Path) -> BinaryIO:
    # A pipe without a writer would be waited for, and a device may never end.
    handle = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)
    mode = os.fstat(handle).st_mode
    if stat.S_ISREG(mode):
        return os.fdopen(handle, "rb")
    os.close(handle)
    raise ValueError("it is a folder" if stat.S_ISDIR(mode) else "not a regular file")


def remember(path: Path) -> None:
    """Remember a file as an input, which nothing may be written onto."""
    _inputs.add(os.path.abspath(path))


def forget() -> None:
    """Forget all inputs: another command begins."""
    _inputs.clear()
    _doubted.clear()


def is_input(path: Path) -> bool:
    """Whether a file is one of the inputs, by any of its names."""
    for input_path in _inputs:
        with suppress(OSError, ValueError):
            if os.path.samefile(path, input_path):
                return True
    return False


def doubt_degrees(where: str, field: str, angles: Iterable[float], remedy: str = "") -> None:
    """Ask in one line, once for a field, whether an angle [rad] of more than a turn is in degrees.

    where: the file; remedy: what to write then, where it can be said.
    """
    largest = max(angles, key=abs, default=0.0)
    turns = abs(largest) / (2 * pi)
    if turns > 1 + 1e-6 and (where, field) not in _doubted:  # rounded 2 pi is one turn
        _doubted.add((where, field))
        said = f"note: {where}: {field}: {largest:.6g} rad = {turns:.3g} turns: is it in degrees?"
        logging.warning(make_printable(f"{said} Then {remedy}" if remedy else said))

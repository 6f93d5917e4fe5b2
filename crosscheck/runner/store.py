"""Results kept between runs: every entry states whose it is, and shows if it was damaged."""

from __future__ import annotations

import re
import secrets
import sys
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TypeVar

from crosscheck.models.directories import make_private, read_sealed, report_unfit, seal
from crosscheck.models.errors import PROGRAM, InputError, format_line
from crosscheck.output import convert_os_errors, draft, remove_abandoned

Value = TypeVar("Value")
LARGEST = 2**40  # size of an entry [bytes]
SUFFIX = ".kept"
# The other two suffixes: of entries that carry no checksum.
ENTRY = re.compile(r"[0-9a-f]{32}\.(kept|json|nc)")


class Store:
    """Contents kept by key, in a folder that is private to the user.

    A folder that cannot be used costs the keeping, not the work, and one line on standard error.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.usable = True
        try:
            make_private(folder)
            remove_abandoned(folder)
        except OSError as error:
            self.give_up(error)

    def give_up(self, error: OSError) -> None:
        """Keep nothing more, and say why."""
        reason = f"cannot be written: {error.strerror}; simulations are not kept"
        print(format_line(f"{PROGRAM}{self.folder}: {reason}"), file=sys.stderr)
        self.usable = False

    def get(self, key: str, decode: Callable[[bytes], Value]) -> Value:
        """The decoded content kept under a key. Raises KeyError unless there is a sound one.

        What is not sound costs one line on standard error.
        """
        content = read_sealed(self._path(key), LARGEST) if self.usable else None
        if content is not None:
            try:
                return decode(content)
            except Exception as error:
                report_unfit(self._path(key), str(error))
        raise KeyError(key)

    def put(self, key: str, content: bytes) -> None:
        """Keep a content under a key, in place of what is there. Raises OSError."""
        if not self.usable:
            return
        path = self._path(key)
        with draft(self.folder, 0o600) as new:
            new.write(seal(path, content))
            if path.is_dir() and not path.is_symlink():  # nobody's entry: it is left to its owner
                path.rename(f"{path}.set-aside-{secrets.token_hex(4)}")
            new.publish(path)

    def remove(self, keys: Iterable[str]) -> None:
        """Remove what is kept under these keys, if anything. Raises InputError."""
        with convert_os_errors(self.folder):
            for key in keys:
                self._path(key).unlink(missing_ok=True)

    def _path(self, key: str) -> Path:
        return self.folder / f"{key}{SUFFIX}"


def clear(folder: Path) -> int:
    """Remove all entries, and the folder if nothing else is in it; returns how many there were.

    Raises InputError.
    """
    try:
        paths = find_entries(folder)
        for path in paths:
            path.unlink(missing_ok=True)
        remove_abandoned(folder)
        if folder.is_dir() and not any(folder.iterdir()):
            folder.rmdir()
    except OSError as error:
        raise InputError(str(folder), "", None, f"cannot be cleared: {error.strerror}") from None
    return len(paths)


def find_entries(folder: Path) -> list[Path]:
    """Paths of all entries in a folder, sorted. Raises OSError."""
    paths = [path for path in folder.glob("*") if ENTRY.fullmatch(path.name)]
    return sorted(path for path in paths if not path.is_dir())

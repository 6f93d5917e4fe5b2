"""Folders of the program's own, private to the user, and the files in them that are executed."""

from __future__ import annotations

import atexit
import errno
import hashlib
import os
import shutil
import stat
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from functools import lru_cache
from pathlib import Path

from platformdirs import user_cache_path

from crosscheck.models.errors import PROGRAM, format_line

NAME = "geararm-crosscheck"
OTHERS_READ, OTHERS_WRITE = 0o077, 0o022  # permissions of group and others
CHECKSUM = 32  # length of the SHA-256 at the begin of a kept file [bytes]


class PrivacyError(PermissionError):
    """An error for a file or folder that is not the user's alone."""

    def __init__(self, path: Path, reason: str) -> None:
        super().__init__(errno.EPERM, reason, str(path))


def cache_folder() -> Path:
    """The program's folder in the user's cache folder; it need not exist."""
    try:
        return user_cache_path(NAME, appauthor=False)
    except RuntimeError:  # there is no home
        return Path("/nonexistent", NAME)


def is_usable(folder: Path) -> bool:
    """Whether files can be made there, as far as permissions tell; it need not exist."""
    while not os.path.lexists(folder) and folder != folder.parent:
        folder = folder.parent
    return folder.is_dir() and os.access(folder, os.W_OK | os.X_OK)


def make_private(folder: Path) -> bool:
    """Make the folder if need be, and keep others out; returns whether others could write in it.

    Raises OSError unless it can be written, and PrivacyError for a link or another user's folder.
    """
    folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    with _open_private(folder, os.O_DIRECTORY) as handle:
        mode = os.fstat(handle).st_mode
        if mode & OTHERS_READ:
            os.fchmod(handle, 0o700)
    with tempfile.TemporaryFile(dir=folder):
        pass
    return bool(mode & OTHERS_WRITE)


@lru_cache
def prepare_cache_folder() -> Path:
    """The cache folder, or one for this process alone where that cannot be used.

    Raises OSError where not even a temporary one can be made.
    """
    folder = cache_folder()
    return folder if _is_private(folder) else make_temporary_folder()


@lru_cache
def prepare_code_folder(kind: str) -> Path:
    """The folder in which compiled code of a kind is kept, in the cache folder if possible.

    What lies in a folder that others could write is removed. Raises OSError.
    """
    folder = prepare_cache_folder() / kind
    if not _is_private(folder, clear=True):
        folder = make_temporary_folder() / kind
        make_private(folder)
    return folder


def _is_private(folder: Path, clear: bool = False) -> bool:
    """Whether a folder is private, made if need be; a refused one is reported on stderr.

    clear: whether what is in a folder is removed where others could write it.
    """
    try:
        if make_private(folder) and clear:
            shutil.rmtree(folder)
            make_private(folder)
    except PrivacyError as error:
        print(format_line(f"{PROGRAM}{folder}: {error.strerror}; nothing is kept"), file=sys.stderr)
        return False
    except OSError:
        return False
    return True


def read_private(path: Path, largest: int) -> bytes:
    """Content of a file that is going to be executed, of at most so many bytes.

    Raises OSError, ValueError for a larger one, and PrivacyError unless it is a regular file, no
    link, and file and folder are the user's own, which nobody else may write.
    """
    with require_private(path) as handle, open(handle, "rb", closefd=False) as file:
        if os.fstat(handle).st_size > largest:
            raise ValueError(f"more than {largest // 1_000_000} MB")
        return file.read()


def seal(path: Path, data: bytes) -> bytes:
    """Content to be kept under the name of a path, behind a checksum of both."""
    return hashlib.sha256(path.name.encode() + data).digest() + data


def read_sealed(path: Path, largest: int) -> bytes | None:
    """The content of a kept file; None if it is missing or, with a line on stderr, damaged.

    Half a file, a changed one and one of another name are not.
    """
    reason = "damaged"
    try:
        whole = read_private(path, largest)
        data = whole[CHECKSUM:]
        if seal(path, data) == whole:
            return data
    except FileNotFoundError:
        return None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
    report_unfit(path, reason)
    return None


def report_unfit(path: Path, reason: str) -> None:
    """Say on stderr that what a kept file holds cannot be used."""
    line = format_line(f"{PROGRAM}{path}: does not fit: {reason}; it is made again")
    print(line, file=sys.stderr)


@contextmanager
def require_private(path: Path) -> Iterator[int]:
    """A descriptor of a file that is going to be executed; raises what `read_private` raises."""
    with (
        _open_private(path.parent, os.O_DIRECTORY) as folder,
        _open_private(path, os.O_NONBLOCK, folder) as handle,
    ):
        for place, each in ((path.parent, folder), (path, handle)):
            if os.fstat(each).st_mode & OTHERS_WRITE:
                raise PrivacyError(place, "may be written by others")
        if not stat.S_ISREG(os.fstat(handle).st_mode):
            raise PrivacyError(path, "is not a regular file")
        yield handle


@contextmanager
def _open_private(path: Path, flags: int, folder: int | None = None) -> Iterator[int]:
    """A descriptor of what is at a path.

    Raises PrivacyError for a link or what is another user's.
    """
    flags |= os.O_RDONLY | os.O_NOFOLLOW | os.O_CLOEXEC
    try:
        handle = os.open(path if folder is None else path.name, flags, dir_fd=folder)
    except OSError:
        if path.is_symlink():
            raise PrivacyError(path, "is a link") from None
        raise
    try:
        if os.fstat(handle).st_uid != os.geteuid():
            raise PrivacyError(path, "belongs to another user")
        yield handle
    finally:
        os.close(handle)


@lru_cache
def make_temporary_folder() -> Path:
    """A folder for this process alone, gone with it. Raises OSError where none can be made."""
    try:
        folder = Path(tempfile.mkdtemp(prefix=f"{NAME}-"))
    except OSError:  # a read-only system may still have shared memory
        folder = Path(tempfile.mkdtemp(prefix=f"{NAME}-", dir="/dev/shm"))
    atexit.register(_remove, folder, os.getpid())
    return folder


def _remove(folder: Path, maker: int) -> None:
    if os.getpid() == maker:
        shutil.rmtree(folder, ignore_errors=True)

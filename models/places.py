"""Folders of the program's own: private to the user, and always somewhere."""

from __future__ import annotations

import atexit
import errno
import os
import shutil
import tempfile
from functools import lru_cache
from pathlib import Path

NAME = "geararm-crosscheck"


def cache_folder() -> Path:
    """The program's folder in the user's cache folder; it need not exist."""
    base = Path(os.environ.get("XDG_CACHE_HOME", ""))
    return (base if base.is_absolute() else home_folder() / ".cache") / NAME


def home_folder() -> Path:
    """The user's home folder; it need not exist."""
    try:
        return Path.home()
    except RuntimeError:  # as systems call the home of those who have none
        return Path("/nonexistent")


def usable(folder: Path) -> bool:
    """Whether files can be made there, as far as permissions tell; it need not exist."""
    while not os.path.lexists(folder) and folder != folder.parent:
        folder = folder.parent
    return folder.is_dir() and os.access(folder, os.W_OK | os.X_OK)


def make_private(folder: Path) -> None:
    """Make the folder if need be, and keep others out. Raises OSError unless it can be written."""
    folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    state = folder.stat()
    if state.st_uid != os.geteuid():
        raise PermissionError(errno.EPERM, "belongs to another user", str(folder))
    if state.st_mode & 0o077:
        folder.chmod(0o700)
    with tempfile.TemporaryFile(dir=folder):
        pass


@lru_cache
def own_folder() -> Path:
    """The cache folder, or one for this process alone where that cannot be used.

    Raises OSError where not even a temporary one can be made.
    """
    try:
        folder = cache_folder()
        make_private(folder)
    except OSError:
        folder = temporary_folder()
    return folder


@lru_cache
def temporary_folder() -> Path:
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

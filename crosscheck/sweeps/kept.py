"""Batches kept beside a result while it is made, so that nothing is run twice."""

from __future__ import annotations

import fcntl
import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from crosscheck.studies.store import Store, clear
from crosscheck.sweeps.batch import Numbers
from crosscheck.sweeps.batches import packed, unpacked
from crosscheck.sweeps.members import Study
from crosscheck.sweeps.result_file import STUDY, VERSION, identity_of
from models.errors import InputError

MARK = "study"  # in a folder of batches, says whose they are
SPARE = 1.1  # of the disk space that is counted on


class Kept:
    """Numbers of batches by key."""

    def __init__(self, folder: Path) -> None:
        self.store = Store(folder)

    def __contains__(self, key: str) -> bool:
        return (self.store.folder / f"{key}.kept").is_file()

    def get(self, key: str) -> Numbers | None:
        """None where nothing sound is kept."""
        try:
            return self.store.get(key, unpacked)
        except KeyError:
            return None

    def put(self, key: str, numbers: Numbers) -> None:
        """Raises OSError."""
        self.store.put(key, packed(numbers))


def folder_of(out: Path) -> Path:
    """Of a result's batches."""
    return out.with_name(f"{out.name}.batches")


def require_room(out: Path, needed: int, members: int) -> None:
    """Raise InputError unless the disk holds a result and its batches."""
    free = shutil.disk_usage(out.parent).free
    wanted = int(2 * SPARE * needed)  # the file, and the batches meanwhile
    if wanted > free:
        allowed = (
            f"{members:,} members need {wanted / 1e9:,.1f} GB while they run,"
            f" {free / 1e9:,.1f} GB are free"
        )
        raise InputError(str(out), "", None, allowed)


def is_complete(out: Path, study: Study, version: str, resume: bool) -> bool:
    """Whether the result is there already. Raises InputError where it may not be made."""
    if not out.exists():
        return False
    theirs, made_by = identity_of(out) if resume else ("", "")
    if not resume:
        raise InputError(str(out), "", None, "exists already; name another file, or remove it")
    if theirs != study.digest:
        raise InputError(str(out), STUDY, theirs[:12], "is the result of another study")
    if made_by != version:
        allowed = "was made by another version; name another file, or remove it"
        raise InputError(str(out), VERSION, None, allowed)
    return True


@contextmanager
def batches_of(out: Path, study: Study, resume: bool) -> Iterator[Kept]:
    """The batches that are kept for a result; gone once all went well.

    Raises InputError where those of another study are, or of this one without ``resume``, or where
    another process is at it.
    """
    folder = folder_of(out)
    mark = folder / MARK
    if folder.exists() and not folder.is_dir():
        raise InputError(str(folder), "", None, "is a file; a folder is expected")
    if mark.exists():
        if mark.read_text(encoding="utf-8", errors="replace") not in ("", study.digest):
            raise InputError(str(folder), "", None, "holds batches of another study")
        if not resume:
            allowed = "holds batches of this study; --resume goes on, or remove the folder"
            raise InputError(str(folder), "", None, allowed)
    elif folder.exists() and any(folder.iterdir()):
        raise InputError(str(folder), "", None, "is not empty, and holds no batches")
    kept = Kept(folder)
    if not kept.store.usable:
        raise InputError(str(folder), "", None, "cannot be written")
    handle = os.open(mark, os.O_RDWR | os.O_CREAT, 0o600)
    try:
        _alone(handle, folder)
        os.pwrite(handle, study.digest.encode(), 0)
        yield kept
        clear(folder)
    finally:
        if not any(folder.glob("*.kept")):  # all is done, or nothing was begun
            mark.unlink(missing_ok=True)
            clear(folder)
        os.close(handle)


def _alone(handle: int, folder: Path) -> None:
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        raise InputError(str(folder), "", None, "is in use by another process") from None
    except OSError:  # not every network file system has locks
        pass

"""Batches kept beside a result while it is made, so that nothing is run twice."""

from __future__ import annotations

import fcntl
import os
import re
import shutil
import stat
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

from crosscheck.models.directories import make_private
from crosscheck.models.errors import InputError
from crosscheck.output import convert_os_errors, find_existing_folder
from crosscheck.runner.store import Store
from crosscheck.studies.batches.batch import Numbers
from crosscheck.studies.batches.batches import pack_numbers, unpack_numbers
from crosscheck.studies.batches.netcdf_file import StudyResultFile, use_file
from crosscheck.studies.batches.result_file import STUDY, VERSION
from crosscheck.studies.measures.columns import Column
from crosscheck.studies.members.members import PreparedStudy

MARK = "study"  # file name that records which study a batch folder belongs to
MARK_BYTES = 100_000_000
FLAGS = os.O_RDWR | os.O_CREAT | os.O_APPEND | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC
SPARE = 1.1  # factor on the estimated disk space


class BatchStore:
    """Numbers of batches by key, in a folder whose mark lists its content.

    keys: those that are listed; mark: descriptor of the list.
    """

    def __init__(self, folder: Path, columns: Sequence[Column], mark: int, keys: set[str]) -> None:
        self.store = Store(folder)
        self.columns, self.mark, self.keys = columns, mark, keys

    def get(self, key: str, members: int) -> Numbers | None:
        """The numbers of a batch of so many members; None where nothing sound is kept."""
        if key not in self.keys:
            return None
        try:
            return self.store.get(key, lambda c: unpack_numbers(c, self.columns, members))
        except KeyError:
            return None

    def put(self, key: str, numbers: Numbers) -> None:
        """Keep the numbers of a batch under its key. Raises OSError."""
        if key not in self.keys:
            os.write(self.mark, f"{key}\n".encode())
            self.keys.add(key)
        self.store.put(key, pack_numbers(numbers, self.columns))

    def clear(self) -> None:
        """Remove all batches that the mark lists. Raises InputError."""
        self.store.remove(self.keys)
        self.keys.clear()


def batch_folder(out: Path) -> Path:
    """The folder of a result's batches."""
    return out.with_name(f"{out.name}.batches")


def require_room(out: Path, needed: int, members: int) -> None:
    """Raise InputError unless the disk holds a result and its batches."""
    free = shutil.disk_usage(find_existing_folder(out.parent)).free
    needed_bytes = int(2 * SPARE * needed)  # the file, and the batches meanwhile
    if needed_bytes > free:
        need = f"{members:,} members need {needed_bytes / 1e9:,.1f} GB while they run"
        raise InputError(str(out), "", None, f"{need}, {free / 1e9:,.1f} GB are free")


def is_complete(out: Path, study: PreparedStudy, version: str, resume: bool) -> bool:
    """Whether a study's result is there already. Raises InputError where it may not be made."""
    if not out.exists():
        return False
    if not resume:
        raise InputError(str(out), "", None, "exists already; name another file, or remove it")
    study_digest, made_by = use_file(out, StudyResultFile.identity)
    if study_digest != study.digest:
        raise InputError(str(out), STUDY, study_digest[:12], "is the result of another study")
    if made_by != version:
        allowed = "was made by another version; name another file, or remove it"
        raise InputError(str(out), VERSION, None, allowed)
    return True


@contextmanager
def open_batches(
    out: Path, study: PreparedStudy, columns: Sequence[Column], resume: bool
) -> Iterator[BatchStore]:
    """The batches that are kept for a result, removed once all went well.

    Nothing is touched that the folder's own mark does not list, and no link is followed. Raises
    InputError where the folder has another study's batches, or this one's without ``resume``, or
    where another process is at it.
    """
    folder = batch_folder(out)
    with convert_os_errors(folder):
        if os.path.lexists(folder) and (folder.is_symlink() or not folder.is_dir()):
            raise InputError(str(folder), "", None, "is not a folder; remove it")
        make_private(folder)
        if not os.path.lexists(folder / MARK) and any(folder.iterdir()):
            raise InputError(str(folder), "", None, "is not empty, and holds no batches")
        if os.path.lexists(folder / MARK) and not stat.S_ISREG((folder / MARK).lstat().st_mode):
            raise InputError(str(folder / MARK), "", None, "is not an ordinary file; remove it")
        mark = os.open(folder / MARK, FLAGS, 0o600)
    try:
        _lock_list(mark, folder)
        keys = _read_keys(mark, folder, study)
        if keys is not None and not resume:
            allowed = "holds batches of this study; --resume goes on, or remove the folder"
            raise InputError(str(folder), "", None, allowed)
        store = BatchStore(folder, columns, mark, keys or set())
        if keys is None:
            os.write(mark, f"{study.digest}\n".encode())
        try:
            yield store
            store.clear()
        finally:
            if not store.keys:  # all is done, or nothing was begun
                (folder / MARK).unlink(missing_ok=True)
                with suppress(OSError):  # something else is in it
                    folder.rmdir()
    finally:
        os.close(mark)


def clear_batches(out: Path, study: PreparedStudy, columns: Sequence[Column]) -> None:
    """Remove the batches of a result that is there: its writer was killed before it did."""
    if batch_folder(out).is_dir():
        with suppress(InputError), open_batches(out, study, columns, resume=True):
            pass  # those of another study stay


def _read_keys(mark: int, folder: Path, study: PreparedStudy) -> set[str] | None:
    """Keys of the batches that are kept; None where nothing was begun. Raises InputError."""
    content = os.pread(mark, MARK_BYTES + 1, 0)
    if not content:
        return None
    if not content.endswith(b"\n"):  # its writer was killed
        os.write(mark, b"\n")
    digest, *keys = content.decode("ascii", "replace").split("\n")
    if digest != study.digest:
        raise InputError(
            str(folder), "", None, "holds batches of another study; remove the folder to begin anew"
        )
    return {key for key in keys if re.fullmatch("[0-9a-f]{32}", key)}


def _lock_list(handle: int, folder: Path) -> None:
    """Lock the list. A killed study's workers hold its lock for a moment longer than it lives."""
    for delay_s in (*[0.1] * 20, 0.0):
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            time.sleep(delay_s)
        except OSError:  # not every network file system has locks
            return
        else:
            return
    raise InputError(str(folder), "", None, "is in use by another process")

"""Files that appear whole or not at all: the one place where any are written."""

from __future__ import annotations

import fcntl
import os
import secrets
import stat
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from crosscheck.interruption import leftovers
from models.errors import InputError

# Under a name that begins so, a file grows until it takes its place.
DRAFT = ".crosscheck-"


def require_writable(folder: Path) -> None:
    """Make the folder if need be. Raises InputError unless a file can be made in it."""
    with _in_one_line(folder):
        if folder.is_file():
            raise InputError(str(folder), "", None, "is a file; a folder is expected")
        folder.mkdir(parents=True, exist_ok=True)
        with draft(folder):
            pass


def require_file(path: Path, option: str = "") -> Path:
    """Where a file of this name goes, links followed; its folder is made if need be.

    option: what to name in the message. Raises InputError unless the file can be written there.
    """
    with _in_one_line(path):
        target = Path(os.path.realpath(path))
        obstacle = _obstacle(target)
    if obstacle:
        where, value = (option, str(path)) if option else (str(path), None)
        raise InputError(where, "", value, obstacle)
    require_writable(target.parent)
    return target


def require_files(*paths: Path | None, apart_from: Path | None = None) -> None:
    """Raise InputError unless each can be written and is a file of its own: before the work."""
    taken = set() if apart_from is None else {os.path.realpath(apart_from)}
    for path in filter(None, paths):
        target = require_file(path)
        if os.path.realpath(target) in taken:
            raise InputError(str(path), "", None, "is in use for two things; name another file")
        taken.add(os.path.realpath(target))


def write_text(path: Path, text: str) -> None:
    """Write a file. Raises InputError."""
    write_files({path: text})


def write_files(contents: Mapping[Path, str | bytes]) -> None:
    """Write all of these files, or none of them. Raises InputError."""
    with ExitStack() as stack:
        ready = []
        for path, content in contents.items():
            target = require_file(path)
            with _in_one_line(path):
                remove_abandoned(target.parent)
                new = stack.enter_context(draft(target.parent))
                if target.exists():  # what is replaced keeps its permissions
                    os.fchmod(new.handle, stat.S_IMODE(target.stat().st_mode))
                new.write(_encoded(content), lasting=True)
                ready.append((path, new, target))
        for path, new, target in ready:
            with _in_one_line(path):
                new.publish(target)


@dataclass(frozen=True)
class Draft:
    """A file that has not got its name yet."""

    path: Path
    handle: int

    def write(self, content: bytes, lasting: bool = False) -> None:
        """All of it; ``lasting``: it will survive a power failure. Raises OSError."""
        with open(self.handle, "wb", closefd=False) as stream:
            stream.write(content)
        if lasting:
            os.fsync(self.handle)

    def publish(self, target: Path) -> None:
        """Put it in the place of the target, in the same folder. Raises OSError."""
        os.replace(self.path, target)


@contextmanager
def draft(folder: Path, mode: int = 0o666) -> Iterator[Draft]:
    """A new file, gone at the end unless published; mode as far as the umask leaves it.

    Raises OSError.
    """
    new = _locked(folder, mode)
    drop = partial(new.path.unlink, missing_ok=True)
    leftovers.append(drop)
    try:
        yield new
    finally:
        os.close(new.handle)
        drop()
        leftovers.remove(drop)


def _locked(folder: Path, mode: int) -> Draft:
    """The lock lasts as long as its writer lives, so that others can tell what was left behind."""
    flags = os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC
    while True:
        path = folder / f"{DRAFT}{secrets.token_hex(8)}"
        handle = os.open(path, flags, mode)
        if _lock(handle) and os.fstat(handle).st_nlink:
            return Draft(path, handle)
        os.close(handle)  # taken for abandoned before it was locked


def _lock(handle: int) -> bool:
    """Whether nobody else holds it."""
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:  # not every network file system has locks
        pass
    return True


def remove_abandoned(folder: Path) -> None:
    """Remove the drafts of processes that were killed."""
    for path in folder.glob(f"{DRAFT}*"):
        with suppress(OSError):  # being written, or not ours
            handle = os.open(path, os.O_RDWR | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC)
            try:
                fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
                path.unlink()
            finally:
                os.close(handle)


@contextmanager
def _in_one_line(path: Path) -> Iterator[None]:
    """Raise InputError instead of what the operating system says about a path."""
    try:
        yield
    except OSError as error:
        raise InputError(str(path), "", None, f"cannot be written: {error.strerror}") from None
    except UnicodeError:
        raise InputError(
            str(path), "", None, "cannot be written: this locale has no such file names"
        ) from None


def _obstacle(target: Path) -> str:
    """Why no file can be written there, if it can be told from what is there."""
    try:
        kind = target.lstat().st_mode
    except (FileNotFoundError, NotADirectoryError):  # which the folder's own check tells better
        return ""
    if stat.S_ISDIR(kind):
        return "is a folder; a file name is expected"
    if stat.S_ISLNK(kind):
        return "is a link that leads back to itself"
    if not stat.S_ISREG(kind):
        return "is no ordinary file; a file name is expected"
    return "" if os.access(target, os.W_OK) else "is write-protected"


def _encoded(content: str | bytes) -> bytes:
    # What is no text (a name in no encoding) is shown as what it is.
    return content.encode("utf-8", "backslashreplace") if isinstance(content, str) else content

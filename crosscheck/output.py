"""Files that appear whole or not at all: the one place where any are written."""

from __future__ import annotations

import fcntl
import os
import secrets
import stat
import sys
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

from crosscheck.file_types import FileType, identify_file_type, is_file_of_type
from crosscheck.models.errors import InputError
from crosscheck.models.inputs import is_input
from crosscheck.runner.interruption import cleanup_callbacks

# Under a name that begins so, a file grows until it takes its place.
DRAFT = ".crosscheck-"
OUTPUT = 1  # descriptor of standard output
NETCDF = (".nc", ".nc4", ".h5", ".hdf5")  # endings of NetCDF files, which are HDF5 files too
EXISTS = "exists already; init replaces no file"


def require_writable(folder: Path) -> None:
    """Raise InputError unless a file can be made in the folder, or the folder itself."""
    with convert_os_errors(folder):
        if folder.is_file():
            raise InputError(str(folder), "", None, "is a file; a folder is expected")
        with draft(find_existing_folder(folder)):
            pass


def find_existing_folder(folder: Path) -> Path:
    """The folder, or the nearest above it that exists. Raises OSError where it cannot be made."""
    try:
        folder.lstat()
    except FileNotFoundError:
        return find_existing_folder(folder.parent)
    return folder


def require_file(path: Path, kind: FileType | None = None, option: str = "") -> Path:
    """Path where a file of this name goes, links followed.

    kind: the kind of the content, which may replace a file of that kind alone, or go into a pipe;
    without a kind the caller sees to what is replaced, and there is no pipe. option: what to name
    in the message. Raises InputError unless the file can be written there.
    """
    with convert_os_errors(path):
        if kind is not None and _is_stream(path):
            return path
        target = Path(os.path.realpath(path))
        obstacle = _obstacle(target) or _replacement_obstacle(target, kind)
    if obstacle:
        where, value = (option, str(path)) if option else (str(path), None)
        raise InputError(where, "", value, obstacle)
    require_writable(target.parent)
    return target


def require_netcdf_name(path: Path) -> Path:
    """The path again. Raises InputError if its name promises another format than NetCDF."""
    if path.suffix not in ("", *NETCDF):
        raise InputError("--out", "", str(path), f"must end with {NETCDF[0]}: a NetCDF file")
    return path


def require_files(*outputs: tuple[Path | None, FileType], reserved: Path | None = None) -> None:
    """Raise InputError unless each file can be written and no two are the same; before the work."""
    taken = set() if reserved is None else {os.path.realpath(reserved)}
    files = [(path, kind) for path, kind in outputs if path is not None]
    for path, _ in files:  # before a folder is made for any of them
        if os.path.realpath(path) in taken:
            raise InputError(str(path), "", None, "is in use for two things; name another file")
        taken.add(os.path.realpath(path))
    for path, kind in files:
        require_file(path, kind)


def write_text(path: Path, text: str) -> None:
    """Write a file. Raises InputError."""
    write_files({path: text})


def require_new(path: Path) -> Path:
    """Where a TOML file can be written that does not exist yet. Raises InputError if it does."""
    if path.suffix not in ("", ".toml"):
        raise InputError(str(path), "", None, "must end with .toml")
    target = path if os.path.islink(path) else require_file(path)
    if os.path.lexists(target):  # also a link to a file that is not there
        raise InputError(str(path), "", None, EXISTS)
    return target


def write_new_text(path: Path, text: str) -> None:
    """Write a file where there is none. Raises InputError, also where another process was first."""
    target = require_new(path)
    with convert_os_errors(path), draft(target.parent) as new:
        new.write(text.encode("utf-8", "backslashreplace"), lasting=True)
        try:
            new.publish_new(target)
        except FileExistsError:
            raise InputError(str(path), "", None, EXISTS) from None


def write_files(contents: Mapping[Path, str | bytes]) -> None:
    """Write all of these files, or none of them; pipes last. Raises InputError."""
    encoded = {  # what is no text (a name in no encoding) is shown as what it is
        path: content.encode("utf-8", "backslashreplace") if isinstance(content, str) else content
        for path, content in contents.items()
    }
    streams = {}
    with ExitStack() as stack:
        ready = []
        for path, content in encoded.items():
            target = require_file(path, identify_file_type(content))
            with convert_os_errors(path):
                if _is_stream(path):
                    streams[path] = content
                    continue
                remove_abandoned(target.parent)
                new = stack.enter_context(draft(target.parent))
                if target.exists():  # what is replaced keeps its permissions
                    os.fchmod(new.handle, stat.S_IMODE(target.stat().st_mode))
                new.write(content, lasting=True)
                ready.append((path, new, target))
        for path, new, target in ready:
            with convert_os_errors(path):
                new.publish(target)
    for path, content in streams.items():
        with convert_os_errors(path):
            to_output = _is_output(path.stat())
            if to_output:
                sys.stdout.flush()
            with open(OUTPUT if to_output else path, "wb", closefd=not to_output) as stream:
                stream.write(content)


@dataclass(frozen=True)
class Draft:
    """A new file, open for writing, that does not have its final name yet."""

    path: Path
    handle: int

    def write(self, content: bytes, lasting: bool = False) -> None:
        """Write the whole content; ``lasting``: it will survive a power failure. Raises OSError."""
        with open(self.handle, "wb", closefd=False) as stream:
            stream.write(content)
        if lasting:
            os.fsync(self.handle)

    def reserve(self, size: int) -> None:
        """Reserve room for so many bytes, all of them 0. Raises OSError."""
        if hasattr(os, "posix_fallocate"):
            os.posix_fallocate(self.handle, 0, max(size, 1))
        os.ftruncate(self.handle, size)

    def write_at(self, place: int, content: bytes) -> None:
        """Write the whole content, from a place [bytes] on. Raises OSError."""
        left = memoryview(content)
        while left:
            done = os.pwrite(self.handle, left, place)
            left, place = left[done:], place + done

    def publish(self, target: Path) -> None:
        """Put the file in the place of the target, in the same folder. Raises OSError."""
        os.replace(self.path, target)

    def publish_new(self, target: Path) -> None:
        """Put the file where there is none. Raises OSError, FileExistsError for one made since."""
        try:
            os.link(self.path, target)
        except PermissionError:  # a file system without hard links
            self.publish(target)


@contextmanager
def draft(folder: Path, mode: int = 0o666) -> Iterator[Draft]:
    """A new file in a folder, removed at the end unless published, with folders made for it.

    mode: its permissions, as far as the umask leaves them. Raises OSError.
    """
    made = [each for each in (folder, *folder.parents) if not each.exists()]
    folder.mkdir(parents=True, exist_ok=True)
    new = _create_locked_draft(folder, mode)

    def drop() -> None:
        new.path.unlink(missing_ok=True)
        with suppress(OSError):  # a folder with a file in it stays
            for each in made:
                each.rmdir()

    cleanup_callbacks.append(drop)
    try:
        yield new
    finally:
        os.close(new.handle)
        drop()
        cleanup_callbacks.remove(drop)


def _create_locked_draft(folder: Path, mode: int) -> Draft:
    """A new file, locked while its writer lives, so that others can recognize a leftover."""
    flags = os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC
    while True:
        path = folder / f"{DRAFT}{secrets.token_hex(8)}"
        handle = os.open(path, flags, mode)
        is_locked = True
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            is_locked = False
        except OSError:  # not every network file system has locks
            pass
        if is_locked and os.fstat(handle).st_nlink:
            return Draft(path, handle)
        os.close(handle)  # taken for abandoned before it was locked


def remove_abandoned(folder: Path) -> None:
    """Remove the drafts of processes that were killed."""
    for path in folder.glob(f"{DRAFT}{'[0-9a-f]' * 16}"):
        with suppress(OSError):  # being written, or not ours
            handle = os.open(path, os.O_RDWR | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC)
            try:
                fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
                path.unlink()
            finally:
                os.close(handle)


@contextmanager
def convert_os_errors(path: Path) -> Iterator[None]:
    """Raise InputError instead of what the operating system says about a path."""
    try:
        yield
    except OSError as error:
        raise InputError(str(path), "", None, f"cannot be written: {error.strerror}") from None
    except UnicodeError:
        reason = "cannot be written: this locale has no such file names"
        raise InputError(str(path), "", None, reason) from None


def _obstacle(target: Path) -> str:
    """Reason why the target cannot be a file, judged by what is there; empty if there is none."""
    try:
        kind = target.lstat().st_mode
    except (FileNotFoundError, NotADirectoryError):  # the folder's check has the better message
        return ""
    if stat.S_ISDIR(kind):
        return "is a folder; a file name is expected"
    if stat.S_ISLNK(kind):
        return "is a link that leads back to itself"
    if not stat.S_ISREG(kind):
        return "is not an ordinary file; a file name is expected"
    return "" if os.access(target, os.W_OK) else "is write-protected"


def _replacement_obstacle(target: Path, kind: FileType | None) -> str:
    """Why the program may not replace what is at the target; empty if it may. Raises OSError."""
    if is_input(target):
        return "is read by this command; name another file"
    if kind is None or not target.exists() or is_file_of_type(target, kind):
        return ""
    return f"exists and is not {kind.description}; name another file, or remove it"


def _is_stream(path: Path) -> bool:
    """Whether a path is a pipe, or standard output by any name. Raises OSError."""
    try:
        state = path.stat()
    except OSError:  # the folder's check has the better message
        return False
    return stat.S_ISFIFO(state.st_mode) or _is_output(state)


def _is_output(state: os.stat_result) -> bool:
    with suppress(OSError):
        return os.path.samestat(state, os.fstat(OUTPUT))
    return False

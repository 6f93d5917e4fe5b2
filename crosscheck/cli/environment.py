"""Environment of the command line: streams that accept every print, folders, memory."""

from __future__ import annotations

import errno
import io
import os
import resource
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from platformdirs import user_cache_path, user_config_path

from crosscheck.models.directories import is_usable, prepare_cache_folder
from crosscheck.models.errors import InputError
from crosscheck.models.inputs import forget

LEAST_BYTES = 600_000_000  # least address space; a study's libraries take 450 MB


def prepare() -> None:
    """Prepare the process before it reads or prints. Raises InputError without a working folder."""
    forget()
    occupy_streams()
    for descriptor, name in enumerate(("stdin", "stdout", "stderr")):
        stream = getattr(sys, name)
        if descriptor and stream is getattr(sys, f"__{name}__"):  # not one that a caller put there
            outlet = _outlets[descriptor] = _Outlet(descriptor, "w", closefd=False)
            tolerant = io.TextIOWrapper(
                io.BufferedWriter(outlet),
                encoding=getattr(stream, "encoding", "utf-8"),
                errors="backslashreplace",  # for characters that the encoding lacks
                line_buffering=descriptor == 2 or outlet.isatty(),
            )
            setattr(sys, name, tolerant)
    columns = os.environ.get("COLUMNS", "")
    if columns.isdecimal() and not int(columns):  # some shells' word for an unknown width
        del os.environ["COLUMNS"]
    try:
        os.getcwd()  # libraries call it
    except OSError as error:
        raise InputError("working folder", "", None, f"is gone: {error.strerror}") from None
    # Processes share the work on many small matrices, where threads of the linear algebra idle.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    # Matplotlib prints a long warning if its own folders cannot be used.
    if not all(map(is_usable, _matplotlib_folders())):
        os.environ["MPLCONFIGDIR"] = str(prepare_cache_folder() / "matplotlib")


def _matplotlib_folders() -> list[Path]:
    if chosen := os.environ.get("MPLCONFIGDIR"):
        return [Path(chosen)]
    try:
        return [user_config_path("matplotlib"), user_cache_path("matplotlib")]
    except RuntimeError:  # there is no home
        return [Path("/nonexistent")]


def closing_code(code: int) -> int:
    """The exit code: 2 in place of 0 if standard output could not all be written, in one line."""
    sys.stdout.flush()
    lost = _outlets[1].failure if 1 in _outlets else None
    if lost is None or isinstance(lost, BrokenPipeError):  # a reader may stop reading
        return code
    print(f"crosscheck: standard output: cannot be written: {lost.strerror}", file=sys.stderr)
    return code or 2


@contextmanager
def require_memory() -> Iterator[None]:
    """Raise InputError where the limit is too low for the libraries, or for the work in here."""
    limit, _ = resource.getrlimit(resource.RLIMIT_AS)
    if resource.RLIM_INFINITY != limit < LEAST_BYTES:
        need = LEAST_BYTES // 10**6
        allowed = f"a limit of {limit // 10**6} MB is set; at least {need} are needed"
        raise InputError("memory", "", None, allowed)
    try:
        yield
    except MemoryError as error:
        raise InputError("memory", "", None, f"is not enough: {error or 'none left'}") from None
    except OSError as error:
        if error.errno != errno.ENOMEM:
            raise
        raise InputError("memory", "", None, f"is not enough: {error.strerror}") from None


class _Outlet(io.FileIO):
    """A descriptor that remembers its first write error, and then discards everything."""

    failure: OSError | None = None

    def write(self, data: Any) -> int:
        if self.failure is None:
            try:
                return super().write(data)
            except OSError as error:
                self.failure = error
        return len(data)


_outlets: dict[int, _Outlet] = {}


def occupy_streams() -> None:
    """Open closed streams: the next files would get their numbers, and engines print into them."""
    for descriptor in range(3):
        try:
            os.fstat(descriptor)
        except OSError:
            os.set_inheritable(os.open(os.devnull, os.O_RDWR), True)

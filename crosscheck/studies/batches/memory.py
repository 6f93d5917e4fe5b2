"""The memory that a command may have, where a limit is set: one line if it does not do."""

from __future__ import annotations

import errno
import resource
from collections.abc import Iterator
from contextlib import contextmanager

from crosscheck.models.errors import InputError

LEAST = 600_000_000  # bytes of address space, where the libraries take 450


@contextmanager
def enough_memory() -> Iterator[None]:
    """Raise InputError where the limit is too low for the libraries, or for the work in here."""
    limit, _ = resource.getrlimit(resource.RLIMIT_AS)
    if resource.RLIM_INFINITY != limit < LEAST:
        allowed = f"a limit of {limit // 10**6} MB is set; at least {LEAST // 10**6} are needed"
        raise InputError("memory", "", None, allowed)
    try:
        yield
    except MemoryError as error:
        raise InputError("memory", "", None, f"is not enough: {error or 'none left'}") from None
    except OSError as error:
        if error.errno != errno.ENOMEM:
            raise
        raise InputError("memory", "", None, f"is not enough: {error.strerror}") from None

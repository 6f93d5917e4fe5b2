"""numba's ``njit``, whose compiled functions are kept on disk under a checksum.

numba itself takes what it finds there as it is: a damaged file ends in an exception at every call
from then on, or in other machine code.
"""

from __future__ import annotations

import hashlib
import pickle
import sys
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

import numba
from numba.core.caching import IndexDataCacheFile

from crosscheck.models.errors import PROGRAM, one_line

CHECKSUM = 32  # bytes of SHA-256


def njit(*function: Callable[..., Any], **options: Any) -> Any:
    """numba's ``njit``, whose compiled functions are kept on disk under a checksum."""
    numbas: Any = numba.njit
    made = numbas(*function, **options)
    return _sealed(made) if function else lambda one: _sealed(made(one))


def _sealed(made: Any) -> Any:
    """The same compiled function, whose kept files are checked."""
    cache: Any = getattr(made, "_cache", None)
    own = getattr(cache, "_cache_file", None)
    if own is not None:
        base = own._index_name.removesuffix(".nbi")
        cache._cache_file = _Sealed(own._cache_path, base, own._source_stamp)
    return made


class _Sealed(IndexDataCacheFile):
    """The files of a function: an index, and the code for each kind of arguments."""

    def _load_index(self) -> dict[Any, str]:
        found = self._read(self._index_path)
        version, stamp, overloads = found if found is not None else (None, None, {})
        return overloads if (version, stamp) == (self._version, self._source_stamp) else {}

    def _save_index(self, overloads: dict[Any, str]) -> None:
        self._write(self._index_path, (self._version, self._source_stamp, overloads))

    def _load_data(self, name: str) -> Any:
        return self._read(self._data_path(name))

    def _save_data(self, name: str, data: Any) -> None:
        self._write(self._data_path(name), data)

    def _read(self, path: str) -> Any:
        """Content of a kept file; None if missing or, told in one line on stderr, not sound."""
        try:
            whole = Path(path).read_bytes()
        except FileNotFoundError:
            return None
        except OSError as error:
            return _say(path, error.strerror or "cannot be read")
        if hashlib.sha256(whole[CHECKSUM:]).digest() != whole[:CHECKSUM]:
            return _say(path, "damaged")
        return pickle.loads(whole[CHECKSUM:])

    def _write(self, path: str, content: Any) -> None:
        data = self._dump(content)
        with suppress(OSError), self._open_for_write(path) as file:  # else it is not kept
            file.write(hashlib.sha256(data).digest() + data)


def _say(path: str, reason: str) -> None:
    print(one_line(f"{PROGRAM}{path}: does not fit: {reason}; it is made again"), file=sys.stderr)

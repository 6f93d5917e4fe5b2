"""numba's ``njit``, whose compiled functions are kept in the user's cache folder.

numba itself keeps them wherever NUMBA_CACHE_DIR says or beside the source, and takes what it finds
there as it is: whoever can write there has code run, and a damaged file ends in an exception at
every call from then on. It compiles a function anew when the file that it stands in changes, but
not when a function that it calls does, in another file.
"""

from __future__ import annotations

import hashlib
import os
import pickle
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any

import numba
from numba.core.caching import (
    CompileResultCacheImpl,
    FunctionCache,
    IndexDataCacheFile,
    _CacheLocator,
)

from crosscheck.models.directories import prepare_code_folder, read_sealed, seal

FOLDER = "compiled"
LARGEST = 64 * 2**20  # size of a kept file [bytes]
PACKAGE = Path(__file__).parent  # functions for numba call none outside it


def njit(*function: Callable[..., Any], cache: bool = False, **options: Any) -> Any:
    """numba's ``njit``; with ``cache`` the compiled function is kept, if it can be anywhere."""
    numbas: Any = numba.njit
    made = numbas(*function, **options)
    keep = _keep if cache else lambda row: row
    return keep(made) if function else lambda row: keep(made(row))


def _keep(compiled_function: Any) -> Any:
    """The same function, with its compiled code kept."""
    if hasattr(
        compiled_function, "py_func"
    ):  # numba hands the function itself back where it compiles nothing
        with suppress(OSError):  # no folder anywhere
            compiled_function._cache = _Cache(compiled_function.py_func)
    return compiled_function


class _Locator(_CacheLocator):
    """The place of a function's files, and the stamp of the sources that they follow."""

    def __init__(self, py_func: Any, py_file: str) -> None:
        self._py_file, self._line = py_file, py_func.__code__.co_firstlineno

    @classmethod
    def from_function(cls, py_func: Any, py_file: str) -> _Locator:
        return cls(py_func, py_file)

    def get_cache_path(self) -> str:
        return str(prepare_code_folder(FOLDER) / self.get_suitable_cache_subpath(self._py_file))

    def get_source_stamp(self) -> str:
        file = Path(self._py_file)
        return _stamp(PACKAGE if file.is_relative_to(PACKAGE) else file.parent)

    def get_disambiguator(self) -> str:
        return str(self._line)


@cache
def _stamp(folder: Path) -> str:
    """SHA-256 of all sources below a folder."""
    digest = hashlib.sha256()
    for path in sorted(folder.rglob("*.py")):
        digest.update(hashlib.sha256(path.read_bytes()).digest())
    return digest.hexdigest()


class _Implementation(CompileResultCacheImpl):
    _locator_classes = [_Locator]  # noqa: RUF012


class _Cache(FunctionCache):
    """The kept code of a function."""

    _impl_class = _Implementation

    def __init__(self, py_func: Any) -> None:
        super().__init__(py_func)
        locator = self._impl.locator
        os.makedirs(self._cache_path, mode=0o700, exist_ok=True)
        base = self._impl.filename_base
        self._cache_file = _CacheFile(self._cache_path, base, locator.get_source_stamp())


class _CacheFile(IndexDataCacheFile):
    """The files of a function: an index, and the code for each kind of arguments."""

    def _load_index(self) -> dict[Any, str]:
        content = self._read(self._index_path)
        version, stamp, overloads = content if content is not None else (None, None, {})
        return overloads if (version, stamp) == (self._version, self._source_stamp) else {}

    def _save_index(self, overloads: dict[Any, str]) -> None:
        self._write(self._index_path, (self._version, self._source_stamp, overloads))

    def _load_data(self, name: str) -> Any:
        return self._read(self._data_path(name))

    def _save_data(self, name: str, data: Any) -> None:
        self._write(self._data_path(name), data)

    def _read(self, path: str) -> Any:
        """Content of a kept file; None if it is missing or, with a line on stderr, damaged."""
        data = read_sealed(Path(path), LARGEST)
        return None if data is None else pickle.loads(data)

    def _write(self, path: str, content: Any) -> None:
        data = self._dump(content)
        with suppress(OSError), self._open_for_write(path) as file:  # else it is not kept
            os.fchmod(file.fileno(), 0o600)
            file.write(seal(Path(path), data))

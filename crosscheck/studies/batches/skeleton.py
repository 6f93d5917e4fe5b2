"""A NetCDF file without its numbers: where each variable's will stand, and all bytes between.

HDF5 does not survive a disk that becomes full, so it is never let near one: it lays a file out in
memory, where only what it writes takes room, and the numbers are written by their places.
"""

from __future__ import annotations

import io
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import h5netcdf
import h5py
import numpy as np

PAGE = 1 << 16


@dataclass(frozen=True)
class Skeleton:
    """size: of the whole file [bytes]; places: of each variable's first number, by its name."""

    size: int
    places: dict[str, int]
    memory: _Sparse

    def pieces(self) -> Iterator[tuple[int, bytes]]:
        """All bytes that are no numbers to come, each piece with its place."""
        for number, page in sorted(self.memory.pages.items()):
            yield number * PAGE, bytes(page[: self.size - number * PAGE])


def laid_out(fill: Callable[[h5netcdf.File], list[str]]) -> Skeleton:
    """The skeleton of the file that a function fills; it gives the names of the rooms in it."""
    memory = _Sparse()
    with h5netcdf.File(memory, "w") as file:
        names = fill(file)
    with h5py.File(memory, "r") as file:
        places = {name: file[name].id.get_offset() for name in names}
    return Skeleton(memory.size, places, memory)


def room(file: h5netcdf.File, name: str, dims: tuple[str, ...]) -> h5netcdf.Variable:
    """A variable of numbers whose place is kept free."""
    kept_free = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    kept_free.set_alloc_time(h5py.h5d.ALLOC_TIME_EARLY)
    kept_free.set_fill_time(h5py.h5d.FILL_TIME_NEVER)
    made = file.create_variable(name, dims, np.float64, fillvalue=np.nan, dcpl=kept_free)
    if not dims:  # h5py takes no such wishes for a single number, which has its place once written
        made[...] = np.nan
    return made


class _Sparse(io.RawIOBase):
    """A file in memory of which only what was written takes room."""

    def __init__(self) -> None:
        self.pages: dict[int, bytearray] = {}
        self.size = self.at = 0

    def readable(self) -> bool:
        return True

    def writable(self) -> bool:
        return True

    def seekable(self) -> bool:
        return True

    def seek(self, offset: int, whence: int = io.SEEK_SET) -> int:
        self.at = offset + {io.SEEK_SET: 0, io.SEEK_CUR: self.at, io.SEEK_END: self.size}[whence]
        return self.at

    def tell(self) -> int:
        return self.at

    def truncate(self, size: int | None = None) -> int:
        self.size = self.at if size is None else size
        return self.size

    def readinto(self, buffer: Any) -> int:
        view = memoryview(buffer).cast("B")
        count = max(0, min(len(view), self.size - self.at))
        for begin, page, inside in self._parts(count):
            kept = self.pages.get(page)
            piece = bytes(inside.stop - inside.start) if kept is None else kept[inside]
            view[begin : begin + len(piece)] = piece
        self.at += count
        return count

    def write(self, data: Any) -> int:
        view = memoryview(data).cast("B")
        for begin, page, inside in self._parts(len(view)):
            kept = self.pages.setdefault(page, bytearray(PAGE))
            kept[inside] = view[begin : begin + inside.stop - inside.start]
        self.at += len(view)
        self.size = max(self.size, self.at)
        return len(view)

    def _parts(self, count: int) -> Iterator[tuple[int, int, slice]]:
        """Of the next bytes: from which on they are in which page, and where there."""
        done = 0
        while done < count:
            page, first = divmod(self.at + done, PAGE)
            last = min(PAGE, first + count - done)
            yield done, page, slice(first, last)
            done += last - first

"""NetCDF files from outside: opened once, in a process of its own, and checked.

HDF5 ends the process of whoever hands it certain files, or never comes back. So a worker opens
them, within a time of work; it looks at every variable's form before it reads one, and follows
nothing that leads out of the file.
"""

from __future__ import annotations

import re
import signal
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import h5netcdf
import h5py
import numpy as np
import xarray as xr
from xarray.backends import H5NetCDFStore

from crosscheck.models.errors import InputError
from crosscheck.models.inputs import convert_read_errors, input_size
from crosscheck.runner.isolated_reading import read_in_subprocess
from crosscheck.studies.batches.result_file import SCHEMA_VERSION, STUDY, VERSION

LONGEST = 2000  # characters of a name or an attribute that is looked at
ATTRIBUTES = ("units", "long_name", "comment", "coordinates")  # of a variable, that are read
MOST_VARIABLES = 5000
MOST_PACKED = 1_000_000_000  # size limit of decompressed variables [bytes]
OPENING_S, READING_BYTES_PER_S = 3.0, 5e7
FILTERS = (h5py.h5z.FILTER_DEFLATE, h5py.h5z.FILTER_SHUFFLE, h5py.h5z.FILTER_FLETCHER32)
SCALE = "This is a netCDF dimension but not a netCDF variable"
Use = Callable[[Any], Any]


class NetcdfFile:
    """An open NetCDF file whose form was found to be one that can be read; in a worker.

    content: its variables, not read yet; command: that writes such files.
    """

    description, command = "NetCDF file", ""

    def __init__(self, path: Path, file: h5py.File) -> None:
        self.path, self.file = path, file
        self._require(len(file) <= MOST_VARIABLES, f"more than {MOST_VARIABLES} variables")
        packed = sum(self._require_sound(name) for name in file)
        self._require(packed <= MOST_PACKED, f"compressed to less than it may be: {packed} bytes")
        store = H5NetCDFStore(h5netcdf.File(file))
        self.content = xr.open_dataset(store, decode_times=False, mask_and_scale=False)

    def require_version(self, supported_version: int) -> None:
        """Raise InputError unless a file states this version."""
        version = _single_value(self.file, "schema_version")
        self._require(isinstance(version, int | np.integer), "no schema_version")
        self._require(
            version == supported_version, f"schema_version {version}; {supported_version} is read"
        )

    def read_variables(self, names: Sequence[str]) -> xr.Dataset:
        """These variables, which must be numbers, with coordinates of finite numbers or words."""
        for name in names:
            self._require(self.file[name].dtype.kind in "iuf", f"{name} holds no numbers")
        read = self.content[list(names)].load()
        for coordinate, values in read.coords.items():
            if values.dtype.kind not in "iuf":
                for word in values.values.ravel():
                    self._require_printable(str(coordinate), word)
            else:
                is_finite = bool(np.isfinite(values.values).all())
                self._require(is_finite, f"{coordinate} is not finite")
        signal.setitimer(signal.ITIMER_PROF, 0)
        return read

    def _text(self, node: h5py.HLObject, key: str) -> str:
        return self._require_printable(f"{node.name}: {key}", _single_value(node, key))

    def _require_printable(self, what: str, text: Any) -> str:
        self._require(isinstance(text, str), f"{what} is not text")
        self._require(len(text) <= LONGEST and text.isprintable(), f"{what} is not one line")
        return str(text)

    def _require_sound(self, name: str) -> int:
        """Check a variable before it is read; returns its size [bytes] if compressed, else 0."""
        self._require_printable("a variable's name", name)
        hard = isinstance(self.file.get(name, getlink=True), h5py.HardLink)
        self._require(hard, f"{name} leads elsewhere")
        data = self.file[name]
        self._require(isinstance(data, h5py.Dataset), f"{name} is not a variable")
        plist = data.id.get_create_plist()
        stored = plist.get_layout() in (h5py.h5d.CONTIGUOUS, h5py.h5d.CHUNKED, h5py.h5d.COMPACT)
        self._require(stored and not plist.get_external_count(), f"{name} is stored elsewhere")
        kind = data.dtype.kind
        plain = kind in "iuf" and data.dtype.itemsize <= 8
        text = kind == "O" and h5py.check_string_dtype(data.dtype) is not None
        self._require(plain or text, f"{name} is neither numbers nor text")
        self._require(data.shape is not None, f"{name} has no values")
        for key in ATTRIBUTES:
            if key in data.attrs:
                self._text(data, key)
        filters = [plist.get_filter(number)[0] for number in range(plist.get_nfilters())]
        self._require(set(filters) <= set(FILTERS), f"{name} has a filter")
        if not filters:
            is_size = data.is_scale and SCALE in str(data.attrs.get("NAME"))
            fits = is_size or data.nbytes <= data.id.get_storage_size()
            self._require(fits, f"{name} is larger than what is stored of it")
        return int(data.nbytes) if filters else 0

    def _require(self, sound: bool, what: str) -> None:
        if not sound:
            raise InputError(str(self.path), "", None, f"is not a {self.description}: {what}")


class StudyResultFile(NetcdfFile):
    """An open file whose form was found to be that of a study's result; in a worker."""

    description, command = "result of a study", "sweep"

    def __init__(self, path: Path, file: h5py.File) -> None:
        super().__init__(path, file)
        self.require_version(SCHEMA_VERSION)
        self.study, self.version = self._text(file, STUDY), self._text(file, VERSION)
        self._require(re.fullmatch("[0-9a-f]{64}", self.study) is not None, STUDY)
        self._text(file, "title")

    def identity(self) -> tuple[str, str]:
        """Digest of the study that the result is of, and fingerprint of what made it."""
        return self.study, self.version


def use_file(path: Path, use: Use, form: type[NetcdfFile] = StudyResultFile) -> Any:
    """Call a function on an opened file of a form, in another process. Raises InputError."""
    with convert_read_errors(str(path)):
        size = input_size(path)
    return read_in_subprocess(
        str(path),
        _open_and_use,
        path,
        use,
        form,
        within_s=OPENING_S + size / READING_BYTES_PER_S,
        fails=f"is not a {form.description}",
        dies="HDF5 cannot read it",
    )


def _open_and_use(path: Path, use: Use, form: type[NetcdfFile]) -> Any:
    if not h5py.is_hdf5(path):
        made = f"; crosscheck {form.command} writes one" if form.command else ""
        raise InputError(str(path), "", None, f"is not a {form.description}{made}")
    with h5py.File(path, "r", locking=False) as file:
        return use(form(path, file))


def _single_value(node: h5py.HLObject, key: str) -> Any:
    """The value of an attribute that has only one; None for any other."""
    value: Any = node.attrs.get(key)
    return value if np.ndim(value) == 0 else value.flat[0] if np.size(value) == 1 else None

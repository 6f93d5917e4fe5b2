"""Damaged and hostile results cost one line, exit code 2, and no time."""

import operator
import shutil
import time
from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
import pytest

import crosscheck
from tests.obstacles import OBSTACLES
from tests.processes import Command
from tests.tool.test_bad_input import assert_one_line

WITHIN_S = 5.0
UNIFORM = {"kind": "uniform", "relative_tolerance": 0.2}


@pytest.fixture(scope="module")
def result(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A result with words, numbers, samples and joints."""
    out = tmp_path_factory.mktemp("result") / "out.nc"
    crosscheck.sweep(
        "paper-labelled",
        [
            {"path": "switches.phase", "kind": "list", "values": ["angle", "omega_t"]},
            {"path": "arm.joints.*.*_mesh.backlash_m", "each": True, **UNIFORM},
        ],
        scenario="pd",
        settings={"scenario.duration_s": 0.001},
        measures=[{"kind": "peak", "signal": "theta"}],
        samples=3,
        out=out,
    )
    return out


def _again(file: h5py.File, **options: object) -> None:
    """The quantity as another variable of the same name."""
    old = file["theta_peak"]
    scales = [dim[0] for dim in old.dims]
    kept, values = dict(old.attrs), old[()]
    del file["theta_peak"]
    wanted = {"data": values, **options}
    if "shape" in wanted or "external" in wanted:
        wanted = {"shape": values.shape, "dtype": "f8", **options}
    made = file.create_dataset("theta_peak", **wanted)
    for key, value in kept.items():
        if key not in ("DIMENSION_LIST", "_Netcdf4Coordinates"):
            made.attrs[key] = value
    for dim, scale in zip(made.dims, scales, strict=False):
        dim.attach_scale(scale)


def _wrong_sum(file: h5py.File) -> None:
    _again(file, fletcher32=True, chunks=(1, 3, 2))
    made = file["theta_peak"]
    place = made.id.get_chunk_info(0).byte_offset
    file.flush()
    with open(file.filename, "r+b") as raw:
        raw.seek(place)
        raw.write(b"\xff" * 4)


def _many(file: h5py.File) -> None:
    for number in range(200):
        made = file.create_dataset(f"number{number}", data=np.arange(3.0))
        made.dims[0].attach_scale(file["sample"])


def _put(name: str, value: object) -> Callable[[h5py.File], None]:
    return lambda file: operator.setitem(file, name, value)


def _attribute(name: str, value: object, of: str = "theta_peak") -> Callable[[h5py.File], None]:
    return lambda file: operator.setitem(file[of].attrs, name, value)


def _infinite(file: h5py.File) -> None:
    file["sample"][...] = 7
    file["theta_peak"][...] = np.array([1e308, -1e308, 1e308]).reshape(1, 3, 1)


SHAPE, ELSEWHERE = (2, 3, 2), h5py.VirtualLayout(shape=(3,), dtype="f8")
ELSEWHERE[:] = h5py.VirtualSource("/etc/passwd", "x", shape=(3,))
HARM: dict[str, Callable[[h5py.File], object]] = {
    "wrong checksum": _wrong_sum,
    "huge shape": lambda file: _again(file, shape=(2, 3, 10**15), chunks=(1, 1, 1000), dtype="f8"),
    "bomb": lambda file: _again(
        file, shape=(2, 3, 10**9), chunks=(1, 1, 10**6), dtype="f8", compression="gzip"
    ),
    "external storage": lambda file: _again(file, external=[("/etc/passwd", 0, 96)]),
    "external link": _put("other", h5py.ExternalLink("/etc/passwd", "/x")),
    "soft loop": _put("loop", h5py.SoftLink("/loop")),
    "hard loop": lambda file: operator.setitem(file.create_group("group"), "up", file["/"]),
    "virtual": lambda file: file.create_virtual_dataset("virtual", ELSEWHERE),
    "words": lambda file: _again(
        file, data=np.full(SHAPE, b"text", dtype=object), dtype=h5py.string_dtype()
    ),
    "compound": lambda file: _again(file, data=np.zeros(SHAPE, dtype=[("a", "f8"), ("b", "i4")])),
    "hundreds of variables": _many,
    "no scales": lambda file: file.create_dataset("bare", data=np.arange(3.0)),
    "units of numbers": _attribute("units", 7.0),
    "units of lines": _attribute("units", "m\n\x1b[31m"),
    "long label": _attribute("long_name", "x" * 100_000),
    "many labels": _attribute("long_name", np.arange(1000)),
    "coordinates": _attribute("coordinates", [b"\xff\xfe"]),
    "no study": _attribute("study_sha256", "nobody's", "/"),
    "study of numbers": _attribute("study_sha256", np.arange(64), "/"),
    "title of lines": _attribute("title", "a\x1b[31m\nb", "/"),
    "another format": _attribute("schema_version", 99, "/"),
    "format of words": _attribute("schema_version", "one", "/"),
    "references": _attribute("DIMENSION_LIST", 7),
    "a range of no floats": _infinite,
}
HARMLESS = {
    "seconds": _attribute("units", "seconds"),
    "days": _attribute("units", "days since yesterday"),
}


def assert_refused(crosscheck: Command, file: Path) -> None:
    began = time.process_time()
    assert_one_line(crosscheck("plot", file))
    assert time.process_time() - began < WITHIN_S


@pytest.mark.parametrize("harm", HARM)
def test_a_hostile_file_is_refused_in_one_line(result, tmp_path, crosscheck, harm):
    file = tmp_path / "bad.nc"
    shutil.copy(result, file)
    with h5py.File(file, "r+") as opened:
        HARM[harm](opened)
    assert_refused(crosscheck, file)
    assert [path.name for path in tmp_path.iterdir()] == ["bad.nc"]


@pytest.mark.parametrize("change", HARMLESS)
def test_words_of_any_kind_are_drawn(result, tmp_path, crosscheck, change):
    file = tmp_path / "good.nc"
    shutil.copy(result, file)
    with h5py.File(file, "r+") as opened:
        HARMLESS[change](opened)
    answer = crosscheck("plot", file)
    assert (answer.code, answer.err) == (0, "")


ODD = {**OBSTACLES, "nothing": lambda path: None, "text": lambda path: path.write_text("text")}


@pytest.mark.parametrize("what", ODD)
def test_what_is_no_file_of_results_is_one_line(tmp_path, crosscheck, what):
    file = tmp_path / "it.nc"
    ODD[what](file)
    assert_refused(crosscheck, file)

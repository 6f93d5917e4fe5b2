"""`crosscheck cache clear`: all that the program keeps between runs."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from crosscheck.models.compiled import compiled_files
from crosscheck.models.places import cache_folder
from crosscheck.output import in_one_line
from crosscheck.provenance import ROOT
from crosscheck.report.words import printable
from crosscheck.runner.store import clear, entries

MACHINE_CODE = "machine-code"


class KeptFiles(NamedTuple):
    """A kind of files in a folder, with their sizes [bytes]."""

    said: str
    folder: Path
    sizes: dict[Path, int]


def clear_command() -> None:
    """Remove all, and say how much of what that was. Raises InputError."""
    for kind in kept():
        with in_one_line(kind.folder):
            for path in kind.sizes:
                path.unlink(missing_ok=True)
        size = sum(kind.sizes.values()) / 1e6
        print(
            f"removed {len(kind.sizes)} {kind.said}, {size:.1f} MB, {printable(str(kind.folder))}"
        )
    clear(cache_folder() / MACHINE_CODE)
    clear(cache_folder())


def kept() -> Iterator[KeptFiles]:
    """Simulations, kernels, and the functions of an engine, compiled."""
    own = cache_folder()
    machine_code = own / MACHINE_CODE
    compiled = {*compiled_files(ROOT / "crosscheck"), *(own / "compiled").glob("*/*.nb[ci]")}
    for said, folder, paths in (
        ("simulations", own, entries(own)),
        ("kernels", machine_code, sorted(machine_code.glob("*.o"))),
        ("compiled functions", ROOT, sorted(compiled)),
    ):
        with in_one_line(folder):
            sizes = {path: path.lstat().st_size for path in paths}
        yield KeptFiles(said, folder, sizes)

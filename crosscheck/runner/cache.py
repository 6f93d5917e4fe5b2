"""`crosscheck cache clear`: all that the program keeps between runs."""

from __future__ import annotations

from crosscheck.models.compiled import compiled_files
from crosscheck.models.places import cache_folder
from crosscheck.output import in_one_line
from crosscheck.provenance import ROOT
from crosscheck.report.words import printable
from crosscheck.runner.store import clear, entries

MACHINE_CODE = "machine-code"


def clear_command() -> None:
    """Remove simulations, kernels, and the functions of an engine, compiled; say how much of each.

    Raises InputError.
    """
    own = cache_folder()
    machine_code = own / MACHINE_CODE
    compiled = {*compiled_files(ROOT / "crosscheck"), *(own / "compiled").glob("*/*.nb[ci]")}
    for said, folder, paths in (
        ("simulations", own, entries(own)),
        ("kernels", machine_code, sorted(machine_code.glob("*.o"))),
        ("compiled functions", ROOT, sorted(compiled)),
    ):
        with in_one_line(folder):
            size = sum(path.lstat().st_size for path in paths) / 1e6
            for path in paths:
                path.unlink(missing_ok=True)
        print(f"removed {len(paths)} {said}, {size:.1f} MB, {printable(str(folder))}")
    clear(machine_code)
    clear(own)

"""`crosscheck cache clear`: all that the program keeps between runs."""

from __future__ import annotations

from crosscheck.models.errors import InputError
from crosscheck.models.places import cache_folder
from crosscheck.output import in_one_line
from crosscheck.report.words import printable
from crosscheck.runner.store import clear, entries


def clear_command() -> None:
    """Remove simulations, kernels, and the functions of an engine, compiled; say how much of each.

    Raises InputError.
    """
    own = cache_folder()
    machine_code, compiled = own / "machine-code", own / "compiled"
    for folder in (own, machine_code, compiled):
        if folder.is_symlink():  # it may lead to files of the user's own
            raise InputError(str(folder), "", None, "is a link; remove it")
    for said, folder, paths in (
        ("simulations", own, entries(own)),
        ("kernels", machine_code, sorted(machine_code.glob("*.o"))),
        ("compiled functions", compiled, sorted(compiled.glob("*/*.nb[ci]"))),
    ):
        with in_one_line(folder):
            size = sum(path.lstat().st_size for path in paths) / 1e6
            for path in paths:
                path.unlink(missing_ok=True)
        print(f"removed {len(paths)} {said}, {size:.1f} MB, {printable(str(folder))}")
    clear(machine_code)
    clear(own)

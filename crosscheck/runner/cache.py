"""`crosscheck cache clear`: all that the program keeps between runs."""

from __future__ import annotations

from crosscheck.models.directories import cache_folder
from crosscheck.models.errors import InputError, make_printable
from crosscheck.output import convert_os_errors
from crosscheck.runner.store import clear, find_entries


def clear_command() -> None:
    """Remove simulations, kernels, and the functions of an engine, compiled; say how much of each.

    Raises InputError.
    """
    cache_root = cache_folder()
    machine_code, compiled = cache_root / "machine-code", cache_root / "compiled"
    for folder in (cache_root, machine_code, compiled):
        if folder.is_symlink():  # it may lead to files of the user's own
            raise InputError(str(folder), "", None, "is a link; remove it")
    for description, folder, paths in (
        ("simulations", cache_root, find_entries(cache_root)),
        ("kernels", machine_code, sorted(machine_code.glob("*.o"))),
        ("compiled functions", compiled, sorted(compiled.glob("*/*.nb[ci]"))),
    ):
        with convert_os_errors(folder):
            size = sum(path.lstat().st_size for path in paths) / 1e6
            for path in paths:
                path.unlink(missing_ok=True)
        print(f"removed {len(paths)} {description}, {size:.1f} MB, {make_printable(str(folder))}")
    clear(machine_code)
    clear(cache_root)

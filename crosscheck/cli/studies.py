"""`crosscheck sweep`, a study's file in and its result out, and `plot`, a picture of one."""

from __future__ import annotations

import time
from collections.abc import Sequence
from functools import partial
from pathlib import Path

import numpy as np
import xarray as xr
from rich.console import Console
from rich.table import Table

from crosscheck.kinds import PICTURE
from crosscheck.models.inputs import remember
from crosscheck.output import require_file, write_files
from crosscheck.report.words import printable
from crosscheck.runner.progress import members_bar
from crosscheck.studies.batches.opened import used
from crosscheck.studies.batches.result_file import CHECKED
from crosscheck.studies.batches.run import How, run_study
from crosscheck.studies.definition.files import read_study
from crosscheck.studies.measures.columns import DIVERGED, columns
from crosscheck.studies.members.members import PreparedStudy


def sweep_command(
    file: Path, out: Path, jobs: int, scheduler: str | None, resume: bool, run_code: bool
) -> None:
    """Run a study into a NetCDF file and print what it found. Raises InputError."""
    study = read_study(file, run_code)
    began = time.monotonic()
    with members_bar() as told:
        ran = run_study(study, out, How(jobs, scheduler, resume, told))
    taken = time.monotonic() - began
    _print(study, out)
    rate = f", {ran:,} run in {taken:.1f} s, {ran / taken:.3g} a second" if ran else ""
    print(f"wrote {out}: {study.count:,} members{rate}" if ran else f"{out}: is complete")


def plot_command(file: Path, quantities: Sequence[str], out: Path | None) -> None:
    """Draw quantities of a result into a PNG file. Raises InputError."""
    from crosscheck.studies.plot import picture  # Matplotlib, which a study needs not

    remember(file)
    target = require_file(out or file.with_suffix(".png"), PICTURE, "--out")
    write_files({target: used(file, partial(picture, list(quantities)))})
    print(f"wrote {printable(str(target))}")


def _print(study: PreparedStudy, out: Path) -> None:
    """Print the range of every number, and how near a second engine came."""
    with xr.open_dataset(out, engine="h5netcdf", decode_times=False) as result:
        checked = CHECKED in result.dims
        heads = ["quantity", "unit", "undefined", "least", "median", "largest"]
        table = Table(*heads, *(["second engine off by"] * checked), box=None)
        gone = int(np.isfinite(result[DIVERGED].values).sum())
        if gone:
            print(f"{gone:,} of {study.count:,} members diverged and have no numbers")
        for column in columns(study):
            if "time" in column.dims or column.name == DIVERGED:
                continue
            known, size = _known(result, column.name), result[column.name].size
            row = [column.name, column.unit, f"{size - known.size:,} of {size:,}"]
            if known.size:
                row += [f"{n:.6g}" for n in (known.min(), np.median(known), known.max())]
            else:
                row += [""] * 3
            table.add_row(*map(printable, row), *([_off(result, column.name)] * checked))
        Console().print(table)


def _off(result: xr.Dataset, name: str) -> str:
    """The second engine's largest distance, and that over the spread of all members, as text."""
    worst = _known(result, f"{name}_difference")
    relative = _known(result, f"{name}_difference_over_spread")
    if not worst.size:
        return "undefined"
    of_spread = f" ({relative.max():.1g} of the spread)" if relative.size else ""
    return f"{worst.max():.2g}{of_spread}"


def _known(result: xr.Dataset, name: str) -> np.ndarray:
    """The values of a variable that are defined; none where there is no such variable."""
    values = result[name].values if name in result else np.empty(0)
    return values[np.isfinite(values)]

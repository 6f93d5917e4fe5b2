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
    """The range of every number, and how near a second engine came."""
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
            values = result[column.name].values
            row = [column.name, column.unit, *_range(values)]
            table.add_row(*map(printable, row), *([_off(result, column.name)] * checked))
        Console().print(table)


def _range(values: np.ndarray) -> list[str]:
    known = values[np.isfinite(values)]
    undefined = f"{values.size - known.size:,} of {values.size:,}"
    if not known.size:
        return [undefined, "", "", ""]
    return [undefined, *(f"{n:.6g}" for n in (known.min(), np.median(known), known.max()))]


def _off(result: xr.Dataset, name: str) -> str:
    """The worst distance, and that over the spread of all members."""
    worst, relative = (
        _largest(result, f"{name}_difference{suffix}") for suffix in ("", "_over_spread")
    )
    if worst is None:
        return "undefined"
    return f"{worst:.2g}" + (f" ({relative:.1g} of the spread)" if relative is not None else "")


def _largest(result: xr.Dataset, name: str) -> float | None:
    values = result[name].values if name in result else np.empty(0)
    known = values[np.isfinite(values)]
    return float(known.max()) if known.size else None

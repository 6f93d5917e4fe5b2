"""`crosscheck sweep` runs a study's file, and `crosscheck plot` draws the result."""

from __future__ import annotations

import re
import time
from collections.abc import Sequence
from functools import partial
from pathlib import Path

import numpy as np
import xarray as xr
from rich.console import Console
from rich.table import Column, Table

from crosscheck.file_types import PICTURE
from crosscheck.models.errors import make_printable
from crosscheck.models.inputs import remember
from crosscheck.output import require_file, require_netcdf_name, write_files
from crosscheck.report.formatting import format_unit
from crosscheck.runner.progress import show_progress
from crosscheck.studies.batches.netcdf_file import use_file
from crosscheck.studies.batches.result_file import CHECKED
from crosscheck.studies.batches.run import ExecutionSettings, run_study
from crosscheck.studies.definition.files import read_study
from crosscheck.studies.measures.columns import DIVERGED, list_columns
from crosscheck.studies.members.members import PreparedStudy

LEAST_WIDTH = 80  # columns in which each number of the table has room
MOST_WIDTH = 10_000  # columns in which a table is measured
NARROW_NAME = 14  # columns that a quantity's name has there


def sweep_command(file: Path, out: Path, jobs: int, resume: bool, run_code: bool) -> None:
    """Run a study into a NetCDF file and print a summary. Raises InputError."""
    require_netcdf_name(out)
    study = read_study(file, run_code)
    began = time.monotonic()
    with show_progress(f"running {make_printable(str(file))}") as progress:
        ran = run_study(study, out, ExecutionSettings(jobs, resume, progress))
    taken = time.monotonic() - began
    _print_ranges(study, out)
    rate = f", {ran:,} run in {taken:.1f} s, {ran / taken:.3g} a second" if ran else ""
    print(f"wrote {out}: {study.count:,} members{rate}" if ran else f"{out}: is complete")


def plot_command(file: Path, quantities: Sequence[str], out: Path | None) -> None:
    """Draw quantities of a result into a PNG file. Raises InputError."""
    from crosscheck.studies.plot import draw_selected  # Matplotlib, which no study needs

    remember(file)
    path = out or file.with_suffix(".png")
    target = require_file(path, PICTURE, "--out")
    write_files({target: use_file(file, partial(draw_selected, list(quantities)))})
    print(f"wrote {make_printable(str(path))}")


def _print_ranges(study: PreparedStudy, out: Path) -> None:
    """Print the range of every quantity, and the difference from a second engine."""
    with xr.open_dataset(out, engine="h5netcdf", decode_times=False) as result:
        checked = CHECKED in result.dims
        console = Console()
        console.width = max(console.width, LEAST_WIDTH)
        rows: list[list[str]] = []
        gone = int(np.isfinite(result[DIVERGED].values).sum())
        if gone:
            print(f"{gone:,} of {study.count:,} members diverged and have no numbers")
        for column in list_columns(study):
            if "time" in column.dims or column.name == DIVERGED:
                continue
            for label, part in _select_joints(result, column.name):
                defined_values, size = _defined_values(part, column.name), part[column.name].size
                row = [
                    label,
                    format_unit(column.unit),
                    f"{size - defined_values.size:,} of {size:,}",
                ]
                if defined_values.size:
                    median = np.median(defined_values)
                    numbers = defined_values.min(), median, defined_values.max()
                    row += [f"{number:.6g}" for number in numbers]
                else:
                    row += [""] * 3
                row += [_format_engine_difference(part, column.name)] * checked
                rows.append(list(map(make_printable, row)))
        console.print(_arrange_ranges(console, rows, checked))
    if (stride := study.base.scenario.stride) > 1:
        print(f"taken at recorded steps, one in {stride} (scenario.record_every)")


def _arrange_ranges(console: Console, rows: Sequence[Sequence[str]], checked: bool) -> Table:
    """The table of ranges: numbers and names whole; names folded where a console is too narrow."""
    all_defined = all(undefined.startswith("0 ") for _, _, undefined, *_ in rows)
    rows = [[*row[:2], *row[2 + all_defined :]] for row in rows]
    unlimited = console.options.update(width=MOST_WIDTH)
    folded = [[_fold_name(name), *others] for name, *others in rows]
    for arranged in (rows, folded):
        table = Table(Column("quantity", no_wrap=True), Column("unit", overflow="fold"), box=None)
        for head in ("undefined", "least", "median", "largest")[all_defined:]:
            table.add_column(head, no_wrap=True)
        if checked:
            table.add_column("engines differ\nby (of spread)", no_wrap=True)
        for row in arranged:
            table.add_row(*row)
        if console.measure(table, options=unlimited).maximum <= console.width:
            break
    return table


def _select_joints(result: xr.Dataset, name: str) -> list[tuple[str, xr.Dataset]]:
    """What stands before a quantity's numbers and the result; one for each of several joints."""
    joints = result[name].sizes.get("joint", 1)
    if joints == 1:
        return [(name, result)]
    return [(f"{name}, joint {joint + 1}", result.isel(joint=joint)) for joint in range(joints)]


def _fold_name(name: str) -> str:
    """A quantity's name in lines of a narrow terminal, which end with a word of it."""
    lines = [""]
    for piece in re.split(r"(?<=[_ ])", name):
        if lines[-1] and len((lines[-1] + piece).rstrip()) > NARROW_NAME:
            lines.append("")
        lines[-1] += piece
    return "\n".join(line.rstrip() for line in lines)


def _format_engine_difference(result: xr.Dataset, name: str) -> str:
    """The second engine's largest distance, and in brackets that over the spread of all members."""
    worst = _defined_values(result, f"{name}_difference")
    relative = _defined_values(result, f"{name}_difference_over_spread")
    if not worst.size:
        return "undefined"
    of_spread = f" ({relative.max():.1g})" if relative.size else ""
    return f"{worst.max():.2g}{of_spread}"


def _defined_values(result: xr.Dataset, name: str) -> np.ndarray:
    """The values of a variable that are defined; none where there is no such variable."""
    values = result[name].values if name in result else np.empty(0)
    return values[np.isfinite(values)]

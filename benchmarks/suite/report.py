"""The rows as a file, which the docs show, as a table and as a figure."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import matplotlib.pyplot as plt

from benchmarks.suite.machine import Machine
from benchmarks.suite.rows import Row

SCHEMA_VERSION = 1
FOLDER = Path(__file__).parent.parent
HEAD = ("case", "quantity", "ratio", "against", "target", "", "value", "unit", "spread")


def write(rows: Sequence[Row], machine: Machine, folder: Path = FOLDER) -> None:
    """results.json and results.png."""
    content = {
        "schema_version": SCHEMA_VERSION,
        "machine": machine._asdict(),
        "rows": [_json_fields(row) for row in rows],
    }
    (folder / "results.json").write_text(json.dumps(content, indent=1, allow_nan=False) + "\n")
    draw(rows, folder / "results.png")


def read(file: Path) -> tuple[list[Row], Machine]:
    """The rows of a results.json, and where they were measured."""
    content = json.loads(file.read_text())
    none = {"value": math.nan, "spread": 0.0}
    rows = [
        Row(**{name: none.get(name) if of is None else of for name, of in each.items()})
        for each in content["rows"]
    ]
    return rows, Machine(**content["machine"])


def _json_fields(row: Row) -> dict[str, object]:
    """Numbers that are none as null."""
    return {
        name: None if isinstance(value, float) and not math.isfinite(value) else value
        for name, value in row._asdict().items()
    }


def format_markdown(rows: Sequence[Row], machine: Machine) -> str:
    """One table a part, ratios first."""
    versions = ", ".join(f"{name} {version}" for name, version in machine.versions.items())
    lines = [
        "# Benchmark results",
        "",
        f"Measured {machine.made}, revision {machine.revision}, on {machine.processor},",
        f"{machine.cores} cores, load {machine.load:.1f}; {machine.system};",
        f"{machine.compiler}; {versions}.",
        f"Medians of {machine.repeats} repeats in turn.",
        "",
    ]
    for table in dict.fromkeys(row.table for row in rows):
        lines += [f"## {table}", "", f"| {' | '.join(HEAD)} |", "|" + "---|" * len(HEAD)]
        lines += [_line(row) for row in rows if row.table == table]
        lines.append("")
    return "\n".join(lines)


def _line(row: Row) -> str:
    verdict = {True: "reached", False: "**not reached**", None: ""}[row.is_within_target]
    value = "" if math.isnan(row.value) else f"{row.value:.4g}"
    spread = f"{row.spread:.0%}" if row.spread else ""
    ratio, target = _number(row.ratio), _number(row.target)
    cells = (row.case, row.quantity, ratio, row.against, target, verdict, value, row.unit, spread)
    return f"| {' | '.join(cells)} |"


def _number(value: float | None) -> str:
    return "" if value is None else f"{value:.3g}"


def draw(rows: Sequence[Row], path: Path) -> None:
    """Ratios beside their targets, and what work buys which precision."""
    from benchmarks.suite.work_precision import collect_curves

    # A count that should be 0 has no place on a logarithmic axis; the table has it.
    target_rows = [row for row in rows if row.ratio and row.target]
    curves_by_case = collect_curves(rows)
    figure, axes = plt.subplots(
        1,
        1 + len(curves_by_case),
        figsize=(11 + 5 * len(curves_by_case), 1 + max(4, 0.25 * len(target_rows))),
        squeeze=False,
    )
    _draw_ratios(axes[0, 0], target_rows)
    for axis, (title, lines) in zip(axes[0, 1:], curves_by_case.items(), strict=True):
        for (solver, (errors, seconds)), look in zip(lines.items(), line_styles(), strict=False):
            axis.loglog(errors, seconds, label=solver, color=look.color, marker=look.marker)
        axis.set(title=title, xlabel="largest error", ylabel="wall time [s]")
        axis.legend(fontsize=7)
    figure.tight_layout()
    figure.savefig(path, dpi=120)
    plt.close(figure)


class LineStyle(NamedTuple):
    """Of a line."""

    color: str
    marker: str


def line_styles() -> Iterator[LineStyle]:
    """Of lines, no two alike: colours, and a marker for every round of them."""
    for marker in "os^vDP":
        for number in range(10):
            yield LineStyle(f"C{number}", marker)


def _draw_ratios(axis: plt.Axes, target_rows: Sequence[Row]) -> None:
    places = range(len(target_rows))
    over = [row.ratio / row.target for row in target_rows if row.ratio and row.target]
    colours = ["tab:green" if value <= 1 else "tab:red" for value in over]
    axis.barh(places, over, color=colours)
    axis.axvline(1, color="black")
    names = [f"{row.case}: {row.quantity} / {row.against}" for row in target_rows]
    axis.set_yticks(places, names, fontsize=7)
    axis.invert_yaxis()
    axis.set_xlabel("ratio over its target")
    if over:
        axis.set_xscale("log")

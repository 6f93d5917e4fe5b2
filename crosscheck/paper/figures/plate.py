"""A plate: one figure of the paper redrawn, with what the paper says of it and what is seen."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from html import escape
from typing import NamedTuple

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from crosscheck import signals
from crosscheck.envelope import envelope
from crosscheck.paper.figures.runs import LAWS
from crosscheck.paper.reading import arm_of
from crosscheck.paper.reductions import first_planets
from crosscheck.paper.scale import Scale
from crosscheck.paper.stage import paper_stage
from crosscheck.paper.undefined import UNDEFINED, recorded, shown
from crosscheck.report import fragments
from crosscheck.report.figures import BINS, legend, new_figure, not_reached, to_svg
from crosscheck.report.fragments import COLOURS
from crosscheck.studies.study import Study, Variant

MICRO = 1e6


@dataclass(frozen=True)
class Plate:
    """``paper``: what it says, paraphrased; ``seen``: here; ``values``: parameters; plain text.

    ``verdicts``: statement -> verdict; ``numbers``: as they go into the JSON file; ``table``: html
    that follows what is seen.
    """

    number: int
    title: str
    svg: str
    paper: str
    seen: str
    values: str
    verdicts: dict[str, str]
    numbers: Mapping[str, object] = field(default_factory=dict)
    table: str = ""

    def html(self) -> str:
        """From <h3> down."""
        said = "; ".join(f"{escape(s)}: <b>{escape(v)}</b>" for s, v in self.verdicts.items())
        title = escape(f"Figure {self.number}: {self.title}")
        drawing = fragments.figure(self.svg, self.values) if self.svg else ""
        paper = f"<p><b>The paper.</b> {escape(self.paper)}</p>" if self.paper else ""
        seen = f"<p><b>Here.</b> {escape(self.seen)}</p>"
        head = f'<h3 id="figure-{self.number}">{title}</h3>'
        parts = [head, drawing, paper, seen, self.table, f"<p><b>Verdict.</b> {said}.</p>"]
        return "\n".join(part for part in parts if part)

    def to_dict(self) -> dict[str, object]:
        """For JSON: numbers and verdicts; None for what is undefined."""
        numbers = recorded(self.numbers)
        return {"id": f"figure-{self.number}", "verdicts": self.verdicts, **numbers}


def undrawn(number: int, reason: str) -> Plate:
    """A plate that says why there is nothing to see."""
    seen = f"A run behind this figure has no result: {reason}."
    return Plate(number, "not drawn", "", "", seen, "", {"what the figure shows": UNDEFINED})


@dataclass
class Shelf:
    """The study's trajectories, each read once, planets being all alike without the repetitions."""

    study: Study
    scale: Scale
    held: dict[Variant, xr.Dataset] = field(default_factory=dict)

    def runs(self, variants: Iterable[Variant], number: int) -> dict[Variant, xr.Dataset]:
        """The variants' runs, cut to the scale, for a figure. Raises Diverged."""
        wanted = {variant: self.scale.cut(variant) for variant in variants}
        missing = [variant for variant in wanted.values() if variant not in self.held]
        self.held |= self.study.runs(missing, f"figure {number}", first_planets)
        return {variant: self.held[cut] for variant, cut in wanted.items()}

    def laws(self, number: int, variant: Callable[[str], Variant]) -> dict[str, xr.Dataset]:
        """Phase law -> run."""
        variants = {law: variant(law) for law in LAWS}
        runs = self.runs(variants.values(), number)
        return {law: runs[chosen] for law, chosen in variants.items()}

    def sweep(
        self, number: int, sizes: Iterable[float], variant: Callable[[str, float], Variant]
    ) -> dict[str, dict[float, xr.Dataset]]:
        """Phase law -> size -> run."""
        variants = {law: {size: variant(law, size) for size in sizes} for law in LAWS}
        runs = self.runs([v for row in variants.values() for v in row.values()], number)
        return {law: {size: runs[v] for size, v in row.items()} for law, row in variants.items()}


class Strip(NamedTuple):
    """One row of a figure over both phase laws: a quantity in a window [s]."""

    label: str
    values: Callable[[xr.Dataset], np.ndarray]
    window: tuple[float, float]


def law_figure(
    runs: Mapping[str, xr.Dataset],
    strips: Sequence[Strip],
    overlay: Callable[[Axes, xr.Dataset, tuple[float, float]], None] | None = None,
) -> str:
    """Strips below each other, laws side by side, one scale per row; zoomed parts are shaded above.

    ``overlay`` draws more into an axes, of a run, within a window.
    """
    figure, grid = new_figure(len(strips), len(runs), 1.9)
    for column, (law, run) in enumerate(runs.items()):
        grid[0, column].set_title(LAWS[law])
        for axes, strip in zip(grid[:, column], strips, strict=True):
            draw_strip(axes, run, strip)
            axes.locator_params(axis="x", nbins=6)
            if overlay is not None:
                overlay(axes, run, strip.window)
        for zoom in strips[1:]:
            grid[0, column].axvspan(*zoom.window, color="#d9a400", alpha=0.35, linewidth=0)
        grid[-1, column].set_xlabel("time [s]")
    same_scale(grid)
    if len(grid[0, 0].get_legend_handles_labels()[1]) > 1:
        legend(figure, grid[0, 0])
    return to_svg(figure)


def draw_strip(axes: Axes, run: xr.Dataset, strip: Strip) -> None:
    """Every column of the strip's values, (times,) or (times, joints)."""
    time = run["time"].values
    part = signals.window(time, *strip.window)
    values = strip.values(run)
    columns = values.reshape(time.size, -1).T
    for joint, (column, colour) in enumerate(zip(columns, COLOURS, strict=False), start=1):
        name = f"joint {joint}" if len(columns) > 1 else "shoulder"
        band(axes, time[part], column[part], name, colour)
    axes.set(ylabel=strip.label, xlim=strip.window)
    if not time[part].size:
        not_reached(axes)


def band(
    axes: Axes, time: np.ndarray, values: np.ndarray, label: str, colour: str, bins: int = BINS
) -> None:
    """A line, or from two samples a bin on the band from minima to maxima."""
    if time.size <= 2 * bins:
        axes.plot(time, values, label=label, color=colour, linewidth=1.0)
        return
    centres, low, high = envelope(time, values, bins)
    axes.fill_between(centres, low, high, label=label, color=colour, linewidth=0.6, alpha=0.75)


def same_scale(grid: np.ndarray) -> None:
    """One y range per row of axes, (rows, columns)."""
    for row in grid:
        limits = np.array([axes.get_ylim() for axes in row])
        for axes in row:
            axes.set_ylim(limits[:, 0].min(), limits[:, 1].max())


def table(head: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """A table; floats with four digits, a dash for what is undefined."""
    return fragments.table(head, [[_cell(value) for value in row] for row in rows])


def _cell(value: object) -> str:
    return shown(value, ".4g", "-") if value is None or isinstance(value, float) else str(value)


def conditions(run: xr.Dataset, more: str = "") -> str:
    """The parameter values of a geared run, for the line under a figure."""
    stage = paper_stage(arm_of(run))
    scenario, switches = (json.loads(run.attrs[name]) for name in ("scenario", "switches"))
    drive = ", ".join(f"{key} {_short(value)}" for key, value in scenario["drive"].items())
    parts = [
        f"Arm {arm_of(run).name}",
        f"b {MICRO * stage.backlash_m:g} µm, E {MICRO * stage.tooth_error_m:g} µm",
        f"k_m {stage.mesh_stiffness_N_per_m:g} N/m"
        f", k_a {stage.mesh_stiffness_amplitude_N_per_m:g} N/m",
        f"zeta {_short(stage.damping_ratio)}, dampers act {switches['damping']}",
        f"{switches['dead_zone']} dead zone",
        f"{run.attrs['model']}, RK4 with {run.attrs['step_s']:g} s",
        f"drive: {drive}",
    ]
    return f"{'; '.join(parts)}.{' ' + more if more else ''}"


def _short(value: object) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)

"""A plate: one figure of the paper redrawn, with what the paper says of it and what is seen."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from html import escape
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from crosscheck.envelope import envelope
from crosscheck.paper import signals
from crosscheck.paper.figures.runs import LAWS
from crosscheck.report.figures import BINS, new_figure, to_svg
from crosscheck.studies.study import Study, Variant
from models.arm import Arm

COLOURS = ("#1f5fa8", "#d1702c", "#2f8f5b", "#8a4fb0", "#b03050", "#5a6b7a", "#a08a20")
MICRO = 1e6


@dataclass(frozen=True)
class Plate:
    """``paper``: what it says, paraphrased; ``seen``: here; ``values``: parameters; html allowed.

    ``verdicts``: statement -> verdict; ``numbers``: JSON-able.
    """

    number: int
    title: str
    svg: str
    paper: str
    seen: str
    values: str
    verdicts: dict[str, str]
    numbers: dict[str, Any] = field(default_factory=dict)

    def html(self) -> str:
        """From <h3> down."""
        said = "; ".join(f"{escape(s)}: <b>{escape(v)}</b>" for s, v in self.verdicts.items())
        parts = {"The paper": self.paper, "Here": self.seen, "Verdict": f"{said}."}
        lines = [f"<p><b>{name}.</b> {text}</p>" for name, text in parts.items()]
        head = f'<h3 id="figure-{self.number}">Figure {self.number}: {self.title}</h3>'
        return "\n".join([head, self.svg, *lines, f"<p><small>{self.values}</small></p>"])

    def record(self) -> dict[str, Any]:
        """Numbers and verdicts."""
        return {"id": f"figure-{self.number}", "verdicts": self.verdicts, **self.numbers}


@dataclass
class Shelf:
    """The study's trajectories, each read once, planets being all alike without the repetitions."""

    study: Study
    quick: bool
    held: dict[Variant, xr.Dataset] = field(default_factory=dict)

    def runs(self, variants: Iterable[Variant], number: int) -> dict[Variant, xr.Dataset]:
        """The variants' runs, for a figure."""
        wanted = list(dict.fromkeys(variants))
        missing = [variant for variant in wanted if variant not in self.held]
        self.held |= self.study.runs(missing, f"figure {number}", first_planets)
        return {variant: self.held[variant] for variant in wanted}

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


def first_planets(run: xr.Dataset) -> xr.Dataset:
    """The run with one planet per joint: the paper's model moves all of a joint alike."""
    return run.isel(planet=[0]) if "planet" in run.dims else run


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
            if overlay is not None:
                overlay(axes, run, strip.window)
        for zoom in strips[1:]:
            grid[0, column].axvspan(*zoom.window, color="#d9a400", alpha=0.35, linewidth=0)
        grid[-1, column].set_xlabel("time [s]")
    same_scale(grid)
    grid[0, 0].legend(loc="best", frameon=False)
    return to_svg(figure)


def draw_strip(axes: Axes, run: xr.Dataset, strip: Strip) -> None:
    """Every column of the strip's values, (times,) or (times, joints)."""
    time = run["time"].values
    part = signals.window(time, *strip.window)
    values = strip.values(run)[part].reshape(time[part].size, -1)
    for joint, colour in zip(range(values.shape[1]), COLOURS, strict=False):
        name = f"joint {joint + 1}" if values.shape[1] > 1 else "shoulder"
        band(axes, time[part], values[:, joint], name, colour)
    axes.set(ylabel=strip.label, xlim=(time[part][0], time[part][-1]))


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
    """A table; floats with four digits, None as a dash."""
    cells = "".join(
        "<tr>" + "".join(f"<td>{_cell(value)}</td>" for value in row) + "</tr>" for row in rows
    )
    titles = "".join(f"<th>{escape(title)}</th>" for title in head)
    return f'<div class="wide"><table><tr>{titles}</tr>{cells}</table></div>'


def _cell(value: object) -> str:
    if value is None:
        return "-"
    return f"{value:.4g}" if isinstance(value, float) else escape(str(value))


def arm_of(run: xr.Dataset) -> Arm:
    """The arm of a run."""
    return Arm.model_validate(json.loads(run.attrs["arm"]))


def conditions(run: xr.Dataset, more: str = "") -> str:
    """The parameter values of a geared run, for the line under a figure."""
    joint = arm_of(run).joints[0]
    scenario, switches = (json.loads(run.attrs[name]) for name in ("scenario", "switches"))
    drive = ", ".join(f"{key} {_short(value)}" for key, value in scenario["drive"].items())
    parts = [
        f"Arm {arm_of(run).name}",
        f"b {MICRO * joint.backlash_m:g} µm, E {MICRO * joint.tooth_error_m:g} µm",
        f"k_m {joint.mesh_stiffness_N_per_m:g} N/m"
        f", k_a {joint.mesh_stiffness_amplitude_N_per_m:g} N/m",
        f"zeta {joint.damping_ratio:g}, dampers act {switches['damping']}",
        f"{switches['dead_zone']} dead zone",
        f"{run.attrs['model']}, RK4 with {run.attrs['step_s']:g} s",
        f"drive: {drive}",
    ]
    return escape("; ".join(parts)) + f".{' ' + more if more else ''}"


def _short(value: object) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)

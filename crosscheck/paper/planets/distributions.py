"""The third fluctuation with lumped and with free planets, setting by setting."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes

from crosscheck.paper.phase.cells import LABELLED, READINGS, SWAPPED
from crosscheck.paper.phase.experiments import SETTINGS, Setting
from crosscheck.paper.planets.pairs import STARTS, Freed
from crosscheck.paper.planets.samples import Cell, Quantiles, Request, Sample, samples
from crosscheck.paper.planets.verdict import FIRST_WORTH, LARGE_RAD_PER_S2, WORTH, Effect
from crosscheck.paper.scale import Scale
from crosscheck.paper.undefined import UNDEFINED, percent, shown
from crosscheck.report.figures import legend, new_figure, to_svg
from crosscheck.report.fragments import COLOURS, figure, heading, paragraph, table
from crosscheck.studies.study import Study

ZETAS = (0.003, 0.005, 0.007, 0.01, 0.015, 0.02)
RINGS = ("eq13", "corrected")
LAWS = ("omega_t", "angle")
TESTS = 2  # of every setting: of the shares and of the sizes
LUMPED = 8  # starts of planets counted as one; STARTS where they decide, and of free ones
MICRO = 1e6
LIMITS = {"omega_t": (5.0, 2e3), "angle": (1e-5, 1e3)}  # rad/s^2: of the drawing, by law
LEFT, RIGHT = -0.17, 0.17  # of a damping ratio: lumped, free


@dataclass(frozen=True)
class Distributions:
    """The settings and their text."""

    html: str
    records: Sequence[Freed]


def distributions(study: Study, scale: Scale) -> Distributions:
    """Every setting from many starts; with planets counted as one where the start decides."""
    records = _freed(study, scale)
    text = [
        heading("1. How large it is, with lumped and with free planets"),
        paragraph(_question()),
        figure(_figure(records), _caption()),
        table(_HEAD, map(_row, records)),
        paragraph(_statement(records)),
    ]
    return Distributions("\n".join(text), records)


def cells() -> list[Cell]:
    """Both readings, laws and ring rates over the damping ratio."""
    return [
        Cell(law, Setting(zeta, ring), arm)
        for law in LAWS
        for arm in (LABELLED, SWAPPED)
        for ring in RINGS
        for zeta in ZETAS
    ]


def _freed(study: Study, scale: Scale) -> list[Freed]:
    every = cells()
    found = _sampled(study, [(cell, LUMPED) for cell in every], scale)
    again = [cell for cell in every if _hangs_on_the_start(cell, *found[cell])]
    found |= _sampled(study, [(cell, STARTS) for cell in again], scale)
    return [Freed(cell, *found[cell], TESTS * len(every)) for cell in every]


def _hangs_on_the_start(cell: Cell, lumped: Sample, free: Sample) -> bool:
    """Or is one of the settings at which Exudyn is asked as well."""
    asked = cell in (Cell("omega_t", setting) for setting in SETTINGS)
    return asked or lumped.of_two_minds or free.of_two_minds


def _sampled(
    study: Study, wanted: Sequence[tuple[Cell, int]], scale: Scale
) -> dict[Cell, tuple[Sample, Sample]]:
    """Lumped and free."""
    pairs = {cell: _requests(cell, starts, scale) for cell, starts in wanted}
    requests = [request for pair in pairs.values() for request in pair]
    found = samples(study, requests, scale, "planets: distributions")
    return {cell: (found[lumped], found[free]) for cell, (lumped, free) in pairs.items()}


def _requests(cell: Cell, starts: int, scale: Scale) -> tuple[Request, Request]:
    counts = map(scale.starts, (starts, STARTS))
    lumped, free = (tuple(range(1, count + 1)) for count in counts)
    return Request(cell, "lumped", lumped), Request(cell, "free", free)


_HEAD = (
    "phase law",
    "reading",
    "ring rate",
    "zeta",
    "lumped: large in (95 % interval)",
    "free: large in (95 % interval)",
    "lumped: amplitude [rad/s²]",
    "free: amplitude [rad/s²]",
    "free: planets apart by up to [µm]",
    "p, shares",
    "p, sizes",
    "effect of freeing them",
)


def _row(record: Freed) -> tuple[str, ...]:
    cell, tests = record.cell, record.tests
    return (
        cell.law,
        cell.reading,
        cell.setting.ring_rate,
        f"{cell.setting.zeta:g}",
        _share(record.lumped),
        _share(record.free),
        _quantiles(record.lumped.amplitude),
        _quantiles(record.free.amplitude),
        _quantiles(record.free.spread, MICRO),
        shown(tests.by_share, ".2g"),
        shown(tests.by_size, ".2g"),
        str(record.effect),
    )


def _share(sample: Sample) -> str:
    share = sample.share
    if share is None:
        return UNDEFINED
    return f"{share.yes} of {share.of} ({share.low:.2f} to {share.high:.2f})"


def _quantiles(found: Quantiles, unit: float = 1.0) -> str:
    values = (found.median, found.low, found.high)
    median, low, high = (shown(None if v is None else unit * v, ".3g", "-") for v in values)
    return f"{median} ({low} to {high})"


def _question() -> str:
    return (
        "Question: does the third fluctuation of the paper's equations change when each planet of"
        " a stage has a coordinate of its own? The same equations, planets lumped or free; starts"
        " perturbed by up to 1e-12 m, planet by planet where they are free."
        f" {STARTS} starts of every setting with free planets, {LUMPED} with lumped ones, as many"
        f" where those do not agree whether it is large (above {LARGE_RAD_PER_S2:g} rad/s²) and"
        " where Exudyn is asked. Shares with Clopper and Pearson's interval, sizes as"
        " median with the quantiles 0.1 and 0.9. Freeing the planets counts as an effect where"
        " Fisher's exact test tells the shares apart, or Mann and Whitney's the sizes and the"
        f" medians differ by {percent(WORTH, '.0f')}; 5 % over all settings together, both tests of"
        f" each counted. The limit was {percent(FIRST_WORTH, '.0f')} in a first look and is"
        f" {percent(WORTH, '.0f')} now, as the older comparison between engines had it. Where the"
        f" start decides, lumped samples are extended from {LUMPED} to {STARTS} starts after a look"
        " at them, so there p is not that of a sample fixed beforehand."
    )


def _statement(records: Sequence[Freed]) -> str:
    told = [_told(law, [r for r in records if r.cell.law == law]) for law in LAWS]
    return " ".join([*told, _at_first_worth(records)])


def _at_first_worth(records: Sequence[Freed]) -> str:
    """What the older threshold would change."""
    other = [r for r in records if r.effect_at(FIRST_WORTH) != r.effect]
    told = f"Were {percent(FIRST_WORTH, '.0f')} the limit for the medians,"
    if not other:
        return f"{told} no effect would differ."
    named = "; ".join(
        f"{r.cell.law}, {_setting(r)}, then {r.effect_at(FIRST_WORTH)}" for r in other
    )
    return f"{told} the effect would differ in {len(other)} settings ({named})."


def _told(law: str, records: Sequence[Freed]) -> str:
    kinds = (Effect.WEAKER, Effect.STRONGER, Effect.NONE, Effect.UNKNOWN)
    counts = {kind: [r for r in records if r.effect == kind] for kind in kinds}
    parts = [
        f"{kind} in {len(found)}{_where(found) if kind in kinds[:2] else ''}"
        for kind, found in counts.items()
        if found
    ]
    return f"Under {law}, of {len(records)} settings: {'; '.join(parts)}."


def _where(records: Sequence[Freed]) -> str:
    return f" ({'; '.join(map(_setting, records))})"


def _setting(record: Freed) -> str:
    """Under its law."""
    cell = record.cell
    return f"{cell.reading}, {cell.setting.ring_rate}, zeta {cell.setting.zeta:g}"


def _figure(records: Sequence[Freed]) -> str:
    """A row per law and ring rate, a column per reading."""
    rows = [(law, ring) for law in LAWS for ring in RINGS]
    drawing, grid = new_figure(len(rows), len(READINGS), 1.9)
    for (row, column), axes in np.ndenumerate(grid):
        (law, ring), arm = rows[row], list(READINGS)[column]
        chosen = [
            r
            for r in records
            if (r.cell.law, r.cell.setting.ring_rate, r.cell.arm) == (law, ring, arm)
        ]
        _draw(axes, chosen, *LIMITS[law])
        axes.set(title=f"{READINGS[arm]}, {law}, ring rate {ring}")
    for axes in grid[:, 0]:
        axes.set_ylabel("third fluct. [rad/s²]")
    for axes in grid[-1]:
        axes.set_xlabel("zeta")
    legend(drawing, grid[0, 0])
    return to_svg(drawing)


def _draw(axes: Axes, records: Sequence[Freed], least: float, most: float) -> None:
    for place, record in enumerate(records):
        both = ((LEFT, record.lumped), (RIGHT, record.free))
        for (shift, sample), colour, name in zip(both, COLOURS, ("lumped", "free"), strict=False):
            found = [a for a in sample.amplitudes if not math.isnan(a)]
            at = place + shift + np.linspace(-0.09, 0.09, len(found))
            label = f"planets {name}" if place == 0 else None
            dots = np.clip(found, least, most)
            axes.plot(at, dots, ".", color=colour, markersize=3.5, label=label)
            _bar(axes, place + shift, sample.amplitude, colour)
    axes.axhline(LARGE_RAD_PER_S2, color="black", lw=0.8, ls="--")
    axes.set_xticks(range(len(records)), [f"{r.cell.setting.zeta:g}" for r in records])
    axes.set_ylim(least, most)
    axes.set_yscale("log")


def _bar(axes: Axes, at: float, found: Quantiles, colour: str) -> None:
    """From the quantile 0.1 to 0.9, the median across."""
    if found.low is None or found.median is None or found.high is None:
        return
    axes.plot([at, at], [found.low, found.high], color=colour, lw=4.5, alpha=0.3)
    axes.plot([at - 0.12, at + 0.12], [found.median] * 2, color=colour, lw=1.6)


def _caption() -> str:
    return (
        "Amplitude of the third fluctuation, a dot per start: planets lumped (left, blue) and free"
        " (right, orange). Bars: quantiles 0.1 to 0.9 and median. Dashed: large, above"
        f" {LARGE_RAD_PER_S2:g} rad/s². Dots at an edge lie beyond it."
    )

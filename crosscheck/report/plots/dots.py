"""Dots on a logarithmic axis, where a bar would begin nowhere: a row for each name."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SHORT = 100.0  # range of an axis below which a tick at each decade is too few


def draw_dots(
    names: Sequence[str], series: Mapping[str, Sequence[float]], colours: Sequence[str], label: str
) -> Figure:
    """A figure that is read whole on a phone; a value of 0 has no place on its axis and no dot.

    Args:
        names: Of the rows, from the top.
        series: By what the legend calls them, a value for each row.
        colours: Of the series.
        label: Of the axis, with its unit.
    """
    from matplotlib.figure import Figure
    from matplotlib.ticker import LogLocator

    figure, rows = Figure(figsize=(5.4, 0.28 * len(names) + 1.1), layout="constrained"), len(names)
    axes = figure.subplots()
    for (legend, values), colour in zip(series.items(), colours, strict=True):
        axes.plot(values, range(rows), "o", color=colour, label=legend)
    axes.set_yticks(range(rows), names, parse_math=False)  # a name may hold a dollar
    axes.invert_yaxis()
    axes.set_xscale("log")
    values = [value for each in series.values() for value in each if value > 0]
    is_short = bool(values) and max(values) < SHORT * min(values)
    axes.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5) if is_short else (1,)))
    axes.xaxis.set_major_formatter("{x:g}")
    axes.xaxis.set_minor_formatter("")
    axes.margins(y=0.5 / rows)
    axes.set_xlabel(label)
    axes.grid(alpha=0.4)
    figure.legend(loc="outside upper center", ncols=3, frameon=False)
    return figure

"""Figures of recordings: a row for each joint, a column for each way to look at it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from matplotlib.axes import Axes


class JointColumn(NamedTuple):
    """A column: its title, the name of its horizontal axis, and what draws a joint of a number."""

    title: str
    label: str
    draw: Callable[[int, Axes], None]


def draw_joints(
    names: Sequence[str], columns: Sequence[JointColumn], *, height: float, same_axis: bool
) -> str:
    """SVG text of all joints below each other.

    names: of the vertical axes; height: of a row [inch]; same_axis: whether columns share the
    horizontal one.
    """
    from matplotlib.figure import Figure

    from crosscheck.report.plots.figures import draw_legend, to_svg

    figure = Figure(figsize=(9, height * len(names)), layout="constrained")
    table = figure.subplots(len(names), len(columns), sharex=same_axis, squeeze=False)
    for place, column in enumerate(columns):
        for joint, axes in enumerate(table[:, place]):
            column.draw(joint, axes)
        table[0, place].set_title(column.title, fontsize="medium")
        table[-1, place].set_xlabel(column.label)
    for name, axes in zip(names, table[:, 0], strict=True):
        axes.set_ylabel(name)
    if table[0, 0].get_legend_handles_labels()[0]:
        draw_legend(figure, table[0, 0])
    return to_svg(figure)

"""What the pictures of a cost show, read back and held against the record."""

from collections.abc import Iterator

import numpy as np
import pytest

from crosscheck.cost import output
from crosscheck.cost.shortcuts import ShortcutCosts

SHORTCUTS = ("links", "armature")


def wrong_picture(found: ShortcutCosts) -> Iterator[str]:
    """Curves that are not those of the record, or of a colour that means something else."""
    figure = output.draw_torques(found)
    colours: dict[str, set] = {}
    if [axes for axes in figure.axes if axes.get_legend()] or len(figure.legends) != 1:
        yield "picture: a legend where curves may be"
    order = [left.get_ylabel().split("\n")[0] for left in figure.axes[::2]]
    if order != sorted(order, key=found.names.index):
        yield f"picture: {order}"
    for left, right in zip(figure.axes[::2], figure.axes[1::2], strict=True):
        name, unit = left.get_ylabel().split("\n")
        joint = found.names.index(name)
        torque = found.torques[:, joint]
        wanted = {
            "coupled": torque,
            "links": torque + found.errors["links"][:, joint],
            "armature minus coupled": found.errors["armature"][:, joint],
        }
        drawn = {line.get_label(): line for line in (*left.get_lines(), *right.get_lines())}
        if unit != f"[{found.units[joint]}]" or drawn.keys() != wanted.keys():
            yield f"picture: {name}, {unit}, {list(drawn)}"
            continue
        for label, line in drawn.items():
            colours.setdefault(line.get_color(), set()).add(label)
            curve = np.column_stack([found.time, wanted[label]])
            if not np.array_equal(line.get_xydata(), curve):
                yield f"picture: {label} of {name}"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(output, "MOST_DRAWN", 1)
        (name, _) = output.draw_torques(found).axes[0].get_ylabel().split("\n")
    (dots,) = output.draw_shares(found).axes
    names = [label.get_text() for label in dots.get_yticklabels()]
    for level, line in zip(SHORTCUTS, dots.get_lines(), strict=True):
        own = {each.joint: 100 * each.share for each in found.by_joint if each.level == level}
        shown = {names[row]: x for x, row in zip(*line.get_data(), strict=True)}
        if shown != own or line.get_color() != output.COLOURS[level]:
            yield f"picture: dots of {level}: {shown} for {own}"
    by = {each.joint: each.share for each in found.by_joint if each.level == "armature"}
    if by[name] != max(by.values()):
        yield f"picture: {name} where there is room for one"
    if len(figure.axes) != 2 * min(8, len(found.names)) or any(
        len(own) > 1 for own in colours.values()
    ):
        yield f"picture: {len(figure.axes)} axes, {colours}"

"""Figure of the controller's flutter."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import NullFormatter

from crosscheck.audit.experiments.cells import READINGS
from crosscheck.audit.hypotheses.evidence.feedback import PAPER_GAINS, SUN
from crosscheck.audit.hypotheses.evidence.flutter import Flutter, FlutterSetting
from crosscheck.audit.hypotheses.evidence.linear_limits import Threshold
from crosscheck.report.figures import legend, new_figure, to_svg
from crosscheck.report.fragments import COLOURS


def drawing(limits: Sequence[Threshold], cells: Sequence[Flutter]) -> str:
    """Threshold against pose and derivative gain; share of starts that vibrate against zeta."""
    picture, grid = new_figure(1, 3, 2.9)
    link = [r for r in limits if r.point.sensed != SUN and r.point.stiffness == 1]
    stretched = [r for r in link if not r.elbow_deg and r.point.gains[0] == PAPER_GAINS[0]]
    by_pose = [r for r in link if r.by_pose]
    _thresholds(grid[0, 0], by_pose, lambda r: r.elbow_deg, "elbow angle [°]")
    _thresholds(grid[0, 1], stretched, lambda r: r.point.gains[1], "D [N m s/rad]")
    _shares(grid[0, 2], cells)
    legend(picture, grid[0, 0], grid[0, 2])
    return to_svg(picture)


def _thresholds(
    axes: Axes, found: Sequence[Threshold], abscissa: Callable[[Threshold], float], label: str
) -> None:
    for arm, colour in zip(dict.fromkeys(r.point.arm for r in found), COLOURS, strict=False):
        points = sorted((abscissa(r), r.zeta) for r in found if r.point.arm == arm)
        axes.plot(*np.array(points).T, "o-", color=colour, label=READINGS[arm], ms=3)
    axes.set(xlabel=label, ylabel="unstable below ζ [1]", ylim=(0, None))


def _shares(axes: Axes, cells: Sequence[Flutter]) -> None:
    """Without tooth error."""
    plain = [one for one in cells if not one.setting.tooth_error_um]
    kinds = dict.fromkeys(_kind(one.setting) for one in plain)
    for kind, colour in zip(kinds, COLOURS[2:], strict=False):
        mine = [one for one in plain if _kind(one.setting) == kind]
        values = [one.share.value if one.share else np.nan for one in mine]
        axes.plot([r.setting.zeta for r in mine], values, "o-", color=colour, label=kind, ms=3)
    axes.set(xscale="log", xlabel="ζ", ylabel="share that vibrates [1]", ylim=(-0.05, 1.05))
    axes.xaxis.set_minor_formatter(NullFormatter())


def _kind(setting: FlutterSetting) -> str:
    """All but zeta."""
    words = [f"dampers act {'always' if setting.damping == 'always' else 'in contact'}"]
    if setting.played_back:
        words.append("no feedback")
    if not setting.varying:
        words.append("steady stiffness")
    if setting.planets == "lumped":
        words.append("planets lumped")
    return ", ".join(words)

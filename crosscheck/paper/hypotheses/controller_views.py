"""Tables and figure of the controller's flutter."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import NullFormatter

from crosscheck.paper.hypotheses.controller_records import Flutter, GrowthCheck, Threshold
from crosscheck.paper.hypotheses.feedback import PAPER_GAINS, SUN
from crosscheck.paper.undefined import shown, word
from crosscheck.report.figures import legend, log_y, new_figure, to_svg
from crosscheck.report.fragments import COLOURS, heading, paragraph, table


def survey_tables(survey: Sequence[Threshold]) -> list[str]:
    """Thresholds: sensing the link and the sun over poses, then gains and stiffness."""
    poses = [r for r in survey if _by_pose(r)]
    others = [r for r in survey if not _by_pose(r) or (r.point.sensed != SUN and not r.elbow_deg)]
    head = ["arm", "elbow [°]", "P [N m/rad]", "D [N m s/rad]", "k / k_m", "senses",
            "threshold ζ", "mode there [Hz]", "growth at ζ = 0 [1/s]"]  # fmt: skip
    return [
        heading("Thresholds from eigenvalues"),
        table(head, map(_threshold_row, poses), "Against pose and sensing, P = 1000, D = 400"),
        table(head, map(_threshold_row, others), "Against gains and mesh stiffness, elbow at 0°"),
    ]


def _by_pose(found: Threshold) -> bool:
    return found.point.gains == PAPER_GAINS and found.point.stiffness == 1


def _threshold_row(found: Threshold) -> list[str]:
    point = found.point
    return [
        point.arm,
        f"{found.elbow_deg:.0f}",
        f"{point.gains[0]:g}",
        f"{point.gains[1]:g}",
        f"{point.stiffness:g}",
        point.sensed,
        f"{found.zeta:.5f}" if found.zeta else "none",
        f"{found.frequency_Hz:.0f}",
        f"{found.undamped_growth_per_s:.3g}",
    ]


def growth_text(check: GrowthCheck) -> str:
    """The linear model against a simulation without play."""
    return heading("Does it grow as fast as the eigenvalues say?") + paragraph(
        f"Without play, tooth error and stiffness variation, at ζ = {check.zeta:g}, x_sp1's"
        f" vibration grows at {shown(check.measured_per_s, '.2f')} 1/s; the eigenvalues at the"
        f" mean pose (elbow {shown(check.elbow_deg, '.1f')}°) say"
        f" {shown(check.predicted_per_s, '.2f')} 1/s at"
        f" {shown(check.frequency_Hz, '.0f')} Hz. Verdict: {check.verdict}."
    )


def sweep_table(sweep: Sequence[Flutter]) -> str:
    """Simulated vibration over zeta."""
    rows = [
        [
            r.damping,
            f"{r.zeta:g}",
            f"{1e6 * r.tooth_error_m:g}",
            _size(r),
            shown(r.frequency_Hz, ".0f", ""),
            word(r.flutters, "goes on", "dies"),
        ]
        for r in sweep
    ]
    head = ["damping", "ζ", "E [µm]", "shoulder vibration [rad/s²]", "[Hz]", ""]
    return table(head, rows, "PD run, angle law, b = 50 µm, labelled reading")


def _size(run: Flutter) -> str:
    if run.diverged_s is not None:
        return f"diverged at {run.diverged_s:.2f} s"
    return shown(run.amplitude_rad_per_s2)


def drawing(survey: Sequence[Threshold], sweep: Sequence[Flutter]) -> str:
    """Threshold against pose and derivative gain; simulated vibration against zeta."""
    picture, grid = new_figure(1, 3, 2.9)
    link = [r for r in survey if r.point.sensed != SUN and r.point.stiffness == 1]
    poses = [r for r in link if _by_pose(r)]
    stretched = [r for r in link if not r.elbow_deg and r.point.gains[0] == PAPER_GAINS[0]]
    _thresholds(grid[0, 0], poses, lambda r: r.elbow_deg, "elbow angle [°]")
    _thresholds(grid[0, 1], stretched, lambda r: r.point.gains[1], "D [N m s/rad]")
    _vibration(grid[0, 2], sweep)
    legend(picture, grid[0, 0], grid[0, 2])
    return to_svg(picture)


def _thresholds(
    axes: Axes, found: Sequence[Threshold], abscissa: Callable[[Threshold], float], label: str
) -> None:
    for arm, colour in zip(dict.fromkeys(r.point.arm for r in found), COLOURS, strict=False):
        points = sorted((abscissa(r), r.zeta) for r in found if r.point.arm == arm)
        axes.plot(*np.array(points).T, "o-", color=colour, label=arm, ms=3)
    axes.set(xlabel=label, ylabel="threshold ζ", ylim=(0, None))


def _vibration(axes: Axes, sweep: Sequence[Flutter]) -> None:
    kinds = dict.fromkeys((r.damping, r.tooth_error_m) for r in sweep)
    for (damping, error), colour in zip(kinds, COLOURS[2:], strict=False):
        mine = [r for r in sweep if (r.damping, r.tooth_error_m) == (damping, error)]
        sizes = [r.amplitude_rad_per_s2 or np.nan for r in mine]
        label = f"{damping}, E = {1e6 * error:g} µm"
        axes.plot([r.zeta for r in mine], sizes, "o-", color=colour, label=label, ms=3)
    axes.set(xscale="log", xlabel="ζ", ylabel="vibration [rad/s²]")
    log_y(axes)
    axes.xaxis.set_minor_formatter(NullFormatter())

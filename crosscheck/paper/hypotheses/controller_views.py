"""Tables and figure of the controller's flutter."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import NullFormatter

from crosscheck.paper.hypotheses.feedback import SUN
from crosscheck.paper.undefined import shown, word
from crosscheck.report.figures import legend, log_y, new_figure, to_svg
from crosscheck.report.fragments import COLOURS, heading, paragraph, table

Record = dict[str, Any]


def survey_tables(survey: list[Record]) -> list[str]:
    """Thresholds: sensing the link and the sun over poses, then gains and stiffness."""
    poses = [r for r in survey if _by_pose(r)]
    others = [r for r in survey if not _by_pose(r) or (r["sensed"] != SUN and not r["elbow_deg"])]
    head = ["arm", "elbow [°]", "P [N m/rad]", "D [N m s/rad]", "k / k_m", "senses",
            "threshold ζ", "mode there [Hz]", "growth at ζ = 0 [1/s]"]  # fmt: skip
    return [
        heading("Thresholds from eigenvalues"),
        table(head, map(_threshold_row, poses), "Against pose and sensing, P = 1000, D = 400"),
        table(head, map(_threshold_row, others), "Against gains and mesh stiffness, elbow at 0°"),
    ]


def _by_pose(record: Record) -> bool:
    gains = (record["P_N_m_per_rad"], record["D_N_m_s_per_rad"])
    return gains == (1000.0, 400.0) and record["stiffness_over_k_m"] == 1


def _threshold_row(record: Record) -> list[str]:
    return [
        record["arm"],
        f"{record['elbow_deg']:.0f}",
        f"{record['P_N_m_per_rad']:g}",
        f"{record['D_N_m_s_per_rad']:g}",
        f"{record['stiffness_over_k_m']:g}",
        record["sensed"],
        f"{record['zeta']:.5f}" if record["zeta"] else "none",
        f"{record['frequency_Hz']:.0f}",
        f"{record['undamped_growth_per_s']:.3g}",
    ]


def growth_text(check: Record) -> str:
    """The linear model against a simulation without play."""
    return heading("Does it grow as fast as the eigenvalues say?") + paragraph(
        f"Without play, tooth error and stiffness variation, at ζ = {check['zeta']:g}, x_sp1's"
        f" vibration grows at {shown(check['measured_per_s'], '.2f')} 1/s; the eigenvalues at the"
        f" mean pose (elbow {shown(check['elbow_deg'], '.1f')}°) say"
        f" {shown(check['predicted_per_s'], '.2f')} 1/s at"
        f" {shown(check['frequency_Hz'], '.0f')} Hz. Verdict: {check['verdict']}."
    )


def sweep_table(sweep: list[Record]) -> str:
    """Simulated vibration over zeta."""
    rows = [
        [
            r["damping"],
            f"{r['zeta']:g}",
            f"{1e6 * r['tooth_error_m']:g}",
            _size(r),
            shown(r["frequency_Hz"], ".0f", ""),
            word(r["flutters"], "goes on", "dies"),
        ]
        for r in sweep
    ]
    head = ["damping", "ζ", "E [µm]", "shoulder vibration [rad/s²]", "[Hz]", ""]
    return table(head, rows, "PD run, angle law, b = 50 µm, labelled reading")


def _size(record: Record) -> str:
    if record["diverged_s"] is not None:
        return f"diverged at {record['diverged_s']:.2f} s"
    return shown(record["amplitude_rad_per_s2"])


def drawing(survey: list[Record], sweep: list[Record]) -> str:
    """Threshold against pose and derivative gain; simulated vibration against zeta."""
    picture, grid = new_figure(1, 3, 2.9)
    link = [r for r in survey if r["sensed"] != SUN and r["stiffness_over_k_m"] == 1]
    at_zero = [r for r in link if not r["elbow_deg"] and r["P_N_m_per_rad"] == 1000]
    _thresholds(grid[0, 0], [r for r in link if _by_pose(r)], "elbow_deg", "elbow angle [°]")
    _thresholds(grid[0, 1], at_zero, "D_N_m_s_per_rad", "D [N m s/rad]")
    _vibration(grid[0, 2], sweep)
    legend(picture, grid[0, 0], grid[0, 2])
    return to_svg(picture)


def _thresholds(axes: Axes, records: list[Record], abscissa: str, label: str) -> None:
    for arm, colour in zip(dict.fromkeys(r["arm"] for r in records), COLOURS, strict=False):
        points = sorted((r[abscissa], r["zeta"]) for r in records if r["arm"] == arm)
        axes.plot(*np.array(points).T, "o-", color=colour, label=arm, ms=3)
    axes.set(xlabel=label, ylabel="threshold ζ", ylim=(0, None))


def _vibration(axes: Axes, sweep: list[Record]) -> None:
    kinds = dict.fromkeys((r["damping"], r["tooth_error_m"]) for r in sweep)
    for (damping, error), colour in zip(kinds, COLOURS[2:], strict=False):
        mine = [r for r in sweep if (r["damping"], r["tooth_error_m"]) == (damping, error)]
        sizes = [r["amplitude_rad_per_s2"] or np.nan for r in mine]
        label = f"{damping}, E = {1e6 * error:g} µm"
        axes.plot([r["zeta"] for r in mine], sizes, "o-", color=colour, label=label, ms=3)
    axes.set(xscale="log", xlabel="ζ", ylabel="vibration [rad/s²]")
    log_y(axes)
    axes.xaxis.set_minor_formatter(NullFormatter())

"""A comparison with a record as lines for the terminal, as JSON and as a page."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from crosscheck import __version__
from crosscheck.recordings import messages
from crosscheck.recordings.compare import EngineDisagreement, RecordComparison, ResidualCurve
from crosscheck.recordings.engines import describe_engine
from crosscheck.recordings.friction import FrictionFit
from crosscheck.recordings.parameters import NORMAL, Estimate
from crosscheck.registry import LEVELS
from crosscheck.report.plots.joints import JointColumn, draw_joints
from crosscheck.report.records import format_json, to_json_value

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SCHEMA_VERSION = 3
MOST_PARAMETERS = 6  # of those alone, in the terminal
HEIGHT, TIME = 2.2, "time [s]"  # of a row in a picture [inch], and its horizontal axis
IN_SIGHT = 2.0  # medians of the noise band that a picture has room for
ComparisonOutcome = RecordComparison | EngineDisagreement


def describe_comparison(comparison: ComparisonOutcome) -> Iterator[str]:
    """The sentences that answer, then the engines, every level, joint and parameter."""
    yield from messages.describe_answers(comparison)
    yield ""
    yield from comparison.record.notes
    yield from map(describe_engine, comparison.engines)
    if isinstance(comparison, RecordComparison):
        yield from _describe_details(comparison)


def _describe_details(comparison: RecordComparison) -> Iterator[str]:
    knots = f"angles smoothed with a knot every {comparison.spacing_s:.3g} s"
    yield f"torques from {comparison.torques_from}; {knots}"
    for joint, (angle, torque) in enumerate(
        zip(comparison.angle_noise, comparison.torque_noise, strict=True), 1
    ):
        yield f"noise of joint {joint}: {angle:.2g} rad and {torque:.2g} N m a sample"
    for level in comparison.levels:
        share = level.fit.chi2 / level.fit.freedom
        name = messages.name_level(comparison, level.name)
        yield (
            f"{name}: residual {messages.format_values(level.fit.left)} N m rms (noise alone:"
            f" {messages.format_values(level.fit.noise)}), reduced chi-squared"
            f" {messages.format_number(share)}"
        )
    for each in comparison.single[:MOST_PARAMETERS]:
        yield f"alone: {messages.format_estimate(each)}"


def comparison_json(comparison: ComparisonOutcome) -> str:
    """JSON text of the whole comparison, with units in the names."""
    content: dict[str, Any] = {
        "schema_version": SCHEMA_VERSION,
        "answer": messages.describe_answers(comparison),
        "record": comparison.record.where,
        "notes": comparison.record.notes,
        "arm": comparison.arm.name,
        "program": f"geararm-crosscheck {__version__}",
        "torques_from": comparison.torques_from,
        "rows": int(comparison.record.time.size),
        "knot_spacing_s": comparison.spacing_s,
        "engines_agree": isinstance(comparison, RecordComparison),
        "engines": [engine.to_dict() for engine in comparison.engines],
    }
    if isinstance(comparison, RecordComparison):
        content |= _findings(comparison)
    return format_json(content)


def _findings(comparison: RecordComparison) -> dict[str, object]:
    return {
        "angle_noise_rad": comparison.angle_noise,
        "torque_noise_N_m": comparison.torque_noise,
        "decided": comparison.decided,
        "explained": comparison.explained,
        "candidates": comparison.candidates,
        "own_chi2": comparison.residual_chi2,
        "own_degrees_of_freedom": comparison.residual_freedom,
        "levels": [
            {
                "level": level.name,
                "chi2": level.fit.chi2,
                "degrees_of_freedom": level.fit.freedom,
                "likelihood_ratio_of_the_best": level.ratio,
                "residual_rms_N_m": level.fit.left,
                "of_noise_rms_N_m": level.fit.noise,
            }
            for level in comparison.levels
        ],
        "parameters_alone": [_estimate(each) for each in comparison.single],
        "parameters_together": [_estimate(each) for each in comparison.base],
        "condition_number": comparison.condition,
        "explained_by": [
            {
                "level": each.level,
                **_estimate(each.estimate),
                "possible": each.arm is not None,
            }
            for each in comparison.repairs
        ],
        "explained_by_friction": [_friction(each) for each in comparison.frictions],
        "explained_by_gravity": [
            {
                "level": each.level,
                "gravity_m_per_s2": each.gravity.value,
                "half_of_95_percent_interval": each.gravity.half_width,
                "in_the_file": each.gravity.in_file,
                "chi2_falls_by": each.better,
                "chi2_per_degree_of_freedom_left": each.left,
                "possible": each.arm is not None,
            }
            for each in comparison.gravities
        ],
        "tolerances": comparison.tolerances,
        "windows": [
            {
                "from_s": window.time[0],
                "to_s": window.time[-1],
                "stays_s": window.stays_s,
                "within_2_u_val": window.within,
                "last_E_rad": window.error[-1],
                "last_u_num_rad": window.numerical[-1],
                "last_u_input_rad": window.inputs[-1],
                "last_u_D_rad": window.data[-1],
                "last_u_val_rad": window.validation[-1],
            }
            for window in comparison.windows
        ],
    }


def _estimate(each: Estimate) -> dict[str, object]:
    return {
        "path": each.parameter.path,
        "name": each.parameter.name,
        "in_the_file": each.parameter.value,
        "estimate": each.value,
        "half_of_95_percent_interval": each.half_width,
        "standard_uncertainty": each.half_width / NORMAL,
        "chi2_falls_by": each.better,
        "chi2_per_degree_of_freedom_left": each.left,
        "holds": {parameter.path: share for parameter, share in each.holds},
    }


def _friction(each: FrictionFit) -> dict[str, object]:
    return {
        "level": each.level,
        "joints": to_json_value(
            each.joints,
            coulomb="coulomb_N_m",
            coulomb_half_width="coulomb_half_of_95_percent_interval",
            viscous="viscous_N_m_s_per_rad",
            viscous_half_width="viscous_half_of_95_percent_interval",
            in_file="viscous_in_the_file",
        ),
        "chi2_falls_by": each.better,
        "chi2_per_degree_of_freedom_left": each.left,
        "possible": each.arm is not None,
    }


def comparison_page(comparison: ComparisonOutcome) -> str:
    """The page on a comparison with a record: HTML text, figures inlined."""
    from crosscheck.report.rendering import render_page

    judged = isinstance(comparison, RecordComparison)
    return render_page(
        "measured",
        found=comparison,
        judged=judged,
        answers=messages.describe_answers(comparison),
        words=messages,
        levels=LEVELS,
        residual=_draw_residual_figure(comparison)
        if isinstance(comparison, RecordComparison)
        else "",
        runs=_draw_runs_figure(comparison) if isinstance(comparison, RecordComparison) else "",
    )


def _draw_residual_figure(comparison: RecordComparison) -> str:
    """SVG text: joints below each other; without and with the change that explains the record."""
    columns = [
        JointColumn(
            f"{messages.name_level(comparison, curve.level)} {messages.change_words(curve.change)}",
            TIME,
            partial(draw_residual, curve),
        )
        for curve in comparison.curves
    ]
    return draw_joints(_axis_names(comparison, "N m"), columns, height=HEIGHT, same_axis=True)


def _draw_runs_figure(comparison: RecordComparison) -> str:
    column = JointColumn("", TIME, partial(draw_runs, comparison))
    return draw_joints(_axis_names(comparison, "rad"), [column], height=HEIGHT, same_axis=True)


def _axis_names(comparison: RecordComparison, unit: str) -> list[str]:
    joints = comparison.record.angles.shape[1]
    return [f"joint {joint} [{unit}]" for joint in range(1, joints + 1)]


def draw_residual(curve: ResidualCurve, joint: int, axes: Axes) -> None:
    """Draw a joint's residual over the band that noise explains."""
    values, bound = curve.residual[:, joint], 2 * curve.deviation[:, joint]
    label = "2 standard deviations of noise"
    axes.fill_between(curve.time, -bound, bound, color="0.85", label=label)
    axes.plot(curve.time, values, lw=0.7, label="residual")
    top = IN_SIGHT * np.median(bound) + np.quantile(np.abs(values), 0.98)
    axes.set_ylim(-top, top)


def draw_runs(comparison: RecordComparison, joint: int, axes: Axes) -> None:
    """Draw a joint's E of every run over 2 u_val."""
    for number, window in enumerate(comparison.windows):
        bound = 2 * window.validation[:, joint]
        label = ("2 u_val", "E") if number == 0 else (None, None)
        axes.fill_between(window.time, -bound, bound, color="0.85", label=label[0])
        axes.plot(window.time, window.error[:, joint], "C1", lw=0.9, label=label[1])

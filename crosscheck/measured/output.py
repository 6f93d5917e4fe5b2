"""A comparison with a record as lines for the terminal, as JSON and as a page."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING

import numpy as np

from crosscheck import __version__
from crosscheck.measured.compare import RecordComparison
from crosscheck.measured.parameters import NORMAL, Estimate
from crosscheck.registry import LEVELS
from crosscheck.report.records import document, plain

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SCHEMA_VERSION = 1
MOST_PARAMETERS = 6  # of those alone, in the terminal
IN_SIGHT = 2.0  # medians of the noise band that a picture has room for


def first_lines(found: RecordComparison) -> Iterator[str]:
    """Lines that answer: which level, is it within noise, what the record asks for, how long."""
    best, share = found.best, found.own_chi2 / found.own_freedom
    left = f"chi squared is {_number(share)} per degree of freedom"
    if found.decided:
        next_best = min(level.ratio for level in found.levels[1:])
        nearest = f"{next_best:.2g} times" if next_best < 1e12 else "over 1e12 times"
        yield f"level: {best.name} leaves noise alone ({left}), {nearest} as likely as the next"
    elif found.explained:
        names = " and ".join(found.candidates)
        yield f"level: undecided between {names}, which all leave noise alone ({left})"
    else:
        yield f"level: none leaves noise alone as the file is; {best.name} is the nearest ({left})"
    if found.explained:
        yield "parameters: the record asks for none to change"
    for repair in found.repairs:
        yield f"explained by {repair.level} with {_told(repair.estimate)}"
    if not found.explained and not found.repairs:
        yield f"parameters: no single one explains it; nearest is {_told(found.single[0])}"
    if found.windows:
        stays = np.median([window.stays_s for window in found.windows])
        long = np.median([window.time[-1] - window.time[0] for window in found.windows])
        inside = np.mean([window.within for window in found.windows])
        yield (
            f"runs: {len(found.windows)} from the record's states stay within 3 u_val for"
            f" {stays:.3g} s of {long:.3g} s (median); |E| is at most 2 u_val at"
            f" {100 * inside:.0f} % of the rows"
        )


def lines(found: RecordComparison) -> Iterator[str]:
    """The first lines, then every level, joint and parameter."""
    yield from first_lines(found)
    yield ""
    knots = f"angles smoothed with a knot every {found.spacing_s:.3g} s"
    yield f"torques from {found.torques_from}; {knots}"
    for joint, (angle, torque) in enumerate(
        zip(found.angle_noise, found.torque_noise, strict=True), 1
    ):
        yield f"noise of joint {joint}: {angle:.2g} rad and {torque:.2g} N m a sample"
    for level in found.levels:
        left = ", ".join(f"{value:.3g}" for value in level.fit.left)
        noise = ", ".join(f"{value:.3g}" for value in level.fit.noise)
        share = level.fit.chi2 / level.fit.freedom
        yield (
            f"{level.name}: chi squared {_number(share)} per degree of freedom;"
            f" residual {left} N m rms, {noise} by noise"
        )
    for engine in found.engines:
        yield f"{engine.name}: torques as analytic to {engine.apart:.1e} at {engine.rows:,} rows"
    for each in found.single[:MOST_PARAMETERS]:
        yield f"alone: {_told(each)}"


def _told(each: Estimate) -> str:
    parameter = each.parameter
    return (
        f"{parameter.path} = {each.value:.6g} +- {each.half_width:.2g} (95 %), in the file"
        f" {parameter.value:.6g}; leaves a chi squared of {_number(each.left)} per degree of"
        " freedom"
    )


def _number(value: float) -> str:
    return f"{value:,.0f}" if 1e3 <= value < 1e7 else f"{value:.3g}"


def comparison_json(found: RecordComparison) -> str:
    """JSON text of the whole comparison, with units in the names."""
    return document(
        {
            "schema_version": SCHEMA_VERSION,
            "record": found.record.where,
            "arm": found.arm.name,
            "program": f"geararm-crosscheck {__version__}",
            "torques_from": found.torques_from,
            "rows": int(found.record.time.size),
            "knot_spacing_s": found.spacing_s,
            "angle_noise_rad": found.angle_noise,
            "torque_noise_N_m": found.torque_noise,
            "decided": found.decided,
            "explained": found.explained,
            "candidates": found.candidates,
            "own_chi2": found.own_chi2,
            "own_degrees_of_freedom": found.own_freedom,
            "levels": [
                {
                    "level": level.name,
                    "chi2": level.fit.chi2,
                    "degrees_of_freedom": level.fit.freedom,
                    "likelihood_ratio_of_the_best": level.ratio,
                    "residual_rms_N_m": level.fit.left,
                    "of_noise_rms_N_m": level.fit.noise,
                }
                for level in found.levels
            ],
            "engines": plain(found.engines, name="model", apart="relative_difference"),
            "parameters_alone": [_estimate(each) for each in found.single],
            "parameters_together": [_estimate(each) for each in found.base],
            "condition_number": found.condition,
            "explained_by": [
                {"level": each.level, **_estimate(each.estimate)} for each in found.repairs
            ],
            "tolerances": found.tolerances,
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
                for window in found.windows
            ],
        }
    )


def _estimate(each: Estimate) -> dict[str, object]:
    return {
        "path": each.parameter.path,
        "in_the_file": each.parameter.value,
        "estimate": each.value,
        "half_of_95_percent_interval": each.half_width,
        "standard_uncertainty": each.half_width / NORMAL,
        "chi2_falls_by": each.better,
        "chi2_per_degree_of_freedom_left": each.left,
        "holds": dict(each.holds),
    }


def comparison_page(found: RecordComparison) -> str:
    """The page on a comparison with a record: HTML text, figures inlined."""
    from crosscheck.report.rendering import page

    def residual(joint: int, axes: Axes) -> None:
        values, bound = found.shown.residual[:, joint], 2 * found.shown.deviation[:, joint]
        label = "2 standard deviations of noise"
        axes.fill_between(found.shown.time, -bound, bound, color="0.85", label=label)
        axes.plot(found.shown.time, values, lw=0.7, label="residual")
        top = IN_SIGHT * np.median(bound) + np.quantile(np.abs(values), 0.98)
        axes.set_ylim(-top, top)

    def runs(joint: int, axes: Axes) -> None:
        for number, window in enumerate(found.windows):
            bound = 2 * window.validation[:, joint]
            label = ("2 u_val", "E") if number == 0 else (None, None)
            axes.fill_between(window.time, -bound, bound, color="0.85", label=label[0])
            axes.plot(window.time, window.error[:, joint], "C1", lw=0.9, label=label[1])

    return page(
        "measured",
        found=found,
        answers=list(first_lines(found)),
        levels=LEVELS,
        residual=_drawing(found, residual, "N m"),
        runs=_drawing(found, runs, "rad"),
    )


def _drawing(found: RecordComparison, draw: Callable[[int, Axes], None], unit: str) -> str:
    """SVG text of a row for each joint, over time."""
    from matplotlib.figure import Figure

    from crosscheck.report.plots.figures import to_svg

    joints = found.shown.residual.shape[1]
    figure = Figure(figsize=(9, 2.2 * joints), layout="constrained")
    rows = figure.subplots(joints, 1, sharex=True, squeeze=False)[:, 0]
    for joint, axes in enumerate(rows):
        draw(joint, axes)
        axes.set_ylabel(f"joint {joint + 1} [{unit}]")
    if rows[0].get_legend_handles_labels()[0]:
        rows[0].legend(loc="upper right", fontsize="small")
    rows[-1].set_xlabel("time [s]")
    return to_svg(figure)

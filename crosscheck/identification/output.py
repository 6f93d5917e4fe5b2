"""A robot's comparison with recordings as lines for the terminal, as JSON and as a page."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from crosscheck import __version__
from crosscheck.identification import messages
from crosscheck.identification.compare import RobotComparison, SideResult
from crosscheck.identification.terms import TermEstimate
from crosscheck.recordings.engines import describe_engine
from crosscheck.report.formatting import format_count
from crosscheck.report.plots.joints import JointColumn, draw_joints
from crosscheck.report.records import format_json

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SCHEMA_VERSION = 2
FILE_FRICTION = "friction of the robot's file left out: it is estimated"


def describe_comparison(comparison: RobotComparison) -> Iterator[str]:
    """The sentences that answer, then the engines and every side's steps and estimates."""
    yield from messages.describe_answers(comparison)
    yield ""
    seconds = sum(float(each.time[-1] - each.time[0]) for each in comparison.recordings)
    rows = sum(each.rows for each in comparison.recordings)
    yield f"{format_count(len(comparison.recordings), 'recording')}, {rows:,} rows, {seconds:.4g} s"
    if comparison.robot.friction.any():
        yield FILE_FRICTION
    yield from map(describe_engine, comparison.engines)
    for side in (*comparison.sides, *comparison.gravities):
        yield ""
        yield from _describe_side(side)


def _describe_side(side: SideResult) -> Iterator[str]:
    links = {
        "identified": ", links identified",
        "scaled": ", links of the file scaled",
        "fixed": ", links of the file, another gravity",
        "none": "",
    }
    yield (
        f"{messages.SIDE_WORDS[side.side]}{links[side.links]}: up to {side.bandwidth:.3g} Hz"
        f" by rows {1e3 * side.samples.step:.3g} ms apart,"
        f" condition number {side.condition:.3g}, errors by {side.blocks} blocks"
    )
    for step in side.steps:
        yield (
            f"  {step.name}: {step.parameters} parameters leave {step.weighted:.3f},"
            f" {step.predicted:.3f} as predicted; {messages.format_row(step.rms)} N m rms"
        )
    for estimate in side.estimates:
        part = f", {estimate.systematic / estimate.error:.0%} of its error by other bands"
        yield f"  {messages.format_estimate(estimate)}{part if estimate.systematic else ''}"
    for band in side.bands:
        listed = "; ".join(messages.format_estimate(each) for each in band.estimates)
        yield f"  up to {band.bandwidth:.3g} Hz: {listed or 'nothing to estimate'}"


def comparison_json(comparison: RobotComparison) -> str:
    """JSON text of the whole comparison, with units in the names."""
    ranks = comparison.ranks
    return format_json(
        {
            "schema_version": SCHEMA_VERSION,
            "answer": messages.describe_answers(comparison),
            "robot": comparison.robot.name,
            "program": f"geararm-crosscheck {__version__}",
            "recordings": [each.where for each in comparison.recordings],
            "engines_agree": comparison.engines_agree,
            "engines": [engine.to_dict() for engine in comparison.engines],
            "ranks": {
                "links": ranks.links,
                "armature": ranks.armature,
                "coupled": ranks.coupled,
                "armature_and_coupled": ranks.both,
            },
            "decided": comparison.is_decided,
            "other_gravity_m_per_s2": None if comparison.tilt is None else comparison.tilt.value,
            "sides_with_other_gravity": [_side_content(each) for each in comparison.gravities],
            "sides": [_side_content(side) for side in comparison.sides],
        }
    )


def _side_content(side: SideResult) -> dict[str, object]:
    return {
        "torques": side.side,
        "links": side.links,
        "joints": side.measured,
        "bandwidth_hz": side.bandwidth,
        "rows_apart_s": side.samples.step,
        "condition_number": side.condition,
        "hardly_shown": side.concerned,
        "suggested_motion": _excitation_content(side),
        "with_prior_or_unknowns": _refinement_content(side),
        "not_distinguished": [[each.name for each in pair] for pair in side.alike],
        "contained_in_links": [each.name for each in side.contained],
        "blocks": side.blocks,
        "t_of_a_rotor": side.threshold,
        "steps": [
            {
                "with": step.name,
                "parameters": step.parameters,
                "weighted_rms": step.weighted,
                "weighted_rms_predicted": step.predicted,
                "rms_N_m": step.rms,
            }
            for step in side.steps
        ],
        "estimates": [_estimate_content(each) for each in side.estimates],
        "other_bandwidths": [
            {
                "bandwidth_hz": band.bandwidth,
                "estimates": [_estimate_content(each) for each in band.estimates],
            }
            for band in side.bands
        ],
    }


def _refinement_content(side: SideResult) -> dict[str, object] | None:
    if side.refinement is None:
        return None
    return {
        "links_known_to": side.refinement.knowledge.links,
        "estimated": sorted(side.refinement.knowledge.unknown),
        "links_are_possible_bodies": side.refinement.knowledge.are_possible,
        "level": side.refinement.level,
        "links_too_far_from_file": side.refinement.is_surprising,
        "levels": [
            {
                "level": fit.level,
                "chi_squared": fit.chi_squared,
                "chi_squared_of_links": fit.surprise,
                "settled": fit.settled,
                "zeros_not_told": fit.contained,
                "possible_bodies": None
                if fit.bodies is None
                else {
                    "chi_squared_above_any_links": fit.bodies.excess,
                    "explain": fit.bodies.explain,
                    "impossible_otherwise": fit.bodies.impossible,
                    "at_the_border": fit.bodies.border,
                },
                "estimates": [_estimate_content(each) for each in fit.estimates],
            }
            for fit in side.refinement.fits
        ],
    }


def _excitation_content(side: SideResult) -> dict[str, object] | None:
    if side.excitation is None:
        return None
    motion = side.excitation.motion
    return {
        "condition_number": side.excitation.condition,
        "seed": motion.seed,
        "period_s": motion.period,
        "middle": motion.middle,
        "sizes": motion.sizes,
        "phases_rad": motion.phases,
    }


def _estimate_content(each: TermEstimate) -> dict[str, object]:
    return {
        "name": each.term.name,
        "kind": each.term.kind,
        "unit": each.term.unit,
        "in_the_file": each.term.value,
        "estimate": each.value,
        "standard_error": each.error,
        "half_of_95_percent_interval": each.half_width if each.doubled is None else None,
        "estimate_in_twice_the_band": each.doubled,
        "systematic_part_of_standard_error": each.systematic,
    }


def comparison_page(comparison: RobotComparison) -> str:
    """The page on a comparison: HTML text, figures inlined."""
    from crosscheck.report.rendering import render_page

    return render_page(
        "identified",
        comparison=comparison,
        answers=messages.describe_answers(comparison),
        words=messages,
        figures=[draw_residual(side) for side in comparison.sides],
    )


def draw_residual(side: SideResult) -> str:
    """SVG text: what each joint's torque leaves against time, rate and position."""
    samples = side.samples
    places = [list(side.names).index(name) for name in side.measured]
    time = np.repeat(samples.step * np.arange(len(samples.q))[:, None], len(places), axis=1)

    def draw_against(signals: np.ndarray, row: int, axes: Axes) -> None:
        shown = side.shown[:, row]
        axes.plot(signals[shown, row], side.residual[shown, row], ".", ms=1.5, alpha=0.6)
        axes.axhline(0.0, color="0.6", lw=0.6)

    columns = [
        JointColumn("", label, partial(draw_against, signals))
        for label, signals in (
            ("time [s]", time),
            ("rate", samples.v[:, places]),
            ("position", samples.q[:, places]),
        )
    ]
    return draw_joints(side.measured, columns, height=1.7, same_axis=False)

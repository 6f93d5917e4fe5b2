"""A comparison with records as lines for the terminal, as JSON and as a page."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from crosscheck import __version__
from crosscheck.identification import messages
from crosscheck.identification.compare import RecordComparison, SideResult
from crosscheck.identification.engines import describe_engines
from crosscheck.identification.forward import Window
from crosscheck.identification.restrictions import FileJudgement, Restriction
from crosscheck.identification.terms import TermEstimate
from crosscheck.report.formatting import format_count
from crosscheck.report.plots.joints import JointColumn, draw_joints
from crosscheck.report.records import format_json

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SCHEMA_VERSION = 4


def describe_comparison(comparison: RecordComparison) -> Iterator[str]:
    """The sentences that answer, then the engines and every side's steps and estimates."""
    first, *further = messages.describe_answers(comparison)
    yield f"{comparison.mechanism.noun.capitalize()} {comparison.mechanism.name}: {first}"
    yield from further
    yield ""
    records = comparison.records
    yield from dict.fromkeys(note for each in records for note in each.notes)
    seconds = sum(float(each.time[-1] - each.time[0]) for each in records)
    rows = sum(len(each.time) for each in records)
    yield f"{format_count(len(records), 'recording')}, {rows:,} rows, {seconds:.4g} s"
    yield from describe_engines(comparison.engines)
    is_brief = comparison.has_explanation
    unit = "N m or N" if comparison.mechanism.robot.slides else "N m"
    for side in _select_sides(comparison):
        yield ""
        yield from _describe_side(side, is_brief, unit)


def _select_sides(comparison: RecordComparison) -> tuple[SideResult, ...]:
    """Sides to show: without those of scaled links where the file or one change explains all.

    None where units are in doubt, which all numbers of a side come from.
    """
    if messages.suspect_units(comparison):
        return ()
    return comparison.judged_sides if comparison.has_explanation else comparison.sides


def _describe_side(side: SideResult, is_brief: bool, unit: str) -> Iterator[str]:
    """The bandwidth, steps and estimates of a side; unit: of its torques."""
    links = {
        "identified": ", links identified",
        "scaled": ", links of the file scaled",
        "fixed": ", links of the file, another gravity",
        "none": "",
    }
    yield (
        f"{messages.SIDE_PHRASES[side.side]}{links[side.links]}: frequencies up to"
        f" {side.bandwidth:.3g} Hz, a row every {1e3 * side.samples.step:.3g} ms,"
        f" condition number {side.fit.condition:.3g}, ± is 95 % from {side.fit.blocks} blocks"
    )
    if side.judgement is not None:
        for each in (*side.judgement.levels, *side.judgement.changes):
            number = "" if each.estimate is None else messages.format_estimate(each.estimate)
            head = f"  {each.level}, {number or 'the file'}"
            ratios = messages.format_row(side.measured, each.ratios)
            yield f"{head}; residual relative to that of freely fitted links: {ratios}"
        if is_brief:
            yield from (
                f"  {messages.format_estimate(each)}" for each in side.judgement.best.friction
            )
            return
    for step in side.steps:
        yield (
            f"  {step.name}: {step.parameters} parameters, residual {step.weighted:.3f},"
            f" {step.predicted:.3f} predicted; rms {messages.format_row(side.measured, step.rms)}"
            f" [{unit}]"
        )
    for estimate in side.estimates:
        part = f", {estimate.systematic / estimate.error:.0%} of its error from other bands"
        yield f"  {messages.format_estimate(estimate)}{part if estimate.systematic else ''}"
    for band in side.bands:
        listed = "; ".join(messages.format_estimate(each) for each in band.estimates)
        yield f"  up to {band.bandwidth:.3g} Hz: {listed or 'nothing to estimate'}"


def comparison_json(comparison: RecordComparison) -> str:
    """JSON text of the whole comparison, with units in the names."""
    ranks, tilt = comparison.ranks, comparison.tilt
    return format_json(
        {
            "schema_version": SCHEMA_VERSION,
            "answer": messages.describe_answers(comparison),
            "mechanism": comparison.mechanism.name,
            "program": f"geararm-crosscheck {__version__}",
            "records": [each.where for each in comparison.records],
            "notes": [note for each in comparison.records for note in each.notes],
            "engines_agree": comparison.engines_agree,
            "engines": [engine.to_dict() for engine in comparison.engines],
            "explained": comparison.is_explained,
            "decided": comparison.is_decided,
            "ranks": {
                "links": ranks.links,
                "armature": ranks.armature,
                "coupled": ranks.coupled,
                "armature_and_coupled": ranks.both,
            },
            "other_gravity_m_per_s2": None if tilt is None else tilt.value,
            "sides_with_other_gravity": [_side_content(each) for each in comparison.gravities],
            "sides": [_side_content(side) for side in comparison.sides],
            "tolerances": comparison.tolerances,
            "windows": [
                {
                    "from_s": window.time[0],
                    "to_s": window.time[-1],
                    "stays_s": window.stays_s,
                    "within_2_u_val": window.within,
                    "last_E": window.error[-1],
                    "last_u_num": window.numerical[-1],
                    "last_u_input": window.inputs[-1],
                    "last_u_D": window.data[-1],
                    "last_u_val": window.validation[-1],
                }
                for window in comparison.windows
            ],
        }
    )


def _judgement_content(judgement: FileJudgement | None) -> dict[str, object] | None:
    if judgement is None:
        return None
    return {
        "explained": judgement.explained,
        "levels": [_restriction_content(each, judgement) for each in judgement.levels],
        "single_numbers": [_restriction_content(each, judgement) for each in judgement.changes],
    }


def _restriction_content(each: Restriction, judgement: FileJudgement) -> dict[str, object]:
    return {
        "level": each.level,
        "path": None if each.parameter is None else each.parameter.path,
        "number": None if each.estimate is None else _estimate_content(each.estimate),
        "possible": each.mechanism is not None,
        "friction": [_estimate_content(estimate) for estimate in each.friction],
        "rms_over_that_of_any_links": each.ratios,
        "chance": each.chance,
        "likelihood_ratio_of_the_best": judgement.compare(each, judgement.likeliest),
    }


def _side_content(side: SideResult) -> dict[str, object]:
    return {
        "torques": side.side,
        "links": side.links,
        "joints": side.measured,
        "bandwidth_hz": side.bandwidth,
        "rows_apart_s": side.samples.step,
        "condition_number": side.fit.condition,
        "hardly_shown": side.concerned,
        "suggested_motion": _excitation_content(side),
        "with_prior_or_unknowns": _refinement_content(side),
        "not_distinguished": [[each.name for each in pair] for pair in side.alike],
        "contained_in_links": [each.name for each in side.contained],
        "with_the_files_numbers": _judgement_content(side.judgement),
        "unexplained": side.unexplained,
        "blocks": side.fit.blocks,
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
                "zeros_not_distinguished": fit.contained,
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
        "is_determined": each.is_determined,
        "systematic_part_of_standard_error": each.systematic,
    }


def comparison_page(comparison: RecordComparison) -> str:
    """The page on a comparison: HTML text, figures inlined."""
    from crosscheck.report.rendering import render_page

    sides = _select_sides(comparison)
    windows = comparison.windows if sides else ()
    return render_page(
        "compared",
        comparison=comparison,
        windows=windows,
        sides=sides,
        answers=messages.describe_answers(comparison),
        words=messages,
        ratios=_draw_ratios(comparison) if sides else "",
        figures=[draw_residual(side, comparison.mechanism.robot.joint_units) for side in sides],
        runs=_draw_runs_figure(comparison) if windows else "",
    )


def _draw_ratios(comparison: RecordComparison) -> str:
    """SVG text: the first judged side's residuals over those of any links; empty if none is."""
    from crosscheck.report.plots.dots import draw_dots
    from crosscheck.report.plots.figures import to_svg

    for side, judgement in zip(comparison.judged_sides[:1], comparison.judgements, strict=False):
        rows = (*judgement.levels, *judgement.changes)
        names = [
            each.level + (f", {each.parameter.phrase} changed" if each.parameter else "")
            for each in rows
        ]
        by_joint = zip(*(each.ratios for each in rows), strict=True)
        series = dict(zip(side.measured, by_joint, strict=True))
        colours = [f"C{number}" for number in range(len(series))]
        return to_svg(draw_dots(names, series, colours, "residual [times that of free links]"))
    return ""


def _draw_runs_figure(comparison: RecordComparison) -> str:
    robot = comparison.mechanism.robot
    names = [f"{name} [{robot.joint_units[name]}]" for name in robot.coordinate_names]
    column = JointColumn("", "time [s]", partial(draw_runs, comparison.windows))
    return draw_joints(names, [column], height=2.2, same_axis=True)


def draw_runs(windows: Sequence[Window], joint: int, axes: Axes) -> None:
    """Draw a joint's E of every run over 2 u_val."""
    for number, window in enumerate(windows):
        bound = 2 * window.validation[:, joint]
        label = ("2 u_val", "E") if number == 0 else (None, None)
        axes.fill_between(window.time, -bound, bound, color="0.85", label=label[0])
        axes.plot(window.time, window.error[:, joint], "C1", lw=0.9, label=label[1])


def draw_residual(side: SideResult, units: Mapping[str, str]) -> str:
    """SVG text: what each joint's torque leaves against time, rate and position.

    units: of the joints' coordinates by name.
    """
    samples = side.samples
    places = [list(side.names).index(name) for name in side.measured]
    time = np.repeat(samples.step * np.arange(len(samples.q))[:, None], len(places), axis=1)

    def draw_against(signals: np.ndarray, row: int, axes: Axes) -> None:
        shown = side.fit.shown[:, row]
        axes.plot(signals[shown, row], side.fit.residual[shown, row], ".", ms=3, alpha=0.7)
        axes.axhline(0.0, color="0.6", lw=0.6)

    there = sorted({units[name] for name in side.measured}, reverse=True)
    of_rates = " or ".join(f"{unit}/s" for unit in there)
    columns = [
        JointColumn("", label, partial(draw_against, signals))
        for label, signals in (
            ("time [s]", time),
            (f"rate [{of_rates}]", samples.v[:, places]),
            (f"position [{' or '.join(there)}]", samples.q[:, places]),
        )
    ]
    names = [f"{name} [{'N' if units[name] == 'm' else 'N m'}]" for name in side.measured]
    return draw_joints(names, columns, height=1.7, same_axis=False)

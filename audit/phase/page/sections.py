"""The sections of the chapter on the phase: what was computed, put into words, tables, drawings.

Each is made from the simulated settings of all laws and what the chapters work from.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np

from crosscheck.audit.claims.rule import State
from crosscheck.audit.experiments.paper_conditions import INTEGRAL, LABELLED, PRINTED, REPAIRED_RATE
from crosscheck.audit.experiments.torque import RING_CYCLES
from crosscheck.audit.measures import events, stage, thresholds, twosamples
from crosscheck.audit.measures.undefined import JsonObject, extreme_value, float_or_none, quotient
from crosscheck.audit.page.context import AuditContext
from crosscheck.audit.page.text import render_template
from crosscheck.audit.phase import (
    clock,
    dampers,
    engines,
    handover,
    objections,
    resonance,
    stability,
)
from crosscheck.audit.phase.maps import PHASES, MapPoint, Maps, Presence
from crosscheck.audit.phase.page import drawings, tables
from crosscheck.audit.phase.runs import HIGH_PASS_HZ
from crosscheck.models.loading import load_arm

PRESENT = (State.YES, State.BISTABLE)
CALM_ZETA = 0.015  # well above the damping at which the controller makes the arm unstable


class Section(NamedTuple):
    """A section on some evidence: text, records, whether it speaks for H1; None: undefined."""

    html: str
    records: Sequence[JsonObject]
    supports: bool | None


def build_clock_section(_: Maps, context: AuditContext) -> Section:
    """The section on the clock test."""
    result = clock.run_clock_test(context.study, context.scale)
    by_law = {item.law: item for item in result.laws}
    rows = [tables.ClockRow(item.law, delay) for item in result.laws for delay in item.delays]
    html = render_template(
        "phase/clock",
        clock=clock,
        found=result,
        starts=context.scale.limit_starts(clock.RUN_STARTS),
        table=tables.CLOCK.html(rows),
        drawing=drawings.draw_clock_test(result),
        printed=by_law[PRINTED],
        repaired=by_law[REPAIRED_RATE],
        integral=by_law[INTEGRAL],
        integral_same=all(item.same for item in by_law[INTEGRAL].delays),
        vibrations=[[tables.vibrations(item) for item in law.delays] for law in result.laws],
    )
    return Section(html, tables.CLOCK.json(rows), result.supports)


def build_maps_section(maps: Maps, context: AuditContext) -> Section:
    """The section on the maps over damping, tooth error, backlash, readings and laws."""
    plain = [point for point in maps.settings if point.setting.is_paper]
    sizes = [float(size) for point in maps.select("angle") for size in point.third.sizes]
    html = render_template(
        "phase/maps",
        starts=context.scale.most_starts,
        drawings=[]
        if context.scale.quick
        else [drawings.draw_error_map(maps), drawings.draw_backlash_map(maps)],
        table=tables.MAPPED.html(plain),
        counts=_count_settings(maps),
        by_law=_summarize_laws(plain),
        lumped_by_law=_summarize_laws(maps.lumped),
        undecided=[
            (planets, sum(s.third.state == State.BISTABLE for s in settings), len(settings))
            for planets, settings in (("free", plain), ("lumped", maps.lumped))
            if settings
        ],
        State=State,
        under_angle=(sum(size > thresholds.SEVERE for size in sizes), len(sizes)),
        maps=maps,
    )
    is_decided = maps.visible != Presence.UNKNOWN
    supports = maps.visible == Presence.PRINTED if is_decided else None
    return Section(html, tables.MAPPED.json([*maps.settings, *maps.lumped]), supports)


def _count_settings(maps: Maps) -> dict[str, object]:
    """How many settings let the tooth error make a fluctuation, by level and phase law."""
    points_by_phase = {phase: maps.select(phase) for phase in PHASES}
    return {
        "settings": {phase: len(some) for phase, some in points_by_phase.items()},
        "visible": {
            phase: sum(point.made_visible.state in PRESENT for point in some)
            for phase, some in points_by_phase.items()
        },
        "severe": {
            phase: sum(point.made.state in PRESENT for point in some)
            for phase, some in points_by_phase.items()
        },
        "silent": sum(point.made_visible.share is None for point in maps.settings),
    }


class LawSummary(NamedTuple):
    """A law's settings at Table I's error and backlash: their states, and each branch's sizes.

    zetas: damping ratios at which a reading is severe in nine starts of ten or more; small, severe:
    smallest and largest median of that branch alone [rad/s^2].
    """

    name: str
    states: Counter[State]
    zetas: list[float]
    small: tuple[float, float] | None
    severe: tuple[float, float] | None


def _summarize_laws(plain: Sequence[MapPoint]) -> list[LawSummary]:
    """The laws' settings, in the order of the laws."""
    summaries = []
    for law in dict.fromkeys(point.setting.cell.law for point in plain):
        law_points = [point for point in plain if point.setting.cell.law == law]
        states = Counter(point.third.state for point in law_points)
        zetas = sorted({x.setting.cell.zeta for x in law_points if x.third.state == State.YES})
        medians = (
            [point.third.branch(severe).size for point in law_points] for severe in (False, True)
        )
        defined_medians = ([size for size in some if size is not None] for some in medians)
        ranges = ((min(some), max(some)) if some else None for some in defined_medians)
        summaries.append(LawSummary(drawings.law_name(law), states, zetas, *ranges))
    return summaries


def build_engines_section(_: Maps, context: AuditContext) -> Section:
    """The section on the third fluctuation in another engine."""
    result = engines.compare_engines(context)
    samples = [
        tables.ModelRow(comparison.cell, name, third, parted)
        for comparison in result.compared
        for name, third, parted in zip(
            ("analytic", "Exudyn"),
            (comparison.analytic, comparison.engine),
            comparison.parted,
            strict=True,
        )
    ]
    branches = [
        tables.SettingRow(comparison.cell, each)
        for comparison in result.compared
        for each in comparison.branches
    ]
    judged = [row for row in branches if row.value.interval is not None]
    quiet = [
        comparison.engine.sizes.max()
        for comparison in result.under_angle
        if comparison.engine.sizes.size
    ]
    html = render_template(
        "phase/engines",
        samples=tables.MODEL_SAMPLES.html(samples),
        found=result,
        adjusted=result.adjusted_p,
        engines=engines,
        limit=twosamples.SIGNIFICANT,
        branches=tables.BRANCHES.html(branches),
        met=sum(row.value.met is True for row in judged),
        decided=len(judged),
        missed=[row for row in judged if row.value.met is False],
        few=len(branches) - len(judged),
        fewest=engines.FEWEST,
        quiet=max(map(float, quiet), default=None),
    )
    records = [
        *tables.MODEL_SAMPLES.json(samples),
        *tables.BRANCHES.json(branches),
        *tables.TESTS.json(result.compared),
    ]
    return Section(html, records, result.supports)


def build_stability_section(_: Maps, context: AuditContext) -> Section:
    """The section on the stability of the mesh modes along the motion."""
    result = stability.run_stability_test(context.study, context.scale)
    rows = [tables.SettingRow(cell, linearised) for cell, linearised in result.cells.items()]
    intervals = [tables.SettingRow(row.cell, each) for row in rows for each in row.value.intervals]
    html = render_template(
        "phase/stability",
        gain=RING_CYCLES * events.THIRD_S[1],
        starts=context.scale.limit_starts(stability.STARTS),
        stability=stability,
        band=HIGH_PASS_HZ,
        error=max(linearised.jacobian_error for linearised in result.cells.values()),
        table=tables.LINEARISED.html(rows),
        intervals=tables.INTERVAL.html(intervals),
        drawing=drawings.draw_stability(result),
        found=result,
    )
    return Section(html, tables.LINEARISED.json(rows), result.supports)


def build_handover_section(_: Maps, context: AuditContext) -> Section:
    """The section on the vibration continued under another law."""
    result = handover.run_handover(context.study, context.scale)
    living = [
        f"ζ = {fate.cell.zeta:g}, {fate.cell.law.id}"
        for fate in result.select_law(handover.INTEGRATED).values()
        if fate.dying is not None and fate.dying.yes < fate.dying.of
    ]
    html = render_template(
        "phase/handover",
        table=tables.FATE.html(result.outcomes),
        drawing=drawings.draw_handover(result.shown) if result.shown.drawn else "",
        shown=handover.SHOWN,
        living=living,
        supports=result.supports,
    )
    return Section(html, tables.FATE.json(result.outcomes), result.supports)


def build_resonance_section(_: Maps, context: AuditContext) -> Section:
    """The section on where tooth error would resonate under `angle`."""
    result = resonance.run_resonance_test(context.study, context.scale)
    met = enumerate(zip(result.modes.modes_Hz, result.modes.speeds, strict=True))
    modes = [
        tables.Mode(
            mode,
            speed,
            speed / result.speeds.pd,
            {zeta: ramp.peaks[0][place] for zeta, ramp in result.run_ups.items()},
        )
        for place, (mode, speed) in met
    ]
    columns, growth = tables.mode_columns(tuple(result.run_ups)), list(result.tongues.items())
    html = render_template(
        "phase/resonance",
        digits=_common_digits(result),
        modes=columns.html(modes),
        tongues=tables.TONGUE.html(growth),
        drawing=drawings.draw_resonance(result),
        found=result,
        far=resonance.FAR,
    )
    return Section(html, [*columns.json(modes), *tables.TONGUE.json(growth)], result.supports)


def _common_digits(result: resonance.Resonance) -> int:
    """The number of digits to which all starts of a run-up have the same peaks; 15 at most."""
    sizes = [
        np.array([peak.size for peak in peaks])
        for ramp in result.run_ups.values()
        for peaks in zip(*ramp.peaks, strict=True)
        if all(peak.size is not None for peak in peaks)
    ]
    spread = max((float(np.ptp(each) / each.mean()) for each in sizes), default=0.0)
    return int(-np.log10(max(spread, 1e-15)))


def build_dampers_section(_: Maps, context: AuditContext) -> Section:
    """The section on what vibrates without any tooth error: told, and no evidence."""
    result = dampers.run_damper_tests(context.study, context.scale)
    ran = dampers.find_runaways(context.study, context.scale)
    contact_result = next(
        ablation for ablation in result.ablated if ablation.ablation == dampers.AS_IT_STANDS
    )
    html = render_template(
        "phase/dampers",
        starts=context.scale.most_starts,
        dampers=dampers,
        found=result,
        ablated=tables.ABLATED.html(result.ablated),
        fluttering=tables.ABLATED.html(result.fluttering),
        flutter=[ablation.third.quantiles[1] for ablation in result.fluttering],
        over_zeta=tables.ABLATED.html(result.over_zeta),
        own=contact_result.third.quantiles,
        runaways=tables.RUNAWAY.html(ran),
    )
    every = (*result.over_zeta, *result.ablated, *result.fluttering)
    rows = {(ablation.ablation.name, ablation.zeta): ablation for ablation in every}
    return Section(
        html, [*tables.ABLATED.json(rows.values()), *tables.RUNAWAY.json(ran)], supports=None
    )


def build_repair_section(simulated: Maps, _: AuditContext) -> Section:
    """The section on whether the repair stands if the springs' own work is counted."""
    repairs = simulated.repairs
    calm = [item for item in repairs if item.plain.setting.cell.zeta >= CALM_ZETA]
    thirds = [item.plain.third for item in calm], [item.conservative.third for item in calm]
    sizes = [
        float_or_none(extreme_value((item.quantiles[1] for item in some), max)) for some in thirds
    ]
    visible = sum(item.conservative.made_visible.state in PRESENT for item in repairs)
    silent = all(item.conservative.made_visible.share is None for item in repairs)
    severe = sum(
        bool((item.conservative.third.sizes > thresholds.SEVERE).any()) for item in repairs
    )
    stands = None if silent else not visible
    html = render_template(
        "phase/repair",
        stands=None if stands is None else stands and not severe,
        table=tables.REPAIR.html(repairs),
        calm=sizes,
        calm_zeta=CALM_ZETA,
        factor=None if not sizes[1] else float(f"{thresholds.SEVERE / sizes[1]:.1g}"),
        severe_settings=severe,
        visible_settings=visible,
        settings=len(repairs),
    )
    return Section(html, tables.REPAIR.json(repairs), stands)


def build_objections_section(simulated: Maps, context: AuditContext) -> Section:
    """The section on what a referee would object."""
    result = objections.run_objections(context.study, context.scale)
    rates = [tables.SettingRow(cell, entry) for cell, entry in result.rates.items()]
    growth_ratios = [
        quotient(entry.eq11_in_full_per_s, entry.as_it_stands_per_s)
        for entry in result.rates.values()
    ]
    joint = stage.paper_stage(load_arm(LABELLED)).joint
    teeth, planets = (joint.sun_teeth, joint.ring_teeth), joint.planet_count

    def format_raised_shares(objection: str, phase: str, level: str = "made") -> str:
        """The shares of starts raised by the error, with an objection's changes, in words."""
        chosen: Iterable[objections.ObjectionResult] = (
            entry
            for entry in result.results
            if (entry.objection, entry.cell.law.phase) == (objection, phase)
        )
        shares = [getattr(entry, level).share for entry in chosen]
        share_texts = ["undefined" if entry is None else str(entry) for entry in shares]
        return ", ".join(share_texts) + " starts"

    html = render_template(
        "phase/objections",
        starts=context.scale.most_starts,
        table=tables.OBJECTED.html(result.results),
        rates=tables.RATES.html(rates, "Largest growth rates, 0.5 to 1.2 s [1/s]"),
        spacing=" and ".join(f"{z} / {planets} = {z / planets:g}" for z in teeth),
        d_unknown=format_raised_shares(objections.D_UNKNOWN, "omega_t"),
        d_unknown_angle=format_raised_shares(objections.D_UNKNOWN, "angle"),
        flutter=format_raised_shares(objections.FLUTTER, "omega_t"),
        flutter_angle=format_raised_shares(objections.FLUTTER, "angle"),
        planets=format_raised_shares(objections.PLANETS, "omega_t"),
        planets_angle=format_raised_shares(objections.PLANETS, "angle"),
        in_phase=all(z % planets == 0 for z in teeth),
        growth=[entry.value for entry in rates],
        in_full_over_own=(extreme_value(growth_ratios, min), extreme_value(growth_ratios, max)),
        full_equation=result.full_equation,
        eq11=format_raised_shares(objections.FULL, "omega_t"),
        eq11_visible=format_raised_shares(objections.FULL, "omega_t", "made_visible"),
        eq11_angle=format_raised_shares(objections.FULL, "angle", "made_visible"),
        counts=_count_settings(simulated),
    )
    records = [*tables.OBJECTED.json(result.results), *tables.RATES.json(rates)]
    return Section(html, records, result.supports)

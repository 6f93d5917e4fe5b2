"""The sections of the chapter on the phase: what was computed, put into words, tables, drawings.

Each is made from the simulated settings of all laws and what the chapters work from.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np

from crosscheck.audit.claims.rule import State
from crosscheck.audit.experiments.cells import INTEGRAL, LABELLED, PRINTED, REPAIRED_RATE
from crosscheck.audit.experiments.torque import RING_CYCLES
from crosscheck.audit.measures import events, stage, thresholds, twosamples
from crosscheck.audit.measures.shares import Share
from crosscheck.audit.measures.undefined import JsonObject, defined, extreme, quotient
from crosscheck.audit.page.material import Material
from crosscheck.audit.page.text import text
from crosscheck.audit.phase import (
    clock,
    dampers,
    engines,
    handover,
    objections,
    resonance,
    stability,
)
from crosscheck.audit.phase.maps import PHASES, Mapped, Maps, Presence
from crosscheck.audit.phase.page import tables, views
from crosscheck.audit.phase.runs import HIGH_PASS_HZ
from crosscheck.models.loading import load_arm

PRESENT = (State.YES, State.BISTABLE)
CALM_ZETA = 0.015  # well above the damping at which the controller makes the arm unstable


class Section(NamedTuple):
    """A section on some evidence: text, records, whether it speaks for H1; None: undefined."""

    html: str
    records: Sequence[JsonObject]
    supports: bool | None


def of_clock(_: Maps, material: Material) -> Section:
    """The section on the clock test."""
    found = clock.clocks(material.study, material.scale)
    by_law = {one.law: one for one in found.laws}
    rows = [tables.OfClock(one.law, delay) for one in found.laws for delay in one.delays]
    said = text(
        "phase/clock",
        clock=clock,
        found=found,
        starts=material.scale.starts(clock.RUN_STARTS),
        table=tables.CLOCK.html(rows),
        drawing=views.clock(found),
        printed=by_law[PRINTED],
        repaired=by_law[REPAIRED_RATE],
        integral=by_law[INTEGRAL],
        integral_same=all(one.same for one in by_law[INTEGRAL].delays),
        vibrations=[[tables.vibrations(one) for one in law.delays] for law in found.laws],
    )
    return Section(said, tables.CLOCK.json(rows), found.supports)


def of_maps(found: Maps, material: Material) -> Section:
    """The section on the maps over damping, tooth error, backlash, readings and laws."""
    plain = [one for one in found.settings if one.setting.is_paper]
    sizes = [float(size) for one in found.of("angle") for size in one.third.sizes]
    said = text(
        "phase/maps",
        starts=material.scale.most_starts,
        drawings=[]
        if material.scale.quick
        else [views.error_map(found), views.backlash_map(found)],
        table=tables.MAPPED.html(plain),
        counts=_counts(found),
        by_law=_by_law(plain),
        lumped_by_law=_by_law(found.lumped),
        undecided=[
            (planets, sum(s.third.state == State.BISTABLE for s in settings), len(settings))
            for planets, settings in (("free", plain), ("lumped", found.lumped))
            if settings
        ],
        State=State,
        pooled=Share(sum(size > thresholds.SEVERE for size in sizes), max(1, len(sizes))),
        maps=found,
    )
    known = found.visible != Presence.UNKNOWN
    supports = found.visible == Presence.PRINTED if known else None
    return Section(said, tables.MAPPED.json([*found.settings, *found.lumped]), supports)


def _counts(found: Maps) -> dict[str, object]:
    """How many settings let the tooth error make a fluctuation, by level and phase law."""
    own = {phase: found.of(phase) for phase in PHASES}
    return {
        "settings": {phase: len(some) for phase, some in own.items()},
        "visible": {
            phase: sum(one.made_visible.state in PRESENT for one in some)
            for phase, some in own.items()
        },
        "severe": {
            phase: sum(one.made.state in PRESENT for one in some) for phase, some in own.items()
        },
        "silent": sum(one.made_visible.share is None for one in found.settings),
    }


class OfLaw(NamedTuple):
    """A law's settings at Table I's error and backlash: their states, and each branch's sizes.

    zetas: damping ratios at which a reading is severe in nine starts of ten or more; small, severe:
    smallest and largest median of that branch alone [rad/s^2].
    """

    name: str
    states: Counter[State]
    zetas: list[float]
    small: tuple[float, float] | None
    severe: tuple[float, float] | None


def _by_law(plain: Sequence[Mapped]) -> list[OfLaw]:
    """The laws' settings, in the order of the laws."""
    found = []
    for law in dict.fromkeys(one.setting.cell.law for one in plain):
        own = [one for one in plain if one.setting.cell.law == law]
        states = Counter(one.third.state for one in own)
        zetas = sorted({x.setting.cell.zeta for x in own if x.third.state == State.YES})
        medians = ([one.third.branch(severe).size for one in own] for severe in (False, True))
        known = ([size for size in some if size is not None] for some in medians)
        ranges = ((min(some), max(some)) if some else None for some in known)
        found.append(OfLaw(views.law_name(law), states, zetas, *ranges))
    return found


def of_engines(_: Maps, material: Material) -> Section:
    """The section on the third fluctuation in another engine."""
    found = engines.engines(material)
    samples = [
        tables.OfModel(one.cell, name, third, parted)
        for one in found.compared
        for name, third, parted in zip(
            ("analytic", "Exudyn"), (one.analytic, one.engine), one.parted, strict=True
        )
    ]
    branches = [tables.Found(one.cell, each) for one in found.compared for each in one.apart]
    judged = [one for one in branches if one.value.met is not None]
    missed = [one for one in judged if not one.value.met]
    parted_p = [twosamples.shares_p(*one.parted) for one in found.compared]
    quiet = [one.engine.sizes.max() for one in found.under_angle if one.engine.sizes.size]
    said = text(
        "phase/engines",
        samples=tables.OF_MODEL.html(samples),
        found=found,
        parted_p=parted_p,
        parting_differs=any(p < twosamples.SIGNIFICANT for p in parted_p),
        limit=twosamples.SIGNIFICANT,
        branches=tables.APART.html(branches),
        met=len(judged) - len(missed),
        decided=len(judged),
        open=len(branches) - len(judged),
        missed=missed,
        fewest=engines.FEWEST,
        quiet=max(map(float, quiet), default=None),
    )
    records = [
        *tables.OF_MODEL.json(samples),
        *tables.APART.json(branches),
        *tables.TESTS.json(found.compared),
    ]
    return Section(said, records, found.supports)


def of_stability(_: Maps, material: Material) -> Section:
    """The section on the stability of the mesh modes along the motion."""
    found = stability.stability(material.study, material.scale)
    rows = [tables.Found(cell, one) for cell, one in found.cells.items()]
    intervals = [tables.Found(row.cell, each) for row in rows for each in row.value.intervals]
    said = text(
        "phase/stability",
        gain=RING_CYCLES * events.THIRD_S[1],
        starts=material.scale.starts(stability.STARTS),
        stability=stability,
        band=HIGH_PASS_HZ,
        error=max(one.jacobian_error for one in found.cells.values()),
        table=tables.LINEARISED.html(rows),
        intervals=tables.INTERVAL.html(intervals),
        drawing=views.stability(found),
        found=found,
    )
    return Section(said, tables.LINEARISED.json(rows), found.supports)


def of_handover(_: Maps, material: Material) -> Section:
    """The section on the vibration continued under another law."""
    found = handover.handover(material.study, material.scale)
    living = [
        f"ζ = {fate.cell.zeta:g}, {fate.cell.law.id}"
        for fate in found.under(handover.INTEGRATED).values()
        if fate.dying is not None and fate.dying.yes < fate.dying.of
    ]
    said = text(
        "phase/handover",
        table=tables.FATE.html(found.fates),
        drawing=views.handed_over(found.shown) if found.shown.drawn else "",
        shown=handover.SHOWN,
        living=living,
        supports=found.supports,
    )
    return Section(said, tables.FATE.json(found.fates), found.supports)


def of_resonance(_: Maps, material: Material) -> Section:
    """The section on where tooth error would resonate under `angle`."""
    found = resonance.resonance(material.study, material.scale)
    met = enumerate(zip(found.modes.modes_Hz, found.modes.speeds, strict=True))
    modes = [
        tables.Mode(
            mode,
            speed,
            speed / found.speeds.pd,
            {zeta: ramp.peaks[0][place] for zeta, ramp in found.run_ups.items()},
        )
        for place, (mode, speed) in met
    ]
    columns, growth = tables.modes(tuple(found.run_ups)), list(found.tongues.items())
    said = text(
        "phase/resonance",
        digits=_digits(found),
        modes=columns.html(modes),
        tongues=tables.TONGUE.html(growth),
        drawing=views.resonance(found),
        found=found,
        far=resonance.FAR,
    )
    return Section(said, [*columns.json(modes), *tables.TONGUE.json(growth)], found.supports)


def _digits(found: resonance.Resonance) -> int:
    """The number of digits to which all starts of a run-up have the same peaks; 15 at most."""
    sizes = [
        np.array([peak.size for peak in peaks])
        for ramp in found.run_ups.values()
        for peaks in zip(*ramp.peaks, strict=True)
        if all(peak.size is not None for peak in peaks)
    ]
    spread = max((float(np.ptp(each) / each.mean()) for each in sizes), default=0.0)
    return int(-np.log10(max(spread, 1e-15)))


def of_dampers(_: Maps, material: Material) -> Section:
    """The section on what vibrates without any tooth error: told, and no evidence."""
    found = dampers.dampers(material.study, material.scale)
    ran = dampers.runaways(material.study, material.scale)
    own = next(one for one in found.ablated if one.ablation == dampers.AS_IT_STANDS)
    said = text(
        "phase/dampers",
        starts=material.scale.most_starts,
        dampers=dampers,
        found=found,
        ablated=tables.ABLATED.html(found.ablated),
        fluttering=tables.ABLATED.html(found.fluttering),
        flutter=[one.third.quantiles[1] for one in found.fluttering],
        over_zeta=tables.ABLATED.html(found.over_zeta),
        own=own.third.quantiles,
        runaways=tables.RUNAWAY.html(ran),
    )
    every = (*found.over_zeta, *found.ablated, *found.fluttering)
    rows = {(one.ablation.name, one.zeta): one for one in every}
    return Section(
        said, [*tables.ABLATED.json(rows.values()), *tables.RUNAWAY.json(ran)], supports=None
    )


def of_repair(simulated: Maps, _: Material) -> Section:
    """The section on whether the repair stands if the springs' own work is counted."""
    found = simulated.repairs
    calm = [one for one in found if one.plain.setting.cell.zeta >= CALM_ZETA]
    thirds = [one.plain.third for one in calm], [one.conservative.third for one in calm]
    sizes = [defined(extreme((one.quantiles[1] for one in some), max)) for some in thirds]
    visible = sum(one.conservative.made_visible.state in PRESENT for one in found)
    silent = all(one.conservative.made_visible.share is None for one in found)
    severe = sum(bool((one.conservative.third.sizes > thresholds.SEVERE).any()) for one in found)
    stands = None if silent else not visible
    said = text(
        "phase/repair",
        stands=None if stands is None else stands and not severe,
        table=tables.REPAIR.html(found),
        calm=sizes,
        calm_zeta=CALM_ZETA,
        factor=None if not sizes[1] else float(f"{thresholds.SEVERE / sizes[1]:.1g}"),
        severe_settings=severe,
        visible_settings=visible,
        settings=len(found),
    )
    return Section(said, tables.REPAIR.json(found), stands)


def of_objections(simulated: Maps, material: Material) -> Section:
    """The section on what a referee would object."""
    found = objections.objections(material.study, material.scale)
    rates = [tables.Found(cell, one) for cell, one in found.rates.items()]
    over_own = [
        quotient(one.eq11_in_full_per_s, one.as_it_stands_per_s) for one in found.rates.values()
    ]
    joint = stage.paper_stage(load_arm(LABELLED)).joint
    teeth, planets = (joint.sun_teeth, joint.ring_teeth), joint.planet_count

    def made(objection: str, phase: str, level: str = "made") -> str:
        """The shares of starts raised by the error, with an objection's changes, in words."""
        chosen: Iterable[objections.Objected] = (
            one
            for one in found.objected
            if (one.objection, one.cell.law.phase) == (objection, phase)
        )
        shares = [getattr(one, level).share for one in chosen]
        told = ["undefined" if one is None else str(one) for one in shares]
        return ", ".join(told) + " starts"

    said = text(
        "phase/objections",
        starts=material.scale.most_starts,
        table=tables.OBJECTED.html(found.objected),
        rates=tables.RATES.html(rates, "Largest growth rates, 0.5 to 1.2 s [1/s]"),
        spacing=" and ".join(f"{z} / {planets} = {z / planets:g}" for z in teeth),
        d_unknown=made(objections.D_UNKNOWN, "omega_t"),
        d_unknown_angle=made(objections.D_UNKNOWN, "angle"),
        flutter=made(objections.FLUTTER, "omega_t"),
        flutter_angle=made(objections.FLUTTER, "angle"),
        planets=made(objections.PLANETS, "omega_t"),
        planets_angle=made(objections.PLANETS, "angle"),
        in_phase=all(z % planets == 0 for z in teeth),
        growth=[one.value for one in rates],
        in_full_over_own=(extreme(over_own, min), extreme(over_own, max)),
        eq11=made(objections.FULL, "omega_t"),
        eq11_visible=made(objections.FULL, "omega_t", "made_visible"),
        eq11_angle=made(objections.FULL, "angle", "made_visible"),
        counts=_counts(simulated),
    )
    records = [*tables.OBJECTED.json(found.objected), *tables.RATES.json(rates)]
    return Section(said, records, found.supports)

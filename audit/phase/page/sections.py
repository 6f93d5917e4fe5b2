"""The sections of the chapter on the phase: what was computed, put into words, tables, drawings."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from crosscheck.audit.claims.rule import State
from crosscheck.audit.experiments.cells import INTEGRAL, LABELLED, PRINTED, REPAIRED_RATE
from crosscheck.audit.experiments.torque import RING_CYCLES
from crosscheck.audit.measures.events import THIRD_S
from crosscheck.audit.measures.shares import Share
from crosscheck.audit.measures.stage import paper_stage
from crosscheck.audit.measures.thresholds import EVIDENT, SEVERE
from crosscheck.audit.measures.twosamples import SIGNIFICANT, shares_p
from crosscheck.audit.measures.undefined import JsonObject, defined, extreme, quotient
from crosscheck.audit.page.material import Material
from crosscheck.audit.page.text import html, text
from crosscheck.audit.phase import clock, dampers, handover, maps, objections, resonance, stability
from crosscheck.audit.phase.dampers import Runaway
from crosscheck.audit.phase.engines import FEWEST, Engines
from crosscheck.audit.phase.maps import PHASES, Mapped, Maps, RepairedSetting
from crosscheck.audit.phase.objections import D_UNKNOWN, FLUTTER, FULL, PLANETS, Objected
from crosscheck.audit.phase.page import tables, views
from crosscheck.audit.phase.runs.experiments import HIGH_PASS_HZ
from crosscheck.models.loading import load_arm

CLOCK_CAPTION = (
    "Same motion (above) and same start (below); only what the clock shows at the start differs."
    " Labelled reading, b = 50 µm, E = 5 µm. Under angle the four curves are one."
)


class Section(NamedTuple):
    """A kind of evidence: text, records, and whether it speaks for H1; None: undefined."""

    html: str
    records: Sequence[JsonObject]
    supports: bool | None


def of_clock(found: clock.Clocks, material: Material) -> Section:
    """1."""
    by_law = {one.law: one for one in found.laws}
    rows = [tables.OfClock(one.law, delay) for one in found.laws for delay in one.delays]
    said = text(
        "phase/clock",
        motion_s=clock.MOTION_S,
        run_s=clock.RUN_S,
        zeta=clock.RUN_ZETA,
        starts=material.scale.starts(clock.RUN_STARTS),
        window_s=clock.RUN_WINDOW_S,
        table=html(tables.CLOCK.html(rows)),
        drawing=views.clock(found),
        caption=CLOCK_CAPTION,
        printed=by_law[PRINTED],
        repaired=by_law[REPAIRED_RATE],
        integral=by_law[INTEGRAL],
        supports=found.supports,
        integral_same=all(one.same for one in by_law[INTEGRAL].delays),
        vibrations=[[tables.vibrations(one) for one in law.delays] for law in found.laws],
    )
    return Section(said, tables.CLOCK.json(rows), found.supports)


def of_maps(found: Maps, material: Material) -> Section:
    """2."""
    plain = [one for one in found.settings if one.setting.is_paper]
    sizes = [float(size) for one in found.of("angle") for size in one.third.sizes]
    drawings = [] if material.scale.quick else [views.error_map(found), views.backlash_map(found)]
    said = text(
        "phase/maps",
        starts=material.scale.most_starts,
        evident=EVIDENT,
        drawings=drawings,
        table=html(tables.MAPPED.html(plain)),
        counts=_counts(found),
        by_law=_by_law(plain),
        lumped_by_law=_by_law(found.lumped),
        undecided=[
            (planets, sum(s.third.state == State.BISTABLE for s in settings), len(settings))
            for planets, settings in (("free", plain), ("lumped", found.lumped))
            if settings
        ],
        State=State,
        pooled=Share(sum(size > SEVERE for size in sizes), max(1, len(sizes))),
        maps=found,
        lumped=found.lumped,
    )
    records = tables.MAPPED.json([*found.settings, *found.lumped])
    known = found.visible != maps.Presence.UNKNOWN
    return Section(said, records, found.visible == maps.Presence.PRINTED if known else None)


def _counts(found: Maps) -> Mapping[str, object]:
    """Settings in which the tooth error makes a fluctuation, by level and phase law."""
    present = (State.YES, State.BISTABLE)

    def counted(phase: str, visible: bool) -> int:
        made = [one.made_visible if visible else one.made for one in found.of(phase)]
        return sum(one.state in present for one in made)

    return {
        "settings": {phase: len(found.of(phase)) for phase in PHASES},
        "visible": {phase: counted(phase, True) for phase in PHASES},
        "severe": {phase: counted(phase, False) for phase in PHASES},
        "silent": sum(one.made_visible.share is None for one in found.settings),
    }


class OfLaw(NamedTuple):
    """A law's settings at Table I's error and backlash: how many are severe; each branch's sizes.

    zetas: damping ratios at which a reading is severe in nine starts of ten or more; small, severe:
    smallest and largest median of that branch alone [rad/s^2].
    """

    name: str
    states: Counter[State]
    zetas: list[float]
    small: tuple[float, float] | None
    severe: tuple[float, float] | None


def _by_law(plain: Sequence[Mapped]) -> list[OfLaw]:
    """In the order of the laws."""
    found = []
    for law in dict.fromkeys(one.setting.cell.law for one in plain):
        own = [one for one in plain if one.setting.cell.law == law]
        thirds = [one.third for one in own]
        states = Counter(third.state for third in thirds)
        zetas = sorted({x.setting.cell.zeta for x in own if x.third.state == State.YES})
        ranges = (
            _range([third.branch(severe).size for third in thirds]) for severe in (False, True)
        )
        found.append(OfLaw(views.law_name(law), states, zetas, *ranges))
    return found


def _range(medians: Sequence[float | None]) -> tuple[float, float] | None:
    known = [size for size in medians if size is not None]
    return (min(known), max(known)) if known else None


def of_engines(found: Engines) -> Section:
    """3."""
    samples = [
        tables.OfModel(one.cell, name, third, parted)
        for one in found.compared
        for name, third, parted in (
            ("analytic", one.analytic, one.parted[0]),
            ("Exudyn", one.engine, one.parted[1]),
        )
    ]
    branches = [(one.cell, each) for one in found.compared for each in one.apart]
    judged = [(cell, each) for cell, each in branches if each.met is not None]
    missed = [
        f"{each.number} of the {'severe' if each.severe else 'small'} branch at"
        f" {cell.law.id}, ζ = {cell.zeta:g} ({100 * each.difference:+.1f} %; the"
        f" analytic starts alone scatter by {each.scatter:.0%} from quantile 0.1 to 0.9)"
        for cell, each in judged
        if not each.met
    ]
    quiet = [one.engine.sizes.max() for one in found.under_angle if one.engine.sizes.size]
    said = text(
        "phase/engines",
        samples=html(tables.OF_MODEL.html(samples)),
        compared=found.compared,
        parted_p=[shares_p(*one.parted) for one in found.compared],
        parting_differs=any(shares_p(*one.parted) < SIGNIFICANT for one in found.compared),
        limit=SIGNIFICANT,
        branches=html(tables.APART.html(branches)),
        met=len(judged) - len(missed),
        decided=len(judged),
        open=len(branches) - len(judged),
        missed=missed,
        fewest=FEWEST,
        quiet=max(map(float, quiet), default=None),
        under_angle=found.under_angle,
        supports=found.supports,
    )
    records = [
        *tables.OF_MODEL.json(samples),
        *tables.APART.json(branches),
        *tables.TESTS.json(found.compared),
    ]
    return Section(said, records, found.supports)


def of_stability(found: stability.Stability, material: Material) -> Section:
    """4."""
    rows = [tables.Found(cell, one) for cell, one in found.cells.items()]
    intervals = [
        tables.Found(cell, each) for cell, one in found.cells.items() for each in one.intervals
    ]
    said = text(
        "phase/stability",
        gain=RING_CYCLES * THIRD_S[1],
        starts=material.scale.starts(stability.STARTS),
        begin_s=stability.BEGIN_S,
        onset=stability.ONSET_RAD_PER_S2,
        band=HIGH_PASS_HZ,
        error=max(one.jacobian_error for one in found.cells.values()),
        table=html(tables.LINEARISED.html(rows)),
        intervals=html(tables.INTERVAL.html(intervals)),
        drawing=views.stability(found),
        found=found,
    )
    return Section(said, tables.LINEARISED.json(rows), found.supports)


def of_handover(found: handover.Handovers) -> Section:
    """5."""
    living = [
        f"ζ = {fate.cell.zeta:g}, {fate.cell.law.id}"
        for fate in found.under(handover.INTEGRATED).values()
        if fate.dying is not None and fate.dying.yes < fate.dying.of
    ]
    said = text(
        "phase/handover",
        table=html(tables.FATE.html(found.fates)),
        drawing=views.handed_over(found.shown) if found.shown.drawn else "",
        shown=handover.SHOWN,
        living=living,
        supports=found.supports,
    )
    return Section(said, tables.FATE.json(found.fates), found.supports)


def of_resonance(found: resonance.Resonance) -> Section:
    """6."""
    modes = [
        tables.Mode(
            mode,
            speed,
            speed / found.speeds.pd,
            {zeta: ramp.peaks[0][place] for zeta, ramp in found.run_ups.items()},
        )
        for place, (mode, speed) in enumerate(
            zip(found.modes.modes_Hz, found.modes.speeds, strict=True)
        )
    ]
    columns = tables.modes(tuple(found.run_ups))
    growth = list(found.tongues.items())
    said = text(
        "phase/resonance",
        digits=_digits(found),
        modes=html(columns.html(modes)),
        tongues=html(tables.TONGUE.html(growth)),
        drawing=views.resonance(found),
        found=found,
        far=resonance.FAR,
    )
    return Section(said, [*columns.json(modes), *tables.TONGUE.json(growth)], found.supports)


def _digits(found: resonance.Resonance) -> int:
    """To which all starts of a run-up have the same peaks; 15 is all there are."""
    sizes = [
        np.array([peak.size for peak in peaks])
        for ramp in found.run_ups.values()
        for peaks in zip(*ramp.peaks, strict=True)
        if all(peak.size is not None for peak in peaks)
    ]
    spread = max((float(np.ptp(each) / each.mean()) for each in sizes), default=0.0)
    return int(-np.log10(max(spread, 1e-15)))


def of_dampers(found: dampers.Dampers, ran: Sequence[Runaway], material: Material) -> Section:
    """7."""
    own = next(one for one in found.ablated if one.ablation == dampers.AS_IT_STANDS)
    said = text(
        "phase/dampers",
        starts=material.scale.most_starts,
        zeta=dampers.QUIET_ZETA,
        ablated=html(tables.ABLATED.html(found.ablated)),
        fluttering=html(tables.ABLATED.html(found.fluttering)),
        flutter=[one.third.quantiles[1] for one in found.fluttering],
        flutter_zeta=dampers.FLUTTER_ZETA,
        over_zeta=html(tables.ABLATED.html(found.over_zeta)),
        own=own.third.quantiles,
        played=found.median(dampers.PLAYED_BACK.name),
        always=found.median(dampers.ALWAYS.name),
        steady=found.median(dampers.STEADY.name),
        tight=found.median(dampers.TIGHT.name),
        rest=found.rest[1],
        explained=found.excited_hard,
        evident=EVIDENT,
        largest=found.largest_zeta,
        runaways=html(tables.RUNAWAY.html(ran)),
    )
    every = (*found.over_zeta, *found.ablated, *found.fluttering)
    rows = {(one.ablation.name, one.zeta): one for one in every}
    records = [*tables.ABLATED.json(rows.values()), *tables.RUNAWAY.json(ran)]
    return Section(said, records, None)


CALM_ZETA = 0.015  # well above the damping at which the controller makes the arm unstable


def of_repair(found: Sequence[RepairedSetting]) -> Section:
    """8."""
    calm = [one for one in found if one.plain.setting.cell.zeta >= CALM_ZETA]
    thirds = [one.plain.third for one in calm], [one.conservative.third for one in calm]
    sizes = [defined(extreme((one.quantiles[1] for one in some), max)) for some in thirds]
    present = (State.YES, State.BISTABLE)
    visible = sum(one.conservative.made_visible.state in present for one in found)
    silent = all(one.conservative.made_visible.share is None for one in found)
    severe = sum(bool((one.conservative.third.sizes > SEVERE).any()) for one in found)
    stands = None if silent else not visible
    said = text(
        "phase/repair",
        stands=None if stands is None else stands and not severe,
        table=html(tables.REPAIR.html(found)),
        calm=sizes,
        calm_zeta=CALM_ZETA,
        factor=None if not sizes[1] else float(f"{SEVERE / sizes[1]:.1g}"),
        severe_settings=severe,
        visible_settings=visible,
        settings=len(found),
        evident=EVIDENT,
    )
    return Section(said, tables.REPAIR.json(found), stands)


def of_objections(found: objections.Objections, simulated: Maps, material: Material) -> Section:
    """What remains to be answered."""
    rates = [tables.Found(cell, one) for cell, one in found.rates.items()]
    over_own = [
        quotient(one.eq11_in_full_per_s, one.as_it_stands_per_s) for one in found.rates.values()
    ]
    joint = paper_stage(load_arm(LABELLED)).joint
    teeth = (joint.sun_teeth, joint.ring_teeth)
    spacing = " and ".join(
        f"{z} / {joint.planet_count} = {z / joint.planet_count:g}" for z in teeth
    )
    said = text(
        "phase/objections",
        starts=material.scale.most_starts,
        table=html(tables.OBJECTED.html(found.objected)),
        rates=html(tables.RATES.html(rates, "Largest growth rates, 0.5 to 1.2 s [1/s]")),
        spacing=spacing,
        d_unknown=_made(found.objected, D_UNKNOWN, "omega_t"),
        d_unknown_angle=_made(found.objected, D_UNKNOWN, "angle"),
        flutter=_made(found.objected, FLUTTER, "omega_t"),
        flutter_angle=_made(found.objected, FLUTTER, "angle"),
        planets=_made(found.objected, PLANETS, "omega_t"),
        planets_angle=_made(found.objected, PLANETS, "angle"),
        in_phase=all(z % joint.planet_count == 0 for z in teeth),
        growth=[one.value for one in rates],
        in_full_over_own=(extreme(over_own, min), extreme(over_own, max)),
        eq11=_made(found.objected, FULL, "omega_t"),
        eq11_visible=_made(found.objected, FULL, "omega_t", visible=True),
        eq11_angle=_made(found.objected, FULL, "angle", visible=True),
        evident=EVIDENT,
        counts=_counts(simulated),
    )
    records = [*tables.OBJECTED.json(found.objected), *tables.RATES.json(rates)]
    return Section(said, records, found.supports)


def _made(found: Sequence[Objected], objection: str, phase: str, visible: bool = False) -> str:
    """In words: so many of so many starts, setting by setting, of all changes of an objection."""
    chosen = [
        one for one in found if one.change.objection == objection and one.cell.law.phase == phase
    ]
    made = [(one.made_visible if visible else one.made).share for one in chosen]
    told = ["undefined" if one is None else f"{one.yes} of {one.of}" for one in made]
    return ", ".join(told) + " starts"

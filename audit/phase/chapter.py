"""Hypothesis H1: is the paper's "self-excited" fluctuation the teeth, or the formula's clock?"""

from __future__ import annotations

from collections.abc import Callable, Mapping

from crosscheck.audit.experiments.experiments import PD
from crosscheck.audit.experiments.paper_conditions import (
    AS_MODELLED,
    INTEGRAL,
    LABELLED,
    PRINTED,
    REPAIRED_RATE,
    Condition,
)
from crosscheck.audit.measures.shares import Share
from crosscheck.audit.measures.third_fluctuation import ThirdFluctuation
from crosscheck.audit.measures.undefined import UNDEFINED
from crosscheck.audit.page.chapter import AuditChapter
from crosscheck.audit.page.context import AuditContext
from crosscheck.audit.page.text import render_template
from crosscheck.audit.phase.maps import Maps, Presence, build_maps
from crosscheck.audit.phase.page import sections

ZETA = 0.005  # of Figs. 11-14 and 16-20: where the start decides
ID, TITLE = "phase", "The phase of the teeth (H1)"
BESIDE = "what vibrates without tooth error"  # told, and no evidence
# In reading order.
SECTIONS: dict[str, Callable[[Maps, AuditContext], sections.Section]] = {
    "the clock test": sections.build_clock_section,
    "simulation": sections.build_maps_section,
    "a second engine": sections.build_engines_section,
    "stability": sections.build_stability_section,
    "the handover": sections.build_handover_section,
    "resonance": sections.build_resonance_section,
    BESIDE: sections.build_dampers_section,
    "the repair with the springs' own work": sections.build_repair_section,
    "objections": sections.build_objections_section,
}
QUICK = ("the clock test", "simulation", "stability")


def build_chapter(context: AuditContext) -> AuditChapter:
    """The chapter on H1: kinds of evidence and a referee's objections; quick: three kinds alone."""
    simulated = build_maps(context)
    section_names = [name for name in SECTIONS if name in QUICK or not context.scale.quick]
    section_results = {name: SECTIONS[name](simulated, context) for name in section_names}
    ordered_names = sorted(
        section_names, key=lambda name: name not in QUICK
    )  # first what every page has
    supports = {name: section_results[name].supports for name in ordered_names if name != BESIDE}
    h1 = {
        "id": "H1",
        "verdict": judge_h1(simulated.visible, supports),
        "visible": simulated.visible,
        "severe": simulated.severe,
        "evidence": supports,  # whether each kind of it that was run speaks for H1
    }
    summary = {"verdict": h1, **_shares(simulated, context)}
    introduction = render_template(
        "phase/introduction",
        maps=simulated,
        settings=len(simulated.settings),
        starts=context.scale.most_starts,
        **summary,
    )
    records = [record for section in section_results.values() for record in section.records]
    page = "\n".join([introduction, *(section.html for section in section_results.values())])
    outcome = render_template("phase/outcome", **summary)
    return AuditChapter(ID, TITLE, page, [h1, *records], outcome)


def _shares(simulated: Maps, context: AuditContext) -> dict[str, Share | None]:
    """The shares of severe starts under the three laws, and as modelled in the paper."""
    plain = [point for point in simulated.settings if point.setting.is_paper]
    shares = {point.setting.cell: point.third.share for point in plain}
    cells = {
        "printed": Condition(PRINTED, ZETA),
        "repaired": Condition(REPAIRED_RATE, ZETA),
        "integral": Condition(INTEGRAL, ZETA),
    }
    request = Condition(PRINTED, ZETA, LABELLED, AS_MODELLED.planets, AS_MODELLED.equations), PD
    own = ThirdFluctuation.from_samples(context.samples([request], "phase: as modelled")[request])
    return {name: shares.get(cell) for name, cell in cells.items()} | {"alike": own.share}


def judge_h1(maps: Presence, supports: Mapping[str, bool | None]) -> str:
    """The verdict: `holds` if simulations say so and no evidence that was run speaks against it.

    maps: where the tooth error makes a fluctuation; supports: the other kinds of evidence.
    """
    if maps == Presence.UNKNOWN:
        return UNDEFINED
    if maps != Presence.PRINTED:
        return "does not hold"
    for answer, but in ((False, "not"), (None, UNDEFINED)):
        names = [name for name, supported in supports.items() if supported is answer]
        if names:
            return f"holds in the simulations, but {but} in: {', '.join(names)}"
    return "holds"

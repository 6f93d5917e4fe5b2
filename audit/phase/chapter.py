"""Hypothesis H1: is the paper's "self-excited" fluctuation the teeth, or the formula's clock?"""

from __future__ import annotations

from collections.abc import Callable, Mapping

from crosscheck.audit.experiments.cells import INTEGRAL, PRINTED, REPAIRED_RATE, Cell
from crosscheck.audit.measures.shares import Share
from crosscheck.audit.measures.undefined import UNDEFINED
from crosscheck.audit.page.chapter import AuditChapter
from crosscheck.audit.page.material import Material
from crosscheck.audit.page.text import text
from crosscheck.audit.phase.maps import Maps, Presence, maps
from crosscheck.audit.phase.page import sections

ZETA = 0.005  # of Figs. 11-14 and 16-20: where the start decides
ID, TITLE = "phase", "The phase of the teeth (H1)"
BESIDE = "what vibrates without tooth error"  # told, and no evidence
# In reading order.
SECTIONS: dict[str, Callable[[Maps, Material], sections.Section]] = {
    "the clock test": sections.of_clock,
    "simulation": sections.of_maps,
    "a second engine": sections.of_engines,
    "stability": sections.of_stability,
    "the handover": sections.of_handover,
    "resonance": sections.of_resonance,
    BESIDE: sections.of_dampers,
    "the repair with the springs' own work": sections.of_repair,
    "objections": sections.of_objections,
}
QUICK = ("the clock test", "simulation", "stability")


def chapter(material: Material) -> AuditChapter:
    """The chapter on H1: kinds of evidence and a referee's objections; quick: three kinds alone."""
    simulated = maps(material)
    asked = [name for name in SECTIONS if name in QUICK or not material.scale.quick]
    found = {name: SECTIONS[name](simulated, material) for name in asked}
    told = sorted(asked, key=lambda name: name not in QUICK)  # first what every page has
    supports = {name: found[name].supports for name in told if name != BESIDE}
    h1 = {
        "id": "H1",
        "verdict": h1_verdict(simulated.visible, supports),
        "visible": simulated.visible,
        "severe": simulated.severe,
        "evidence": supports,  # whether each kind of it that was run speaks for H1
    }
    said = {"verdict": h1, **_shares(simulated)}
    introduction = text(
        "phase/introduction",
        maps=simulated,
        settings=len(simulated.settings),
        starts=material.scale.most_starts,
        **said,
    )
    records = [record for section in found.values() for record in section.records]
    page = "\n".join([introduction, *(section.html for section in found.values())])
    outcome = text("phase/outcome", **said)
    return AuditChapter(ID, TITLE, page, [h1, *records], outcome)


def _shares(simulated: Maps) -> dict[str, Share | None]:
    """The shares of severe starts under the three laws, and by the first with planets lumped."""
    plain = [one for one in simulated.settings if one.setting.is_paper]
    found = {one.setting.cell: one.third.share for one in (*plain, *simulated.lumped)}
    cells = {
        "printed": Cell(PRINTED, ZETA),
        "repaired": Cell(REPAIRED_RATE, ZETA),
        "integral": Cell(INTEGRAL, ZETA),
        "alike": Cell(PRINTED, ZETA, planets="lumped"),
    }
    return {name: found.get(cell) for name, cell in cells.items()}


def h1_verdict(maps: Presence, supports: Mapping[str, bool | None]) -> str:
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

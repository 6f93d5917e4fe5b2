"""Hypothesis H1: is the paper's "self-excited" fluctuation the teeth, or the formula's clock?"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass

from crosscheck.audit.experiments.cells import INTEGRAL, PRINTED, REPAIRED_RATE, Cell
from crosscheck.audit.measures.shares import Share
from crosscheck.audit.measures.thresholds import EVIDENT, SEVERE
from crosscheck.audit.measures.undefined import UNDEFINED, JsonObject
from crosscheck.audit.page.chapter import AuditChapter
from crosscheck.audit.page.material import Material
from crosscheck.audit.page.text import text
from crosscheck.audit.phase.clock import clocks
from crosscheck.audit.phase.dampers import dampers, runaways
from crosscheck.audit.phase.engines import engines
from crosscheck.audit.phase.handover import handover
from crosscheck.audit.phase.maps import Maps, Presence, maps
from crosscheck.audit.phase.objections import objections
from crosscheck.audit.phase.page import sections
from crosscheck.audit.phase.page.sections import Section
from crosscheck.audit.phase.resonance import resonance
from crosscheck.audit.phase.stability import stability

ZETA = 0.005  # of Figs. 11-14 and 16-20: where the start decides
ID, TITLE = "phase", "The phase of the teeth (H1)"
BESIDE = "what vibrates without tooth error"  # told, and no evidence
ORDER = (
    "the clock test",
    "simulation",
    "a second engine",
    "stability",
    "the handover",
    "resonance",
    BESIDE,
    "the repair with the springs' own work",
    "objections",
)


@dataclass(frozen=True)
class H1:
    """The verdict; evidence: whether each kind of it that was run speaks for H1."""

    verdict: str
    visible: Presence
    severe: Presence
    evidence: dict[str, bool | None]


def chapter(material: Material) -> AuditChapter:
    """Kinds of evidence and a referee's objections; quick: the clock, few settings, the modes."""
    study, scale = material.study, material.scale
    simulated = maps(material)
    found = {
        "the clock test": sections.of_clock(clocks(study, scale), material),
        "simulation": sections.of_maps(simulated, material),
        "stability": sections.of_stability(stability(study, scale), material),
    }
    if not scale.quick:
        found |= {
            "a second engine": sections.of_engines(engines(material)),
            "the handover": sections.of_handover(handover(study, scale)),
            "resonance": sections.of_resonance(resonance(study, scale)),
            "the repair with the springs' own work": sections.of_repair(simulated.repairs),
            "objections": sections.of_objections(objections(study, scale), simulated, material),
        }
        beside = dampers(study, scale), runaways(study, scale)
        found[BESIDE] = sections.of_dampers(*beside, material)
    return _made(simulated, found, material)


def _made(simulated: Maps, found: dict[str, Section], material: Material) -> AuditChapter:
    supports = {name: one.supports for name, one in found.items() if name != BESIDE}
    verdict = H1(
        h1_verdict(simulated.visible, supports), simulated.visible, simulated.severe, supports
    )
    ordered = [found[name] for name in ORDER if name in found]
    own: JsonObject = {"id": "H1", **asdict(verdict)}
    shares = _shares(simulated)
    introduction = text(
        "phase/introduction",
        verdict=verdict,
        maps=simulated,
        settings=len(simulated.settings),
        starts=material.scale.most_starts,
        evident=EVIDENT,
        severe=SEVERE,
        **shares,
    )
    return AuditChapter(
        ID,
        TITLE,
        "\n".join([introduction, *(section.html for section in ordered)]),
        [own, *(record for section in ordered for record in section.records)],
        text("phase/outcome", verdict=verdict, evident=EVIDENT, severe=SEVERE, **shares),
    )


def _shares(simulated: Maps) -> dict[str, Share | None]:
    """Of severe starts under the three laws, and with planets held alike."""
    plain = {one.setting.cell: one.third for one in simulated.settings if one.setting.is_paper}
    alike = {one.setting.cell: one.third for one in simulated.lumped}
    found = plain | alike
    cells = {
        "printed": Cell(PRINTED, ZETA),
        "repaired": Cell(REPAIRED_RATE, ZETA),
        "integral": Cell(INTEGRAL, ZETA),
        "alike": Cell(PRINTED, ZETA, planets="lumped"),
    }
    return {name: found[c].share if c in found else None for name, c in cells.items()}


def h1_verdict(maps: Presence, supports: Mapping[str, bool | None]) -> str:
    """`holds` if the simulations say so and no kind of evidence that was run speaks against it.

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

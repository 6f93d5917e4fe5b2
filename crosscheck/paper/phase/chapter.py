"""Hypothesis H1: is the paper's "self-excited" fluctuation the teeth, or the formula's clock?"""

from __future__ import annotations

from dataclasses import dataclass

from crosscheck.paper.phase.clock import clock_test
from crosscheck.paper.phase.engines import engines, freed_planets
from crosscheck.paper.phase.handover import handover
from crosscheck.paper.phase.maps import maps
from crosscheck.paper.phase.objections import objections
from crosscheck.paper.phase.resonance_view import resonance
from crosscheck.paper.phase.stability import stability
from crosscheck.paper.phase.verdict import Presence, h1_verdict
from crosscheck.paper.record import Record
from crosscheck.paper.scale import Scale
from crosscheck.paper.undefined import word
from crosscheck.report.chapter import Chapter
from crosscheck.report.fragments import heading, paragraph
from crosscheck.studies.study import Study

ID, TITLE = "phase", "The phase of the teeth (H1)"
WRONG = (
    "Eqs. 8 and 14 take the mesh phase as the present meshing frequency times the time since the"
    " start, so that every change of speed, however small, shifts the teeth by an amount that grows"
    " with the clock, and the tooth error becomes an ever stronger feedback of the speed that"
    " excites the vibration by itself."
)
REPAIR = (
    "Replace ω_e t by its integral, which is the number of teeth passed: sin(z_r θ_c) in both"
    " meshes, θ_c being the joint's own angle; the vibration of Figs. 14 and 17 to 20 that"
    " depends on the tooth error then does not occur at this arm's speeds."
)


@dataclass(frozen=True)
class H1(Record):
    """The verdict; evidence: whether each kind of it that was run speaks for H1."""

    verdict: str
    tooth_error_part_present: Presence
    evidence: dict[str, bool | None]

    @property
    def id(self) -> str:
        return "H1"


def chapter(study: Study, scale: Scale) -> Chapter:
    """Six kinds of evidence and a referee's objections; quick: the clock, four runs, the modes."""
    simulated, freed = maps(study, scale), ""
    present = simulated.present
    found = {"the clock test": clock_test(study, scale), "simulation": simulated.evidence}
    if not scale.quick:
        engine = engines(study, scale)
        found["a second engine"] = engine.evidence
        freed = freed_planets(engine.compared)
    found["stability"] = stability(study, scale)
    if not scale.quick:
        found["the handover"] = handover(study, scale)
        found["resonance"] = resonance(study, scale)
        found["objections"] = objections(study, simulated.parts["angle"], freed, scale)
    supports = {name: evidence.supports for name, evidence in found.items()}
    verdict = H1(h1_verdict(present, supports), present, supports)
    html = [_introduction(verdict, freed), *(evidence.html for evidence in found.values())]
    records = [verdict, *(r for evidence in found.values() for r in evidence.records)]
    outcome = f"H1 {verdict.verdict}; the tooth error's part of the third fluctuation: {present}."
    return Chapter(ID, TITLE, "\n".join(html), [r.to_dict() for r in records], outcome)


def _introduction(h1: H1, freed: str) -> str:
    said = ", ".join(
        f"{name} {word(supports, 'for it', 'against it')}" for name, supports in h1.evidence.items()
    )
    return "\n".join(
        [
            heading("What is wrong, and how to repair it"),
            paragraph(f"{WRONG} {REPAIR}"),
            paragraph(
                "H1: the part of the third fluctuation that depends on the tooth error exists only"
                " under omega_t (phase = meshing frequency times time, as printed) and not under"
                " angle (phase = its integral)."
                f" Verdict: H1 {h1.verdict}. Evidence: {said}. {freed}"
            ),
        ]
    )

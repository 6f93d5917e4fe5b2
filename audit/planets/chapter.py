"""Hypothesis H7: does counting three planets as one change the paper's third fluctuation?"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict, dataclass

from crosscheck.audit.measures.third import APART_M
from crosscheck.audit.measures.thresholds import SEVERE
from crosscheck.audit.measures.twosamples import SIGNIFICANT
from crosscheck.audit.page.chapter import AuditChapter
from crosscheck.audit.page.material import Material
from crosscheck.audit.page.said import said_of_third
from crosscheck.audit.page.text import html, text
from crosscheck.audit.phase.engines import Engines, engines
from crosscheck.audit.planets import tables, views
from crosscheck.audit.planets.features import Feature, features
from crosscheck.audit.planets.freed import Freed, effects_by_law, freed
from crosscheck.audit.planets.growth import CELL, STARTING_S, STARTS, Growth, growth
from crosscheck.audit.planets.verdict import PREDICTED, PlanetsEffect, Survival, h7_verdict

MOSTLY = 0.5  # of the starts
ID, TITLE = "planets", "Three planets counted as one (H7)"


@dataclass(frozen=True)
class H7:
    """The verdict; settings by effect; whether the parting is foretold, and Exudyn agrees."""

    verdict: str
    settings: int
    weaker: int
    stronger: int
    foretold: bool | None
    engines_agree: bool | None
    claims_changed: int


def chapter(material: Material) -> AuditChapter:
    """Samples, the growth of differences, another engine, the figures' statements."""
    sampled, grown = freed(material), growth(material.study, material.scale)
    compared, seen = engines(material), features(material)
    verdict = _verdict(sampled, grown, compared, seen)
    shown = [
        text("planets/introduction", verdict=verdict),
        _sizes(sampled, material),
        _parting(grown, material),
        text("planets/engines", compared=compared.compared, same=compared.same),
        _features(seen),
    ]
    records = [
        {"id": "H7", **asdict(verdict)},
        *tables.FREED.json(sampled),
        *tables.BREAKING.json(grown.breaking),
        *tables.FORETOLD.json([grown.lumped, grown.free]),
        *tables.PREDICTIONS.json(grown.joints),
        *tables.FEATURE.json(seen),
    ]
    stated = [each for one in sampled for each in said_of_third(f"{ID}, free", one.cell, one.free)]
    outcome = text("planets/outcome", verdict=verdict)
    return AuditChapter(ID, TITLE, "\n".join(shown), records, outcome, stated)


def _verdict(
    sampled: Sequence[Freed], grown: Growth, compared: Engines, seen: Sequence[Feature]
) -> H7:
    effects = [one.effect for one in sampled]
    return H7(
        verdict=h7_verdict(effects),
        settings=len(effects),
        weaker=effects.count(PlanetsEffect.WEAKER),
        stronger=effects.count(PlanetsEffect.STRONGER),
        foretold=grown.free.all_right,
        engines_agree=compared.same,
        claims_changed=sum(one.changed is True for one in seen),
    )


def _sizes(sampled: Sequence[Freed], material: Material) -> str:
    return text(
        "planets/sizes",
        starts=material.scale.most_starts,
        severe=SEVERE,
        significant=SIGNIFICANT,
        drawing=views.sizes(sampled),
        table=html(tables.FREED.html(sampled)),
        effects={law.id: counts for law, counts in effects_by_law(sampled).items()},
        PlanetsEffect=PlanetsEffect,
    )


def _parting(grown: Growth, material: Material) -> str:
    pressed = [one.pressed_largest_m for one in grown.joints]
    largest = max((size for size in pressed if size is not None), default=None)
    return text(
        "planets/parting",
        cell=CELL,
        starts=material.scale.starts(STARTS),
        apart_um=1e6 * APART_M,
        starting_s=STARTING_S,
        within=PREDICTED,
        breaking=html(tables.BREAKING.html(grown.breaking)),
        early=list(dict.fromkeys(b.cell.zeta for b in grown.breaking if b.early.value > MOSTLY)),
        drawing=views.parting(grown.starts),
        table=html(tables.PREDICTIONS.html(grown.joints)),
        grown=grown,
        pressed=largest,
        by_contact=None if largest is None else largest < APART_M,
    )


def _features(seen: Sequence[Feature]) -> str:
    changed = [one for one in seen if one.changed]
    return text(
        "planets/features",
        table=html(tables.FEATURE.html(seen)),
        turned=html(tables.FEATURE.html(changed)),
        changed=len(changed),
        asked=len(seen),
        counts=Counter(one.survives for one in seen),
        Survival=Survival,
    )

"""The errata sheet: what one could send to the authors, as a chapter and as Markdown."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from audit.errata.erratum import Slip
from audit.errata.finder import EFFECT_S, Errata
from audit.errata.notes import notes
from audit.errata.tables import CONTRADICTIONS, GAPS, SLIPS, ArmSlip
from audit.errata.words import in_words
from audit.experiments.cells import LABELLED, READINGS
from audit.page.chapter import Chapter
from audit.page.material import Material
from audit.page.text import html, text

ID, TITLE = "errata", "Errata sheet"
QUICK_S = 0.05


@dataclass(frozen=True)
class ErrataSheet(Chapter):
    """The chapter, with the slips in it that are those of the first arm."""

    slips: tuple[Slip, ...] = ()


def chapter(material: Material) -> ErrataSheet:
    """The errata sheet for both readings of Table I (the quick one for the first alone)."""
    quick = material.scale.quick
    arms = [LABELLED] if quick else list(READINGS)
    duration = material.scale.seconds(QUICK_S if quick else EFFECT_S)
    answers = material.study.answers([Errata(name, duration) for name in arms], "errata sheet")
    found = {arm: in_words(slips) for arm, slips in zip(arms, answers, strict=True)}
    slips, noted = found[LABELLED], notes()
    records = [
        *SLIPS.json(ArmSlip(arm, slip) for arm, own in found.items() for slip in own),
        *CONTRADICTIONS.json(noted.contradictions),
        *GAPS.json(noted.gaps),
    ]
    page = text(
        "errata/sheet",
        duration_s=duration,
        arm=LABELLED,
        slips=html(SLIPS.html(_rows(slips))),
        apart=_apart(found),
        contradictions=html(CONTRADICTIONS.html(noted.contradictions)),
        gaps=html(GAPS.html(noted.gaps)),
    )
    counts = f"{len(slips)} slips, {len(noted.contradictions)} contradictions"
    outcome = f"{counts}, {len(noted.gaps)} gaps."
    return ErrataSheet(ID, TITLE, page, records, outcome, slips=slips)


def _rows(slips: Sequence[Slip]) -> list[ArmSlip]:
    return [ArmSlip(LABELLED, slip) for slip in slips]


def _apart(found: Mapping[str, Sequence[Slip]]) -> dict[str, list[str]]:
    """Where slips are that one reading of Table I has and no other."""
    places = {arm: {slip.erratum.where for slip in slips} for arm, slips in found.items()}
    return {
        arm: sorted(own.difference(*(p for other, p in places.items() if other != arm)))
        for arm, own in places.items()
        if len(places) > 1
    }


def markdown(slips: Sequence[Slip]) -> str:
    """The sheet as Markdown, formulas as TeX; the slips are the chapter's."""
    noted = notes()
    parts = [
        "# Errata sheet",
        text("errata/introduction").strip(),
        SLIPS.markdown(_rows(slips)),
        "## Where the text contradicts itself",
        CONTRADICTIONS.markdown(noted.contradictions),
        "## What is missing to reproduce it",
        GAPS.markdown(noted.gaps),
    ]
    return "\n\n".join(parts) + "\n"

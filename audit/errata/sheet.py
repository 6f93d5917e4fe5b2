"""The errata sheet: what one could send to the authors, as a chapter and as Markdown."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from crosscheck.audit.errata.erratum import CLASSES, Class, SimulatedErratum
from crosscheck.audit.errata.finder import EFFECT_S, Errata
from crosscheck.audit.errata.tables import BY_CLASS, CONTRADICTIONS, GAPS, WHOLE, ArmErratum
from crosscheck.audit.errata.words import in_words, notes
from crosscheck.audit.experiments.cells import LABELLED, READINGS
from crosscheck.audit.page.chapter import AuditChapter
from crosscheck.audit.page.material import Material
from crosscheck.audit.page.said import StatedNumber
from crosscheck.audit.page.text import html, text

ID, TITLE = "errata", "Errata sheet"
QUICK_S = 0.05
HEADINGS: dict[Class, str] = {
    "equation": "Errors of equations",
    "statement": "Statements and data without support",
    "notation": "Notation",
}


@dataclass(frozen=True)
class ErrataSheet(AuditChapter):
    """The chapter, with the errata in it that are those of the first arm."""

    found: tuple[SimulatedErratum, ...] = ()


def chapter(material: Material) -> ErrataSheet:
    """The errata sheet for both readings of Table I (the quick one for the first alone)."""
    quick = material.scale.quick
    arms = [LABELLED] if quick else list(READINGS)
    duration = material.scale.seconds(QUICK_S if quick else EFFECT_S)
    answers = material.study.answers([Errata(name, duration) for name in arms], "errata sheet")
    by_arm = {arm: in_words(found) for arm, found in zip(arms, answers, strict=True)}
    own, noted = by_arm[LABELLED], notes()
    rows = [ArmErratum(arm, one) for arm, found in by_arm.items() for one in found]
    page = text(
        "errata/sheet",
        duration_s=duration,
        arm=LABELLED,
        tables={HEADINGS[kind]: html(BY_CLASS[kind].html(_rows(own, kind))) for kind in CLASSES},
        counts=counted(own),
        apart=_apart(by_arm),
        contradictions=html(CONTRADICTIONS.html(noted.contradictions)),
        gaps=html(GAPS.html(noted.gaps)),
    )
    records = [
        *WHOLE.json(rows),
        *CONTRADICTIONS.json(noted.contradictions),
        *GAPS.json(noted.gaps),
    ]
    outcome = text("errata/outcome", counts=counted(own))
    return ErrataSheet(ID, TITLE, page, records, outcome, numbers=_numbers(rows), found=own)


@dataclass(frozen=True)
class SheetCounts:
    """How many of each class, and of these how many by computation; contradictions and gaps."""

    by_class: Mapping[Class, int]
    read: int
    contradictions: int
    gaps: int


def counted(found: Sequence[SimulatedErratum]) -> SheetCounts:
    """Of a sheet."""
    noted, kinds = notes(), Counter(one.erratum.kind for one in found)
    read = {misprint.id for misprint in noted.misprints}
    return SheetCounts(
        {kind: kinds[kind] for kind in CLASSES},
        sum(one.erratum.id in read for one in found),
        len(noted.contradictions),
        len(noted.gaps),
    )


def _numbers(rows: Sequence[ArmErratum]) -> list[StatedNumber]:
    """What other chapters may state, too."""
    return [
        StatedNumber(TITLE, f"{row.found.erratum.id}, {name}", row.arm, value)
        for row in rows
        for name, value in (("size", row.found.erratum.size), *row.found.erratum.quoted.items())
        if isinstance(value, float)
    ]


def _rows(found: Sequence[SimulatedErratum], kind: Class) -> list[ArmErratum]:
    return [ArmErratum(LABELLED, one) for one in found if one.erratum.kind == kind]


def _apart(by_arm: Mapping[str, Sequence[SimulatedErratum]]) -> dict[str, list[str]]:
    """Where errata are that one reading of Table I has and no other."""
    places = {arm: {one.erratum.where for one in found} for arm, found in by_arm.items()}
    return {
        arm: sorted(own.difference(*(p for other, p in places.items() if other != arm)))
        for arm, own in places.items()
        if len(places) > 1
    }


def markdown(found: Sequence[SimulatedErratum]) -> str:
    """The sheet as Markdown, formulas as TeX; the errata are the chapter's."""
    noted = notes()
    parts = ["# Errata sheet", text("errata/introduction", counts=counted(found)).strip()]
    for kind in CLASSES:
        parts += [f"## {HEADINGS[kind]}", BY_CLASS[kind].markdown(_rows(found, kind))]
    parts += [
        "## Where the text contradicts itself",
        CONTRADICTIONS.markdown(noted.contradictions),
        "## What is missing to reproduce it",
        GAPS.markdown(noted.gaps),
    ]
    return "\n\n".join(parts) + "\n"

"""The claims: every statement of the paper that asserts a number or a direction, judged."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass

from crosscheck.audit.claims.judged import Judged
from crosscheck.audit.claims.records import record
from crosscheck.audit.claims.rule import Claim, answers
from crosscheck.audit.claims.settings import plan_of
from crosscheck.audit.claims.summary import Varied, varied
from crosscheck.audit.claims.words import page
from crosscheck.audit.experiments.cells import GearModel
from crosscheck.audit.page.chapter import AuditChapter
from crosscheck.audit.page.material import Material
from crosscheck.audit.page.said import Said

ID, TITLE = "claims", "The paper's statements, one by one"


@dataclass(frozen=True)
class ClaimRow:
    """A claim and what the model's variants say of it."""

    judged: Judged
    variants: tuple[Varied, ...]


def chapter(material: Material) -> AuditChapter:
    """The claims, their values in all settings and their verdicts."""
    found = rows(material)
    counts = Counter(row.judged.verdict.kind for row in found)
    outcome = "; ".join(f"{kind}: {count}" for kind, count in counts.most_common())
    return AuditChapter(
        ID,
        TITLE,
        page(found, plan_of(material.scale), material.scale),
        [record(row.judged, row.variants) for row in found],
        f"of {len(found)} statements: {outcome}.",
        said=said(row.judged for row in found),
    )


def rows(material: Material) -> list[ClaimRow]:
    """Of every claim, in the paper's order."""
    return [
        ClaimRow(one, tuple(varied(one, _of_variants(one.claim, material))))
        for one in material.judged.values()
    ]


def _of_variants(claim: Claim, material: Material) -> dict[GearModel, Judged]:
    return {
        model: Judged(claim, tuple(answers(claim, settings)))
        for model, settings in material.variations.items()
    }


def said(every: Iterable[Judged]) -> list[Said]:
    """What the claims say of their quantities."""
    return [
        Said(f"claim {one.claim.id}", choices[a.place.choice].id, a.limits, a.place, a.state)
        for one in every
        for choices in (one.claim.choices,)
        for a in one.answers
    ]

"""What the claims of a figure say at its setting: the rows of the table beside it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from crosscheck.audit.claims.catalogue import CLAIMS
from crosscheck.audit.claims.rule import Answer, Claim, Verdict, answers
from crosscheck.audit.experiments.cells import LABELLED, LAWS, Cell, Law
from crosscheck.audit.figures.shelf import Shelf
from crosscheck.audit.page.said import Said


@dataclass(frozen=True)
class Row:
    """A claim at one setting: its answer by law, {None: ...} where it has none; None: not asked.

    choice: of the claim's free parameter, its default; verdict: over all settings, if asked.
    """

    claim: Claim
    choice: str
    found: Mapping[Law | None, Answer]
    verdict: Verdict | None

    @property
    def cells(self) -> list[Answer | None]:
        """Under every law; of a static claim one answer, not three."""
        if self.claim.static:
            return [self.found.get(None), *([None] * (len(LAWS) - 1))]
        return [self.found.get(law) for law in LAWS]


def rows(shelf: Shelf, number: int, zeta: float) -> list[Row]:
    """Every claim of a figure."""
    known = [(Cell(law, zeta), one) for law, one in shelf.known(zeta).items()]
    return [_row(shelf, claim, answers(claim, known)) for claim in CLAIMS if claim.figure == number]


def _row(shelf: Shelf, claim: Claim, given: Sequence[Answer]) -> Row:
    default = next(iter(claim.choices))
    found = {
        one.place.law: one
        for one in given
        if one.place.choice == default and one.place.arm == LABELLED
    }
    verdict = shelf.material.judged[claim.id].verdict if shelf.whole else None
    return Row(claim, default, found, verdict)


def said(number: int, found: Sequence[Row]) -> list[Said]:
    """What the table states."""
    return [
        Said(
            f"figure {number}",
            row.claim.choices[row.choice].id,
            row.claim.limits,
            answer.place,
            answer.state,
        )
        for row in found
        for answer in row.found.values()
    ]

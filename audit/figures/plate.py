"""A plate: one figure of the paper redrawn; its words stand in templates."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

from pydantic import JsonValue

from crosscheck.audit.claims.catalogue import CLAIMS
from crosscheck.audit.claims.chapter import COLOURS as VERDICT_COLOURS
from crosscheck.audit.claims.chapter import share_words, value_words, verdict_words
from crosscheck.audit.claims.rule import Answer, Claim, State, Verdict, answers
from crosscheck.audit.experiments.cells import LABELLED, LAWS, Cell, Law
from crosscheck.audit.figures.shelf import Shelf
from crosscheck.audit.measures.undefined import JsonObject
from crosscheck.audit.page.text import html, text
from crosscheck.audit.page.words import LAW_NAMES

COLOURS = {State.YES: "agree", State.NO: "differ", State.BISTABLE: "bistable"}


class Drawing(NamedTuple):
    """A drawing as an <svg> element, with what it shows in plain text."""

    svg: str
    caption: str


@dataclass(frozen=True)
class Plate:
    """A plate. zeta: None where no damping enters; start: seed of what is drawn.

    numbers: for the figure's words; reason: why there is no drawing.
    """

    number: int
    drawings: Sequence[Drawing]
    zeta: float | None = None
    start: int | None = None
    numbers: Mapping[str, JsonValue] = field(default_factory=dict)
    tables: Mapping[str, str] = field(default_factory=dict)
    reason: str = ""

    def html(self, found: Sequence[Row]) -> str:
        """The figure's html from <h3> down, with the claims that it is about."""
        return text(
            f"figures/figure-{self.number}",
            plate=self,
            svgs=[(html(one.svg), one.caption) for one in self.drawings],
            tables={name: html(table) for name, table in self.tables.items()},
            rows=found,
            laws=[LAW_NAMES[law] for law in LAWS],
            kinds=Counter(str(row.verdict.kind) for row in found if row.verdict),
            colours=COLOURS,
            verdict_colours=VERDICT_COLOURS,
            value=value_words,
            share=share_words,
            verdict=verdict_words,
        )

    def to_dict(self, found: Sequence[Row]) -> JsonObject:
        """The figure as a JSON object; what the claims say stands in their own records."""
        return {
            "id": f"figure-{self.number}",
            "zeta": self.zeta,
            "start": self.start,
            "drawn": not self.reason,
            "claims": [row.claim.id for row in found],
            "numbers": dict(self.numbers),
        }


@dataclass(frozen=True)
class Row:
    """A claim in a setting: its answer by law, {None: ...} if it has none; None: not asked.

    choice: of the claim's free parameter, its default; verdict: over all settings, if asked.
    """

    claim: Claim
    choice: str
    found: Mapping[Law | None, Answer]
    verdict: Verdict | None

    @property
    def cells(self) -> list[Answer | None]:
        """The claim's answer under every law; of a static claim one answer, not three."""
        if self.claim.static:
            return [self.found.get(None), *([None] * (len(LAWS) - 1))]
        return [self.found.get(law) for law in LAWS]


def rows(shelf: Shelf, number: int, zeta: float) -> list[Row]:
    """A row for every claim of a figure."""
    known = [(Cell(law, zeta), one) for law, one in shelf.known(zeta).items()]
    found = []
    for claim in CLAIMS:
        if claim.figure == number:
            choice = next(iter(claim.choices))
            own = {
                one.place.law: one
                for one in answers(claim, known)
                if (one.place.choice, one.place.arm) == (choice, LABELLED)
            }
            verdict = shelf.material.judged[claim.id].verdict if shelf.whole else None
            found.append(Row(claim, choice, own, verdict))
    return found

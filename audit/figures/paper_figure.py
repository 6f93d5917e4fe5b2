"""A plate: one figure of the paper redrawn; its words stand in templates."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

from pydantic import JsonValue

from crosscheck.audit.claims.catalogue import CLAIMS
from crosscheck.audit.claims.chapter import COLOURS as VERDICT_COLOURS
from crosscheck.audit.claims.chapter import describe_verdict, format_share, format_value
from crosscheck.audit.claims.rule import Answer, Claim, State, Verdict, evaluate_claim
from crosscheck.audit.experiments.paper_conditions import LABELLED, LAWS, Law
from crosscheck.audit.figures.figure_data import FigureData, make_condition
from crosscheck.audit.measures.undefined import JsonObject
from crosscheck.audit.page.labels import DRAWN_NAMES
from crosscheck.audit.page.text import render_template, to_markup

COLOURS = {State.YES: "agree", State.NO: "differ", State.BISTABLE: "bistable"}


class Drawing(NamedTuple):
    """A drawing as an <svg> element, with what it shows in plain text."""

    svg: str
    caption: str


@dataclass(frozen=True)
class PaperFigure:
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

    def to_html(self, figure_claims: Sequence[FigureClaim]) -> str:
        """The figure's html from <h3> down, with the claims that it is about."""
        return render_template(
            f"figures/figure-{self.number}",
            plate=self,
            svgs=[(to_markup(drawing.svg), drawing.caption) for drawing in self.drawings],
            tables={name: to_markup(table) for name, table in self.tables.items()},
            rows=figure_claims,
            laws=[DRAWN_NAMES[law] for law in LAWS],
            kinds=Counter(str(row.verdict.kind) for row in figure_claims if row.verdict),
            colours=COLOURS,
            verdict_colours=VERDICT_COLOURS,
            value=format_value,
            share=format_share,
            verdict=describe_verdict,
        )

    def to_dict(self, figure_claims: Sequence[FigureClaim]) -> JsonObject:
        """The figure as a JSON object; what the claims say stands in their own records."""
        return {
            "id": f"figure-{self.number}",
            "zeta": self.zeta,
            "start": self.start,
            "drawn": not self.reason,
            "claims": [row.claim.id for row in figure_claims],
            "numbers": dict(self.numbers),
        }


@dataclass(frozen=True)
class FigureClaim:
    """A claim in a setting: its answer by law, {None: ...} if it has none; None: not asked.

    choice: of the claim's free parameter, its default; verdict: over all settings, if asked.
    """

    claim: Claim
    choice: str
    answers: Mapping[Law | None, Answer]
    verdict: Verdict | None

    @property
    def cells(self) -> list[Answer | None]:
        """The claim's answer under every law; of a static claim one answer, not three."""
        if self.claim.static:
            return [self.answers.get(None), *([None] * (len(LAWS) - 1))]
        return [self.answers.get(law) for law in LAWS]


def find_figure_claims(data: FigureData, number: int, zeta: float) -> list[FigureClaim]:
    """A row for every claim of a figure."""
    results_by_condition = [
        (make_condition(law, zeta), entry) for law, entry in data.results_by_law(zeta).items()
    ]
    figure_claims = []
    for claim in CLAIMS:
        if claim.figure == number:
            choice = next(iter(claim.choices))
            answer_by_law = {
                entry.place.law: entry
                for entry in evaluate_claim(claim, results_by_condition)
                if (entry.place.choice, entry.place.arm) == (choice, LABELLED)
            }
            verdict = data.context.judged_claims[claim.id].verdict if data.has_verdicts else None
            figure_claims.append(FigureClaim(claim, choice, answer_by_law, verdict))
    return figure_claims

"""A plate: one figure of the paper redrawn; its words stand in templates."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

from pydantic import JsonValue

from crosscheck.audit.claims.catalogue import CLAIMS
from crosscheck.audit.measures.undefined import JsonObject
from crosscheck.audit.page.text import render_template, to_markup


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

    @property
    def claims(self) -> list[str]:
        """The ids of the claims about the figure."""
        return [claim.id for claim in CLAIMS if claim.figure == self.number]

    def to_html(self) -> str:
        """The figure's html from <h3> down."""
        return render_template(
            f"figures/figure-{self.number}",
            plate=self,
            svgs=[(to_markup(drawing.svg), drawing.caption) for drawing in self.drawings],
            tables={name: to_markup(table) for name, table in self.tables.items()},
        )

    def to_dict(self) -> JsonObject:
        """The figure as a JSON object; what the claims say stands in their own records."""
        return {
            "id": f"figure-{self.number}",
            "zeta": self.zeta,
            "start": self.start,
            "drawn": not self.reason,
            "claims": list(self.claims),
            "numbers": dict(self.numbers),
        }

"""A chapter of the paper's page: text, figures, numbers, and what others may say too."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from crosscheck.audit.claims.rule import Limits, Place, State
from crosscheck.audit.experiments.cells import MODELS, Cell
from crosscheck.audit.measures.third import LARGE, QUANTITY, Third


@dataclass(frozen=True)
class AuditChapter:
    """A chapter: a fragment of html, headings from <h3> down, figures inlined as <svg>.

    records: numbers and verdicts as they go into the JSON file, deterministic, each with an ``id``;
    outcome: what came out, in one sentence for the top of the page; said, numbers: every answer and
    number that another chapter may give, too.
    """

    id: str
    title: str
    html: str
    records: Sequence[Mapping[str, object]] = ()
    outcome: str = ""
    said: Sequence[Said] = ()
    numbers: Sequence[StatedNumber] = ()


@dataclass(frozen=True)
class Said:
    """where: the chapter and what in it; quantity: its id."""

    where: str
    quantity: str
    limits: Limits
    place: Place
    state: State


@dataclass(frozen=True)
class StatedNumber:
    """A number that a sentence states: one quantity in one setting has one value everywhere.

    where: the chapter; quantity and setting: named in words that all chapters use alike.
    """

    where: str
    quantity: str
    setting: str
    value: float | None


def said_of_third(where: str, cell: Cell, found: Third) -> list[Said]:
    """What a chapter states of the third fluctuation, where the claims ask the same."""
    if cell.model not in MODELS:
        return []
    answer = found.answer(Place(cell.law, cell.arm, cell.zeta, "", cell.planets))
    return [Said(where, QUANTITY.id, LARGE, answer.place, answer.state)]

"""A chapter of the paper's report: text, figures and the numbers behind them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol


@dataclass(frozen=True)
class Chapter:
    """``html``: a fragment, headings from <h3> down, figures inlined as <svg>.

    ``records``: numbers and verdicts as they go into the JSON file, deterministic, each with an
    ``id``.
    ``outcome``: what came out, in one sentence for the top of the page.
    """

    id: str
    title: str
    html: str
    records: Sequence[Mapping[str, object]] = ()
    outcome: str = ""


class ChapterNumbers(Protocol):
    """Numbers or a verdict of a chapter."""

    def to_dict(self) -> Mapping[str, object]:
        """As it goes into the JSON file, with an ``id``."""


def rendered(records: Iterable[ChapterNumbers]) -> list[Mapping[str, object]]:
    """All of them, as they go into the JSON file."""
    return [record.to_dict() for record in records]

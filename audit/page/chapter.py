"""A chapter of the paper's page: text, figures and numbers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class AuditChapter:
    """A chapter: a fragment of html, headings from <h3> down, figures inlined as <svg>.

    records: numbers and verdicts as they go into the JSON file, deterministic, each with an ``id``;
    outcome: what came out, in one sentence for the top of the page.
    """

    id: str
    title: str
    html: str
    records: Sequence[Mapping[str, object]] = ()
    outcome: str = ""

"""A chapter of the paper's report: text, figures and the numbers behind them."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any


@dataclass(frozen=True)
class Chapter:
    """``html``: a fragment, headings from <h3> down, figures inlined as <svg>.

    ``records``: JSON-able numbers and verdicts, deterministic, each a dict with an ``id``.
    ``outcome``: what came out, in one sentence for the top of the page.
    """

    id: str
    title: str
    html: str
    records: list[dict[str, Any]] = field(default_factory=list)
    outcome: str = ""

"""Pieces of HTML that the attribution and hypothesis chapters share."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape

import markupsafe

COLOURS = ("#1f5fa8", "#d1702c", "#2f8f5b", "#8a4fb0", "#b03050", "#5a6b7a", "#a08a20")


def render_table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A table of plain texts, or of Markup, that scrolls if it is too wide."""
    lines = "".join(_render_row(row, "td") for row in rows)
    header = _render_row(head, "th")
    return f'<div class="wide" tabindex="0"><table>{header}{lines}</table></div>'


def render_figure(svg: str, caption: str) -> str:
    """A drawing with what it shows."""
    return f'<figure tabindex="0">{svg}<figcaption>{escape(caption)}</figcaption></figure>'


def _render_row(cells: Sequence[str], tag: str) -> str:
    shown = (f"<{tag}>{markupsafe.escape(cell)}</{tag}>" for cell in cells)  # Markup as it is
    return "<tr>" + "".join(shown) + "</tr>"

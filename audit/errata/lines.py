"""The sheet as lines of a terminal: a block for each entry, formulas whole."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator, Sequence

from crosscheck.audit.errata.errata_texts import SheetSection
from crosscheck.audit.page.columns import NONE, list_titles

WIDTH = 79


def format_sections(sections: Sequence[SheetSection], whole: bool) -> Iterator[str]:
    """The lines of all sections, or of the first; how many entries the others then have."""
    for section in sections if whole else sections[:1]:
        yield f"{section.heading}: {len(section.records)}"
        for row in section.list_rows():
            (_, first), *rest = zip(list_titles(section.columns), row, strict=True)
            yield ""
            yield from _wrap(first, "")
            for title, text in rest:
                if text not in ("", NONE):
                    yield from _wrap(f"{title}: {text}", "  ")
        yield ""
    if not whole:
        counts = "; ".join(f"{each.heading}: {len(each.records)}" for each in sections[1:])
        yield from _wrap(f"{counts} (--all prints these too)", "")


def _wrap(text: str, indent: str) -> list[str]:
    """A text wrapped between words; a word that is longer than a line stays whole."""
    return textwrap.wrap(
        text,
        WIDTH,
        initial_indent=indent,
        subsequent_indent=2 * indent,
        break_long_words=False,
        break_on_hyphens=False,
    )

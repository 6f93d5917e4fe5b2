"""Errata as lines of a terminal: the count, then a block for each, formulas whole."""

from __future__ import annotations

import textwrap
from collections import Counter
from collections.abc import Iterator, Sequence

from crosscheck.audit.errata.errata_texts import (
    CONTRADICTIONS_HEADING,
    GAPS_HEADING,
    HEADINGS,
    load_notes,
)
from crosscheck.audit.errata.erratum import CLASSES, ErratumClass, SimulatedErratum
from crosscheck.report import formatting

WIDTH, INDENT = 79, 10


def format_errata(
    errata: Sequence[SimulatedErratum], arm: str, classes: Sequence[ErratumClass]
) -> Iterator[str]:
    """The lines of the errata of these classes; how many there are of the others."""
    counts = Counter(entry.erratum.kind for entry in errata)
    errors = formatting.format_count(counts["equation"], "error")
    yield f"{errors} of equations (arm {arm}), the largest effect on an angle first"
    for kind in classes:
        if kind != "equation":
            yield f"\n{HEADINGS[kind]}: {counts[kind]}"
        for entry in errata:
            if entry.erratum.kind == kind:
                yield ""
                yield from format_erratum(entry)
    is_whole = len(classes) == len(CLASSES)
    if is_whole:
        yield from _format_notes()
    summary = "; ".join(f"{HEADINGS[kind]}: {counts[kind]}" for kind in CLASSES)
    rest = "" if is_whole else " (--all prints these too)"
    yield ""
    yield from textwrap.wrap(f"{summary}{rest}; arm {arm}", WIDTH)


def _format_notes() -> Iterator[str]:
    """Where the text contradicts itself, and what it does not give."""
    noted = load_notes()
    yield f"\n{CONTRADICTIONS_HEADING}: {len(noted.contradictions)}"
    for contradiction in noted.contradictions:
        yield ""
        yield from _format_field("here", f"{contradiction.first}: {contradiction.first_says}")
        yield from _format_field("there", f"{contradiction.second}: {contradiction.second_says}")
    yield f"\n{GAPS_HEADING}: {len(noted.gaps)}"
    for gap in noted.gaps:
        yield ""
        yield from textwrap.wrap(f"{gap.quantity} (needed for {gap.needed_for})", WIDTH)
        yield from _format_field("here", gap.here)


def format_erratum(simulated_erratum: SimulatedErratum) -> Iterator[str]:
    """The block of one erratum: where, what is printed, what is right, how much it matters."""
    erratum = simulated_erratum.erratum
    yield erratum.where
    yield from _format_field("printed", erratum.printed)
    yield from _format_field("right", erratum.derived)
    yield from _format_field("", erratum.remark)
    if erratum.size is not None:
        yield from _format_field(
            "size", f"{formatting.format_rounded(erratum.size, 3)} {erratum.unit}".rstrip()
        )
    for scenario, effect in simulated_erratum.effects.items():
        moved = f"angle {effect.theta_rad:.2g} rad"
        pushed = f"impulse of a mesh {effect.impulse_N_s:.2g} N s"
        yield from _format_field("effect", f"{scenario}: {moved}, {pushed}")


def _format_field(name: str, text: str) -> Iterator[str]:
    """A named text, wrapped between words; a word that is longer than a line stays whole."""
    if text:
        yield from textwrap.wrap(
            text,
            WIDTH,
            initial_indent=f"  {name}".ljust(INDENT),
            subsequent_indent=" " * INDENT,
            break_long_words=False,
            break_on_hyphens=False,
        )

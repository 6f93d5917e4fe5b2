"""Phrases that all views share: counts, and a finding in words."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:  # words for `init` need no results
    from crosscheck.findings import Agreement, Finding


def format_count(number: int, noun: str) -> str:
    """A number with its noun, such as `1 check` or `2 checks`."""
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"


def join_words(words: Sequence[str]) -> str:
    """Words as `a, b and c`."""
    return " and ".join(filter(None, (", ".join(words[:-1]), *words[-1:])))


def list_first(words: Sequence[str], most: int = 5) -> str:
    """The first few words, and how many more, such as `a, b and 3 more`."""
    rest = len(words) - most
    return f"{', '.join(words[:most])}{f' and {rest} more' if rest > 0 else ''}"


def describe_tally(agreement: Agreement) -> str:
    """Number of checks that agree, and of those that were not judged, in words."""
    total = len(agreement.checks)
    agreeing = total - len(agreement.disagreeing)
    unfinished = sum(finding.verdict == "unfinished" for finding in agreement.checks)
    unjudged = f"; {unfinished} unfinished, not judged" if unfinished else ""
    verb = "agrees" if total == 1 else "agree"
    return f"{agreeing} of {format_count(total, 'check')} {verb}{unjudged}"


def format_unit(unit: str) -> str:
    """A unit as people write it: rad/s for `rad s-1`; nothing for the unit of a plain number."""
    return "" if unit == "1" else unit.replace(" s-1", "/s").replace(" s-2", "/s²")


def describe_outcome(finding: Finding) -> str:
    """The numbers behind a verdict, in the form that the verdict needs, and the note.

    An unresolved one lies within its tolerance, but that tolerance means nothing: read as
    "measured, allowed" it would look like a pass.
    """
    if finding.measured is None or finding.tolerance is None:
        return finding.note
    measured = f"measured {finding.measured:.3g}"
    allowed = f"{finding.tolerance:.3g} {format_unit(finding.unit)}".rstrip()
    text = f"{measured}, allowed {allowed}"
    if finding.verdict == "unresolved":
        text = f"the uncertainty itself, {allowed}, exceeds the acceptance limit ({measured})"
    return "; ".join(filter(None, (text, finding.note)))


def format_rounded(value: float, digits: int = 2) -> str:
    """A number of so many digits, written without an exponent where people would."""
    return f"{float(f'{value:.{digits}g}'):.15g}" if math.isfinite(value) else "no number"


def format_percent(relative: float) -> str:
    """A relative difference in per cent, two digits."""
    return f"{format_rounded(100 * relative)} %" if math.isfinite(relative) else "no number"


def format_length(metres: float) -> str:
    """A length of three digits in m, mm or µm; what is below a nanometre is rounding."""
    if 0 < abs(metres) < 1e-9:
        return "less than 1 nm"
    for unit, size in (("m", 1.0), ("mm", 1e-3)):
        if abs(metres) >= (size if size == 1.0 else 1e-2 * size):
            return f"{format_rounded(metres / size, 3)} {unit}"
    return f"{format_rounded(1e6 * metres, 3)} µm"


def format_number(value: float | None) -> str:
    """A number with three digits, for reading; empty for None."""
    return "" if value is None else f"{value:.3g}"

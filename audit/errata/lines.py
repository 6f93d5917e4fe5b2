"""Errata as lines of a terminal: the count, then a block for each, formulas whole."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator, Sequence

from crosscheck.audit.errata.erratum import CLASSES, Class, SimulatedErratum
from crosscheck.audit.errata.sheet import HEADINGS, SheetCounts, counted
from crosscheck.report import words

WIDTH, INDENT = 79, 10


def errata_lines(
    found: Sequence[SimulatedErratum], arm: str, kinds: Sequence[Class]
) -> Iterator[str]:
    """The lines of the errata of these classes; how many there are of the others."""
    counts = counted(found)
    errors = words.counted(counts.by_class["equation"], "error")
    yield f"{errors} of equations (arm {arm}), the largest effect on an angle first"
    for kind in kinds:
        if kind != "equation":
            yield f"\n{HEADINGS[kind]}: {counts.by_class[kind]}"
        for one in found:
            if one.erratum.kind == kind:
                yield ""
                yield from erratum_lines(one)
    yield ""
    yield from textwrap.wrap(_summary(counts, kinds, arm), WIDTH)


def _summary(counts: SheetCounts, kinds: Sequence[Class], arm: str) -> str:
    said = "; ".join(f"{HEADINGS[kind]}: {count}" for kind, count in counts.by_class.items())
    rest = "" if len(kinds) == len(CLASSES) else " (--all prints these too)"
    return f"{said}{rest}; arm {arm}"


def erratum_lines(one: SimulatedErratum) -> Iterator[str]:
    """The block of one erratum: where, what is printed, what is right, how much it matters."""
    erratum = one.erratum
    yield erratum.where
    yield from _field("printed", erratum.printed)
    yield from _field("right", erratum.derived)
    yield from _field("", erratum.remark)
    if erratum.size is not None:
        yield from _field("size", f"{words.rounded(erratum.size, 3)} {erratum.unit}".rstrip())
    for scenario, effect in one.effects.items():
        moved = f"angle {effect.theta_rad:.2g} rad"
        pushed = f"impulse of a mesh {effect.impulse_N_s:.2g} N s"
        yield from _field("effect", f"{scenario}: {moved}, {pushed}")


def _field(name: str, text: str) -> Iterator[str]:
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

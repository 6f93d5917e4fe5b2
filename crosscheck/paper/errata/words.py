"""What the sheet says of slips that are found by numbers alone: slips.toml, by their ids."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path

from crosscheck.paper.errata.erratum import Erratum, Slip

FILE = Path(__file__).with_name("slips.toml")


def in_words(slips: Sequence[Slip]) -> tuple[Slip, ...]:
    """With what the sheet says of each."""
    return tuple(replace(slip, erratum=told(slip.erratum)) for slip in slips)


def told(erratum: Erratum) -> Erratum:
    """The slip in words, its numbers put in; one that has words already as it is.

    Raises KeyError for one that the file does not know.
    """
    if erratum.printed:
        return erratum
    said = {name: text.format_map(erratum.numbers) for name, text in _words()[erratum.id].items()}
    return replace(erratum, **said)


@cache
def _words() -> Mapping[str, Mapping[str, str]]:
    """Texts of a slip: where, printed, derived, remark; TeX with its braces doubled."""
    return tomllib.loads(FILE.read_text(encoding="utf-8"))

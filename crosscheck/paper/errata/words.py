"""What the sheet says of slips that are found by numbers alone: slips.toml, by their ids."""

from __future__ import annotations

import tomllib
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

from pydantic import TypeAdapter

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
    said, numbers = _words()[erratum.id], erratum.numbers
    return replace(
        erratum,
        where=said.where,
        printed=said.printed.format_map(numbers),
        derived=said.derived.format_map(numbers),
        remark=said.remark.format_map(numbers),
    )


@dataclass(frozen=True)
class Words:
    """Texts of a slip, as in ``Erratum``, with places for its numbers."""

    where: str
    printed: str
    derived: str
    remark: str = ""


@cache
def _words() -> dict[str, Words]:
    """By the slips' ids."""
    content = tomllib.loads(FILE.read_text(encoding="utf-8"))
    return TypeAdapter(dict[str, Words]).validate_python(content)

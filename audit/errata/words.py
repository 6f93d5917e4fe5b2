"""What the sheet says of slips that are found by numbers alone: slips.toml, by their ids."""

from __future__ import annotations

import tomllib
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

from pydantic import TypeAdapter

from audit.errata.erratum import Erratum, Slip

FILE = Path(__file__).with_name("slips.toml")


def in_words(slips: Sequence[Slip]) -> tuple[Slip, ...]:
    """With what the sheet says of each."""
    return tuple(replace(slip, erratum=told(slip.erratum)) for slip in slips)


def told(erratum: Erratum) -> Erratum:
    """The slip in words, with what they quote; one that has words already as it is.

    Raises KeyError for one that the file does not know.
    """
    if erratum.printed:
        return erratum
    kind, _, _ = erratum.id.partition("-")
    said = _words().get(erratum.id) or _words()[kind]
    return replace(
        erratum,
        where=said.where.format_map(erratum.quoted),
        printed=said.printed.format_map(erratum.quoted),
        derived=said.derived.format_map(erratum.quoted),
        remark=said.remark.format_map(erratum.quoted),
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
    """By the slips' ids, or by what these begin with."""
    content = tomllib.loads(FILE.read_text(encoding="utf-8"))
    return TypeAdapter(dict[str, Words]).validate_python(content)

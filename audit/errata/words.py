"""The sheet's texts: words of computed errata, misprints, contradictions and gaps."""

from __future__ import annotations

import tomllib
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

from pydantic import TypeAdapter

from crosscheck.audit.errata.erratum import CLASSES, Class, Erratum, SimulatedErratum

FOLDER = Path(__file__).with_name("texts")
WORDS, NOTES = FOLDER / "errata.toml", FOLDER / "notes.toml"


@dataclass(frozen=True)
class Contradiction:
    """Two places of the paper that cannot both be right, paraphrased."""

    id: str
    first: str
    first_says: str
    second: str
    second_says: str


@dataclass(frozen=True)
class Gap:
    """A quantity that a reader needs and the paper does not give, and what this project does."""

    id: str
    quantity: str
    needed_for: str
    here: str


@dataclass(frozen=True)
class Notes:
    """What a careful reader finds in the text itself; misprints need no number."""

    misprints: tuple[Erratum, ...]
    contradictions: tuple[Contradiction, ...]
    gaps: tuple[Gap, ...]


@cache
def notes() -> Notes:
    """The misprints, contradictions and gaps of notes.toml."""
    return TypeAdapter(Notes).validate_python(tomllib.loads(NOTES.read_text(encoding="utf-8")))


@dataclass(frozen=True)
class Words:
    """Texts of a computed erratum, as in ``Erratum``, with places for its numbers."""

    kind: Class
    where: str
    printed: str
    derived: str
    remark: str = ""
    unit: str = ""


@cache
def _words() -> dict[str, Words]:
    """The words of computed errata, by their ids or by what these begin with."""
    known = tomllib.loads(WORDS.read_text(encoding="utf-8"))
    return TypeAdapter(dict[str, Words]).validate_python(known)


def in_words(computed: Sequence[SimulatedErratum]) -> tuple[SimulatedErratum, ...]:
    """Computed errata in the sheet's words, and those found by reading alone, sorted by class."""
    found = [replace(one, erratum=told(one.erratum)) for one in computed]
    found += [SimulatedErratum(one, {}) for one in notes().misprints]
    return tuple(sorted(found, key=lambda one: CLASSES.index(one.erratum.kind)))


def told(erratum: Erratum) -> Erratum:
    """The erratum in words, with what they quote; one that has words already as it is.

    Raises KeyError for one that the file does not know.
    """
    if erratum.printed:
        return erratum
    kind, _, _ = erratum.id.partition("-")
    said = _words().get(erratum.id) or _words()[kind]
    texts = {name: words.format_map(erratum.quoted) for name, words in vars(said).items()}
    return replace(erratum, **texts)

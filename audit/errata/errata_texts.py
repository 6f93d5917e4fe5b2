"""The sheet's texts: words of computed errata, misprints, contradictions and gaps."""

from __future__ import annotations

import tomllib
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

from pydantic import TypeAdapter

from crosscheck.audit.errata.erratum import CLASSES, Erratum, ErratumClass, SimulatedErratum

FOLDER = Path(__file__).with_name("texts")
WORDS, NOTES = FOLDER / "errata.toml", FOLDER / "notes.toml"
HEADINGS: dict[ErratumClass, str] = {
    "equation": "Errors of equations",
    "statement": "Statements and data without support",
    "notation": "Notation that misleads",
}
CONTRADICTIONS_HEADING = "Where the text contradicts itself"
GAPS_HEADING = "What the text does not give"


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
def load_notes() -> Notes:
    """The misprints, contradictions and gaps of notes.toml."""
    return TypeAdapter(Notes).validate_python(tomllib.loads(NOTES.read_text(encoding="utf-8")))


@dataclass(frozen=True)
class ErratumText:
    """Texts of a computed erratum, as in ``Erratum``, with places for its numbers."""

    kind: ErratumClass
    where: str
    printed: str
    derived: str
    remark: str = ""
    unit: str = ""
    denies: tuple[str, ...] = ()


@cache
def _load_texts() -> dict[str, ErratumText]:
    """The words of computed errata, by their ids or by what these begin with."""
    tables = tomllib.loads(WORDS.read_text(encoding="utf-8"))
    return TypeAdapter(dict[str, ErratumText]).validate_python(tables)


def add_errata_texts(computed: Sequence[SimulatedErratum]) -> tuple[SimulatedErratum, ...]:
    """Computed errata in the sheet's words, and those found by reading alone, sorted by class."""
    errata = [replace(entry, erratum=add_erratum_text(entry.erratum)) for entry in computed]
    errata += [SimulatedErratum(entry, {}) for entry in load_notes().misprints]
    return tuple(sorted(errata, key=lambda row: CLASSES.index(row.erratum.kind)))


def add_erratum_text(erratum: Erratum) -> Erratum:
    """The erratum in words, with what they quote; one that has words already as it is.

    Raises KeyError for one that the file does not know.
    """
    if erratum.printed:
        return erratum
    kind, _, _ = erratum.id.partition("-")
    erratum_text = _load_texts().get(erratum.id) or _load_texts()[kind]
    texts = {
        name: words.format_map(erratum.quoted)
        for name, words in vars(erratum_text).items()
        if name != "denies"
    }
    return replace(erratum, denies=erratum_text.denies, **texts)


@dataclass(frozen=True)
class SheetCounts:
    """How many errata of each class, how many read alone, contradictions and gaps."""

    by_class: Mapping[ErratumClass, int]
    read: int
    contradictions: int
    gaps: int


def count_errata(errata: Sequence[SimulatedErratum]) -> SheetCounts:
    """The counts of a sheet's errata, contradictions and gaps."""
    noted, class_counts = (
        load_notes(),
        Counter(simulated_erratum.erratum.kind for simulated_erratum in errata),
    )
    read = {misprint.id for misprint in noted.misprints}
    return SheetCounts(
        {kind: class_counts[kind] for kind in CLASSES},
        sum(simulated_erratum.erratum.id in read for simulated_erratum in errata),
        len(noted.contradictions),
        len(noted.gaps),
    )

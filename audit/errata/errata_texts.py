"""The sheet's texts: words of computed errata, misprints, contradictions and gaps."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

from pydantic import TypeAdapter

from crosscheck.audit.errata.erratum import CLASSES, Erratum, ErratumClass, SimulatedErratum
from crosscheck.models.files import read_toml

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
    return TypeAdapter(Notes).validate_python(read_toml(NOTES))


@cache
def _load_texts() -> dict[str, Erratum]:
    """Computed errata in words with places for numbers, by ids or by what these begin with."""
    texts = {name: {"id": name, **table} for name, table in read_toml(WORDS).items()}
    return TypeAdapter(dict[str, Erratum]).validate_python(texts)


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
    told = _load_texts().get(erratum.id) or _load_texts()[kind]
    where, printed, derived, remark, unit = (
        words.format_map(erratum.quoted)
        for words in (told.where, told.printed, told.derived, told.remark, told.unit)
    )
    return replace(
        erratum,
        kind=told.kind,
        where=where,
        printed=printed,
        derived=derived,
        remark=remark,
        unit=unit,
        denies=told.denies,
    )

"""The paper sentence by sentence: what claims or errata each leads to, or why it asserts nothing.

Captions and the table count as sentences. The files beside this module are in the paper's order.
"""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Self

from pydantic import TypeAdapter, model_validator
from pydantic.dataclasses import dataclass as validated_dataclass

FOLDER = Path(__file__).parent
FILES = ("front", "section2", "section3", "control", "section4", "section5")


@validated_dataclass(frozen=True)
class Sentence:
    """A sentence of the paper.

    Attributes:
        section: Number of its section.
        number: Its place in the section, from 1.
        begins: Its first words, at most four.
        claims: Ids of the claims that it makes.
        errata: Ids of the entries of the errata sheet that it leads to.
        none: Why it leads to neither, where it does not.
    """

    section: str
    number: int
    begins: str
    claims: tuple[str, ...] = ()
    errata: tuple[str, ...] = ()
    none: str = ""

    @model_validator(mode="after")
    def _check_reason(self) -> Self:
        if bool(self.none) == bool(self.claims or self.errata):
            raise ValueError("needs claims or errata, or else a reason for none")
        return self


@dataclass(frozen=True)
class _SentenceFile:
    sentences: tuple[Sentence, ...]


def load_sentences() -> list[Sentence]:
    """Load all sentences. Raises ValueError for an entry that is not as ``Sentence`` says."""
    return [sentence for name in FILES for sentence in _load_file(name)]


def _load_file(name: str) -> tuple[Sentence, ...]:
    text = (FOLDER / f"{name}.toml").read_text(encoding="utf-8")
    return TypeAdapter(_SentenceFile).validate_python(tomllib.loads(text)).sentences

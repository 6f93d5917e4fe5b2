"""The paper sentence by sentence: what claims or errata each leads to, or why it asserts nothing.

Captions and the table count as sentences.
"""

from __future__ import annotations

from pathlib import Path
from typing import Self

from pydantic import TypeAdapter, model_validator
from pydantic.dataclasses import dataclass

from crosscheck.models.files import read_toml


@dataclass(frozen=True)
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


def load_sentences(file: Path) -> tuple[Sentence, ...]:
    """All sentences of a file, in the paper's order.

    Raises ValueError for an entry that is not as ``Sentence`` says.
    """
    return TypeAdapter(tuple[Sentence, ...]).validate_python(read_toml(file)["sentences"])

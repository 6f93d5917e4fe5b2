"""The paper sentence by sentence: what claims or errata each leads to, or why it asserts nothing.

Captions and the table count as sentences.
"""

from __future__ import annotations

import tomllib
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Self

from pydantic import TypeAdapter, model_validator
from pydantic.dataclasses import dataclass as validated_dataclass


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


def load_sentences(files: Iterable[Path]) -> list[Sentence]:
    """Load all sentences of files in the paper's order.

    Raises ValueError for an entry that is not as ``Sentence`` says.
    """
    adapter = TypeAdapter(_SentenceFile)
    tables = (tomllib.loads(file.read_text(encoding="utf-8")) for file in files)
    return [sentence for table in tables for sentence in adapter.validate_python(table).sentences]

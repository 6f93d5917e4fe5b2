"""The paper sentence by sentence: which claims or slips each leads to, or why it asserts nothing.

Captions and the table count as sentences. The files lie in ``sentences/``, in the paper's order.
"""

import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Self

from pydantic import TypeAdapter, model_validator
from pydantic.dataclasses import dataclass as checked

FOLDER = Path(__file__).with_name("sentences")
FILES = ("front", "section2", "section3", "control", "section4", "section5")


@checked(frozen=True)
class Sentence:
    """One of a section's, numbered from 1; begins: its first words, at most four.

    claims, slips: ids of what it leads to; none: why it leads to nothing, alone.
    """

    section: str
    number: int
    begins: str
    claims: tuple[str, ...] = ()
    slips: tuple[str, ...] = ()
    none: str = ""

    @model_validator(mode="after")
    def _leads_somewhere_or_says_why_not(self) -> Self:
        if bool(self.none) == bool(self.claims or self.slips):
            raise ValueError("needs claims or slips, or else a reason for none")
        return self


@dataclass(frozen=True)
class _File:
    sentences: tuple[Sentence, ...]


def sentences() -> list[Sentence]:
    """All of them. Raises ValueError for an entry that is not as ``Sentence`` says."""
    return [sentence for name in FILES for sentence in _read(name)]


def _read(name: str) -> tuple[Sentence, ...]:
    text = (FOLDER / f"{name}.toml").read_text(encoding="utf-8")
    return TypeAdapter(_File).validate_python(tomllib.loads(text)).sentences

"""What a careful reader finds in the text itself: contradictions, and what is missing."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from pydantic import TypeAdapter

FILE = Path(__file__).with_name("notes.toml")


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
    """All of both."""

    contradictions: tuple[Contradiction, ...]
    gaps: tuple[Gap, ...]


@cache
def notes() -> Notes:
    """Of notes.toml."""
    return TypeAdapter(Notes).validate_python(tomllib.loads(FILE.read_text(encoding="utf-8")))

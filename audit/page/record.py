"""Records: what a chapter found, under names; JSON only where it is written, or was kept."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import asdict, dataclass
from typing import TypeVar

from pydantic import JsonValue, TypeAdapter

JsonObject = dict[str, JsonValue]
Kept = TypeVar("Kept")


@dataclass(frozen=True)
class ChapterRecord(ABC):
    """Numbers and verdicts of a chapter; a subclass's fields are the names in its JSON."""

    @property
    @abstractmethod
    def id(self) -> str:
        """Names the record in claims.json; written, never read."""

    def to_dict(self) -> JsonObject:
        """For JSON."""
        return {"id": self.id, **asdict(self)}


def read(kind: type[Kept], answer: object) -> Kept:
    """A dataclass from its fields as JSON. Raises ValueError for what is no such thing."""
    return TypeAdapter(kind).validate_python(answer)

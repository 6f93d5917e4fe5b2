"""Tables of records: one list of columns gives JSON, a table of the page, and Markdown."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Generic, TypeVar

from pydantic import JsonValue

from crosscheck.audit.measures.undefined import JsonObject, recorded
from crosscheck.report import fragments

Row = TypeVar("Row")
Value = float | int | str | bool | None | tuple[float | None, ...]
NONE = "-"


@dataclass(frozen=True)
class TableColumn(Generic[Row]):
    """name: in JSON; title: above a table, with its unit; None: not shown there.

    of: a row's value, None or not finite for what is undefined; by default its attribute of this
    name. form: how a number is written.
    """

    name: str
    title: str | None
    of: Callable[[Row], Value] | None = None
    form: str = ".3g"

    def value(self, row: Row) -> Value:
        """Of a row."""
        found: Value = getattr(row, self.name) if self.of is None else self.of(row)
        return found

    def json(self, row: Row) -> JsonValue:
        """The value; None for what is undefined."""
        return recorded(self.value(row))

    def text(self, row: Row) -> str:
        """The value as it is read."""
        return _text(self.value(row), self.form)

    def html(self, row: Row) -> str:
        """A cell of a table: text, or Markup that is html already."""
        return self.text(row)

    def markdown(self, row: Row) -> str:
        """A cell of a table in Markdown."""
        return self.text(row).replace("|", r"\|")


@dataclass(frozen=True)
class Columns(Generic[Row]):
    """id: names a row in JSON."""

    id: Callable[[Row], str]
    columns: Sequence[TableColumn[Row]]

    def json(self, rows: Iterable[Row]) -> list[JsonObject]:
        """A record for every row."""
        return [
            {"id": self.id(row), **{column.name: column.json(row) for column in self.columns}}
            for row in rows
        ]

    def html(self, rows: Iterable[Row], caption: str = "") -> str:
        """A table of the page."""
        body = [[column.html(row) for column in self._shown()] for row in rows]
        return fragments.table([column.title or "" for column in self._shown()], body, caption)

    def markdown(self, rows: Iterable[Row]) -> str:
        """The same as text."""
        head = [column.title or "" for column in self._shown()]
        body = [[column.markdown(row) for column in self._shown()] for row in rows]
        lines = [head, ["---"] * len(head), *body]
        return "\n".join("| " + " | ".join(cells) + " |" for cells in lines)

    def _shown(self) -> list[TableColumn[Row]]:
        return [column for column in self.columns if column.title is not None]


def _text(value: Value, form: str) -> str:
    if value is None or (isinstance(value, float) and not math.isfinite(value)):
        return NONE
    if isinstance(value, tuple):
        return " … ".join(_text(part, form) for part in value)
    if isinstance(value, bool):
        return "yes" if value else "no"
    return format(value, form) if isinstance(value, float) else str(value)

"""Tables of records: one list of columns gives JSON, a table of the page, and Markdown."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from operator import attrgetter
from typing import Generic, TypeVar

from markupsafe import Markup
from pydantic import JsonValue

from crosscheck.audit.measures.undefined import JsonObject, to_json
from crosscheck.report import fragments

Row = TypeVar("Row")
Value = float | int | str | bool | None | tuple[float | None, ...]
NONE = "-"


@dataclass(frozen=True)
class TableColumn(Generic[Row]):
    """A column. name: in JSON; title: above a table, with its unit; None: not shown there.

    of: a row's value, None or not finite for what is undefined; or its path in the row; empty: the
    column's name.
    form: how a number is written.
    """

    name: str
    title: str | None
    of: Callable[[Row], Value] | str = ""
    form: str = ".3g"

    def value(self, row: Row) -> Value:
        """The value of a row in this column."""
        of = attrgetter(self.of or self.name) if isinstance(self.of, str) else self.of
        value: Value = of(row)
        return value

    def json(self, row: Row) -> JsonValue:
        """The value for JSON; None for what is undefined."""
        return to_json(self.value(row))

    def text(self, row: Row) -> str:
        """The value in words or digits, as it is read."""
        return _format_value(self.value(row), self.form)

    def html(self, row: Row) -> str:
        """The cell of a table: text, or Markup that is html already."""
        return self.text(row)

    def markdown(self, row: Row) -> str:
        """The cell of a table in Markdown."""
        return self.text(row).replace("|", r"\|")


@dataclass(frozen=True)
class Columns(Generic[Row]):
    """The columns of a table. id: a row's name in JSON."""

    id: Callable[[Row], str]
    columns: Sequence[TableColumn[Row]]

    def json(self, rows: Iterable[Row]) -> list[JsonObject]:
        """The rows as JSON, a record for each."""
        return [
            {"id": self.id(row), **{column.name: column.json(row) for column in self.columns}}
            for row in rows
        ]

    def html(self, rows: Iterable[Row]) -> Markup:
        """The rows as a table of the page."""
        body = [[column.html(row) for column in self._visible_columns()] for row in rows]
        return Markup(fragments.render_table(self._head(), body))

    def markdown(self, rows: Iterable[Row]) -> str:
        """The rows as a table in Markdown."""
        head = self._head()
        body = [[column.markdown(row) for column in self._visible_columns()] for row in rows]
        lines = [head, ["---"] * len(head), *body]
        return "\n".join("| " + " | ".join(cells) + " |" for cells in lines)

    def _visible_columns(self) -> list[TableColumn[Row]]:
        return [column for column in self.columns if column.title is not None]

    def _head(self) -> list[str]:
        return [column.title or "" for column in self._visible_columns()]


def _format_value(value: Value, form: str) -> str:
    if value is None or (isinstance(value, float) and not math.isfinite(value)):
        return NONE
    if isinstance(value, tuple):
        return " … ".join(_format_value(part, form) for part in value)
    if isinstance(value, bool):
        return "yes" if value else "no"
    return format(value, form) if isinstance(value, float) else str(value)

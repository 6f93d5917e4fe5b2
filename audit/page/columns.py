"""Tables of records: one list of columns gives JSON, a table of the page, and Markdown."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

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

    of: a row's value, None or not finite for what is undefined; or its path in the row,
    ``setting.cell.zeta`` or ``gains.0``, undefined where a part of it is None; empty: the column's
    name.
    form: how a number is written.
    """

    name: str
    title: str | None
    of: Callable[[Row], Value] | str = ""
    form: str = ".3g"

    def value(self, row: Row) -> Value:
        """The value of a row in this column."""
        return resolve_path(row, self.of or self.name) if isinstance(self.of, str) else self.of(row)

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


def resolve_path(row: object, path: str) -> Value:
    """The value to which a path of attributes and places leads from a row; None if one is None."""
    value: Any = row
    for name in path.split("."):
        if value is not None:
            value = value[int(name)] if name.isdecimal() else getattr(value, name)
    return value


@dataclass(frozen=True)
class Columns(Generic[Row]):
    """The columns of a table. id: a row's name in JSON, or its format, the row being ``{0}``."""

    id: Callable[[Row], str] | str
    columns: Sequence[TableColumn[Row]]

    def json(self, rows: Iterable[Row]) -> list[JsonObject]:
        """The rows as JSON, a record for each."""
        named = self.id.format if isinstance(self.id, str) else self.id
        return [
            {"id": named(row), **{column.name: column.json(row) for column in self.columns}}
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

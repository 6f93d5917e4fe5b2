"""Tables of records: which of their fields stand in which column."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from markupsafe import Markup

from crosscheck.audit.measures.undefined import JsonObject
from crosscheck.report import fragments

Columns = Mapping[str, tuple[str, str]]  # by field: title, with its unit; how a number is written
NONE = "-"


def list_titles(columns: Columns) -> list[str]:
    """What stands above a table."""
    return [title for title, _ in columns.values()]


def format_cells(columns: Columns, record: Mapping[str, object]) -> list[str]:
    """A record as a row of a table, as it is read."""
    return [
        NONE if record[name] is None else format(record[name], form)
        for name, (_, form) in columns.items()
    ]


def render_records(columns: Columns, records: Iterable[JsonObject]) -> Markup:
    """The records as a table of the page."""
    rows = [format_cells(columns, record) for record in records]
    return Markup(fragments.render_table(list_titles(columns), rows))

"""Tables of records: which of their fields stand in which column."""

from __future__ import annotations

from collections.abc import Mapping

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

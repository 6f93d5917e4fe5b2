"""A view's text as a snapshot keeps it: what a reader sees, without what a machine measured."""

import re

from tests.views.walker import Page

# Numbers that rounding may change: with decimals or an exponent, of three digits or more, zero, and
# how many digits agree or members are run a second.
MEASURED = re.compile(
    r"(?<![\w./])[-+]?(?:\d+\.\d+(?:e[-+]?\d+)?|\d+e[-+]?\d+|\d[\d,]{2,}|0(?![\w.])"
    r"|\d+(?= digits| a second))"
)
FOLDERS = re.compile(r"(?<![\w.])/\S+/")  # of this machine


def mask_numbers(text: str) -> str:
    """The text with # for every number that is measured, and with no room for their digits."""
    return re.sub(r"(?<=\S) {2,}", "  ", MEASURED.sub("#", FOLDERS.sub(".../", text)))


def list_lines(text: str) -> str:
    """The lines of a text; of a page its blocks, and of each table the heads of its columns.

    The cells are the walker's. Where and when a page was made stands at its end.
    """
    if not text.lstrip().startswith("<"):
        return "\n".join(line.rstrip() for line in text.splitlines())
    lines, tables = [], dict[str, dict[str, None]]()
    for piece in Page(text).pieces:
        if piece.text == "Provenance":
            break
        table = piece.place.partition(",")[0]
        if not piece.scope:
            lines.append(piece.text)
        elif table in tables:
            tables[table][piece.head] = None
        else:
            tables[table] = {piece.head: None}
            lines.append(table)
    heads = {table: " | ".join(["columns", *own]) for table, own in tables.items()}
    return "\n".join(heads.get(line, line) for line in lines)

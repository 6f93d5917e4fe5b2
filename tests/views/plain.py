"""A view's text as a snapshot keeps it: what a reader sees, without what a machine measured."""

import json
import re
from collections.abc import Iterator
from typing import Any

from tests.views.shown_numbers import Page

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
    """The lines of a text; of a page its blocks and rows; of JSON its innermost objects and lists.

    Where and when a page was made stands at its end, and in JSON under keys.
    """
    if text.startswith("{"):
        return "\n".join(_list_objects(json.loads(text), ""))
    if text.startswith("<?xml") or not text.lstrip().startswith("<"):
        return "\n".join(line.rstrip() for line in text.splitlines())
    lines = Page(text).lines
    return "\n".join(lines[: lines.index("Provenance")] if "Provenance" in lines else lines)


def _list_objects(value: Any, place: str) -> Iterator[str]:
    parts = dict(enumerate(value)) if isinstance(value, list) else value
    if not isinstance(value, dict | list) or not any(
        isinstance(each, dict | list) for each in parts.values()
    ):
        yield f"{place}: {json.dumps(value, ensure_ascii=False)}"
        return
    for key, each in parts.items():
        if key not in ("provenance", "program"):
            yield from _list_objects(each, f"{place}.{key}".lstrip("."))

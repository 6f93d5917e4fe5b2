"""Where a part of a user's equations stands in their file."""

from __future__ import annotations

import inspect
import linecache
import re
import textwrap
from pathlib import Path
from typing import NamedTuple

import crosscheck
from crosscheck.trial.input.equations import Equations

PACKAGE = Path(crosscheck.__file__).parent
MOST_LINES = 30
NUMBER = re.compile(r"\d*\.?\d+(?:[eE][-+]?\d+)?")
FUNCTIONS = {
    "mass_matrix": ("mass_matrix",),
    "bias": ("bias", "coriolis"),
    "gravity": ("gravity",),
    "force": ("force",),
}


class SourceLines(NamedTuple):
    """A function of the user's: its file's name, its first line's number, its lines."""

    file: str
    first: int
    lines: tuple[str, ...]


def find_source(equations: Equations, part: str) -> SourceLines | None:
    """The lines of the function that answers a part; None where it has none in the user's file."""
    for name in FUNCTIONS.get(part, ()):
        function = getattr(equations, name)
        try:
            code = inspect.unwrap(function).__code__
            lines, first = inspect.getsourcelines(code)
        except (AttributeError, OSError, TypeError):  # none, built in, or made from symbols
            continue
        if PACKAGE in Path(code.co_filename).parents:  # as of a table or an FMU
            continue
        shown = textwrap.dedent("".join(lines)).splitlines()
        more = ["..."] if len(shown) > MOST_LINES else []
        return SourceLines(Path(code.co_filename).name, first, (*shown[:MOST_LINES], *more))
    return None


def has_literal(equations: Equations, part: str, value: float) -> bool:
    """Whether a number, of either sign, is written in the file of the function of a part."""
    for name in FUNCTIONS.get(part, (part,)):
        code = getattr(inspect.unwrap(getattr(equations, name)), "__code__", None)
        text = "".join(linecache.getlines(code.co_filename)) if code else ""
        if abs(value) in map(float, NUMBER.findall(text)):
            return True
    return False

"""Errors that are not the program's fault: one clear line each."""

from __future__ import annotations

import re
from collections.abc import Sequence

LONGEST_LINE = 400
PROGRAM = "crosscheck: "  # beginning of every error line
GAP = "..."
# How pydantic says what it does not accept, and how this program does.
PHRASES = {
    r", unable to parse string as an? \w+": "",
    "Input should be a valid integer": "must be an integer",
    "Input should be a valid": "must be a",
    "Input should be": "must be",
    "less than or equal to": "at most",
    "greater than or equal to": "at least",
}


def format_install_command(extra: str) -> str:
    """The command that installs an optional dependency, in the folder that holds the project."""
    return f".venv/bin/pip install -e '.[{extra}]'"


class InputError(ValueError):
    """Something the user gave cannot be used.

    ``str(error)`` is one printable line of all four; whatever of them is too long is cut in its
    middle.

    Args:
        where: The file or option, or the model.
        field: The field or argument, '' where there is none.
        value: Its value; None shows none.
        allowed: What is allowed, or what is wrong.
    """

    def __init__(self, where: str, field: str, value: object, allowed: str) -> None:
        self.where, self.field, self.value, self.allowed = where, field, value, allowed
        shown = "" if value is None else f" = {_format_value(value)}"
        parts = [where or "''", f": {field}" if field else "", shown, f": {allowed}"]
        whole = [make_printable(_cut(part, LONGEST_LINE)) for part in parts]
        super().__init__("".join(_fit(whole, LONGEST_LINE - len(PROGRAM))))

    def __reduce__(self) -> tuple[type[InputError], tuple[str, str, object, str]]:
        """Rebuild the error from a pickle, so that one process can send it to another."""
        return InputError, (self.where, self.field, self.value, self.allowed)


class Diverged(ArithmeticError):
    """A simulation left the range in which its numbers mean anything.

    Args:
        model: Name of the model.
        time_s: When it did so [s].
    """

    def __init__(self, model: str, time_s: float) -> None:
        self.model, self.time_s = model, time_s
        super().__init__(f"{model}: diverged at t = {time_s:.6g} s")

    def __reduce__(self) -> tuple[type[Diverged], tuple[str, float]]:
        """Rebuild the error from a pickle, so that one process can send it to another."""
        return Diverged, (self.model, self.time_s)


class Unfinished(RuntimeError):
    """A simulation came to no end: its process died or hung, or it raised."""


class CannotDo(NotImplementedError):
    """A model lacks the ability to answer."""


def describe_error(error: BaseException) -> str:
    """Kind and text of an exception in one line; some have no text, or cannot be printed."""
    kind = type(error).__name__
    try:
        text = " ".join(str(error).split())
    except BaseException:  # whatever the class of a user or a package does
        text = ""
    return f"{kind}: {text}" if text else kind


def describe_type(value: object) -> str:
    """The name of a value's type behind its article, such as `an int`; of a type `a class`."""
    name = "class" if isinstance(value, type) else type(value).__name__
    return f"{'an' if name[0].lower() in 'aeio' or name == 'ndarray' else 'a'} {name}"


def rephrase(text: str) -> str:
    """One of pydantic's messages as this program's own."""
    for theirs, ours in PHRASES.items():
        text = re.sub(theirs, ours, text)
    return text


def format_line(text: str) -> str:
    """A text as one line of at most 400 characters, without anything that cannot be printed."""
    return _cut(make_printable(re.sub(r"\s*[\r\n]\s*", " ", text.strip())), LONGEST_LINE)


def make_printable(text: str) -> str:
    """The text with whatever a terminal would not show written as an escape."""
    shown = (c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)
    return "".join(shown)


def _fit(parts: Sequence[str], total: int) -> list[str]:
    """The parts, the longest of them cut until all together have at most so many characters."""
    longest = max(map(len, parts))
    while sum(min(len(part), longest) for part in parts) > total:
        longest -= 1
    return [_cut(part, longest) for part in parts]


def _cut(text: str, length: int) -> str:
    if len(text) <= length:
        return text
    tail = (length - len(GAP)) // 2
    return text[: length - len(GAP) - tail] + GAP + text[len(text) - tail :]


def _format_value(value: object) -> str:
    try:
        return repr(value)
    except (ValueError, RecursionError):  # an integer of thousands of digits, a bottomless list
        return f"<{type(value).__name__} too long to show>"

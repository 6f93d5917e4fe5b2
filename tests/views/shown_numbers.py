"""Numbers in a view, known by the values of the record that they show."""

import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, fields, is_dataclass, replace
from html.parser import HTMLParser
from itertools import count
from math import floor, isfinite, log10
from typing import Any, NamedTuple

import numpy as np

# No part of names, versions, dates, powers or places in a file.
NUMBER = (
    r"(?<![\w./:~^-])(?:[-+]?(?:\d{1,3}(?:,\d{3})+|\d+)(?:\.\d+)?(?:e[-+]?\d+)?)(?![\w^/]|[.:-]\w)"
)
UNITS = "N m|N/m|N s|N|rad/s²|rad/s|rad s-2|rad s-1|rad|Hz|kg m²|kg|J|m/s²|m/s|m|s"
QUANTITY = rf"({NUMBER})(?: ?(%|(?:[kmµn]?(?:{UNITS}))(?![\w/²])))?"
PREFIXES = {"k": 1e3, "m": 1e-3, "µ": 1e-6, "n": 1e-9}
# Of numbers that two digits distinguish from others, too.
MANTISSAS = [each for each in range(101, 1000) if each % 10 and (each + 5) // 10 % 10]
ROUNDING = 1e-13  # below which numbers are other ones on another machine
MOST_ROWS = 40  # of arrays whose rows views show; of longer ones the last
# Fields of records that are no results: what they hold stays as it is.
KEPT = (
    *("robot", "problem", "mechanism", "provenance", "equations", "motion", "record", "records"),
    *("time", "tolerances", "samples"),
)


class Token(NamedTuple):
    """A number of a text, with its unit."""

    text: str
    unit: str

    @classmethod
    def of(cls, found: re.Match[str]) -> "Token":
        """That of a quantity in a text."""
        return cls(found[1].replace(",", ""), found[2] or "")

    @property
    def value(self) -> float:
        """The number in its unit without a prefix."""
        return float(self.text) * scale_of(self.unit)[1]

    @property
    def half_step(self) -> float:
        """Half of its last digit, in that unit."""
        mantissa, _, exponent = self.text.partition("e")
        places = -len(mantissa.partition(".")[2])
        if not places and not exponent:
            places = len(mantissa) - max(len(mantissa.rstrip("0")), 1)
        return 0.5000001 * 10.0 ** (places + int(exponent or 0)) * scale_of(self.unit)[1]

    def shows(self, value: float) -> bool:
        """Whether it is a value, rounded to its digits, of which one is right."""
        if isinstance(value, int) or not value:
            return self.value == value
        return bool(abs(self.value - value) <= min(self.half_step, 0.51 * abs(value)))


@dataclass(frozen=True)
class View:
    """A view of a record; derive: numbers that it may work out of the record, by their names."""

    make: Callable[[], Any]
    render: Callable[[Any], str]
    derive: Callable[[Any], Iterable[tuple[str, float]]] = lambda record: ()


def scale_of(unit: str) -> tuple[str, float]:
    """A unit without its prefix or per cent, and how many of it those are."""
    if unit == "%":
        return "", 1e-2
    if not re.fullmatch(UNITS, unit) and unit[1:] and unit[0] in PREFIXES:
        return unit[1:], PREFIXES[unit[0]]
    return unit, 1.0


def mark(record: Any) -> Any:
    """The record with other digits for every number of its results: no two begin alike."""
    return _mark(record, count(), "")


def _mark(value: Any, counter: Iterator[int], name: str) -> Any:
    if name in KEPT:
        return value
    if isinstance(value, np.ndarray) and value.dtype.kind == "f":
        return np.array([_mark(float(each), counter, "") for each in value.flat]).reshape(
            value.shape
        )
    if isinstance(value, float) and isfinite(value):
        digits = MANTISSAS[379 * next(counter) % len(MANTISSAS)]
        power = floor(log10(abs(value)) + 1e-6) if abs(value) > ROUNDING else -15 - digits % 3
        return float(f"{'-' * (value < -ROUNDING)}{digits}e{power - 2}")
    if is_dataclass(value) and not isinstance(value, type):
        own = {each.name: getattr(value, each.name) for each in fields(value) if each.init}
        return replace(value, **{key: _mark(each, counter, key) for key, each in own.items()})
    if isinstance(value, tuple) and hasattr(value, "_fields"):
        return value._replace(**{k: _mark(e, counter, k) for k, e in value._asdict().items()})
    if isinstance(value, Mapping):
        return {key: _mark(each, counter, str(key)) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return type(value)(_mark(each, counter, name) for each in value)
    return value


def list_values(value: Any, name: str) -> Iterator[tuple[str, float]]:
    """The numbers of a record's results with their places."""
    if isinstance(value, float):
        yield name, value
    elif name.rpartition(".")[2] in KEPT or isinstance(value, type):
        return
    elif isinstance(value, np.ndarray) and value.ndim:
        rows = enumerate(value) if len(value) <= MOST_ROWS else [(-1, value[-1])]
        for number, row in rows:
            yield from list_values(row if np.ndim(row) else float(row), f"{name}[{number}]")
    elif isinstance(value, Mapping):
        for key, each in value.items():
            yield from list_values(each, f"{name}.{key}")
    elif is_dataclass(value) or hasattr(value, "_fields"):
        own = [each.name for each in fields(value)] if is_dataclass(value) else [*value._fields]
        for key in own:
            yield from list_values(getattr(value, key), f"{name}.{key}".lstrip("."))
    elif isinstance(value, list | tuple):
        for number, each in enumerate(value):
            yield from list_values(each, f"{name}[{number}]")


def name_numbers(text: str, values: Mapping[str, float]) -> str:
    """The text with the names of values, in guillemets, for the numbers that show them.

    A count, or a number of one digit, may be any. Of several values that a number may show, the one
    next to the value that was named last is named. What else rounding makes is #.
    """
    names, sizes, last = [*values], np.array([*values.values()]), 0

    def name(found: re.Match[str]) -> str:
        nonlocal last
        token = Token.of(found)
        digits = re.sub(r"e.*|\D", "", token.text).strip("0")
        if len(digits) < 2 or (len(token.text) < 3 and not token.unit):
            return found[0]
        shown = np.flatnonzero(np.abs(sizes - token.value) <= token.half_step)
        if not shown.size:
            return "#" if abs(token.value) < ROUNDING else found[0]
        last = int(min(shown, key=lambda each: abs(each - last)))
        return f"«{names[last]}»{found[0][len(found[1]) :]}"

    return re.sub(QUANTITY, name, text)


class Page(HTMLParser):
    """Lines of an HTML text: blocks, and rows of tables, without what is drawn."""

    BLOCKS = ("p", "li", "h1", "h2", "h3", "summary", "figcaption", "caption", "pre", "div", "span")
    INSIDE = ("article", "summary", "figcaption", "p", "li")  # blocks of which parts are no blocks
    UNREAD = frozenset(("script", "style", "svg", "title", "code", "pre"))

    def __init__(self, text: str) -> None:
        super().__init__()
        self.lines: list[str] = []
        self.open: list[str] = []
        self.row: list[str] = []
        self.text = ""
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag in ("br", "meta", "input", "link"):
            self.text += "\0" * (tag == "br")
            return
        if label := dict(attrs).get("aria-label"):
            self.lines.append(label)
        if tag in (*self.BLOCKS, "article", "table", "td", "th"):
            self._end_block(self.open)
        self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        if tag not in self.open:
            return
        if tag in (*self.BLOCKS, "article"):
            self._end_block(self.open[:-1])
        if tag in ("td", "th"):
            self.row.append(" ".join(self.text.replace("\0", " ").split()))
            self.text = ""
        if tag == "tr":
            self.lines.append(" | ".join(self.row))
            self.row = []
        while self.open.pop() != tag:
            pass

    def handle_data(self, data: str) -> None:
        if self.UNREAD.isdisjoint(self.open):
            self.text += data

    def _end_block(self, around: list[str]) -> None:
        """The end of a block, unless it is a part of one."""
        if {"td", "th", *self.INSIDE} & set(around):
            self.text += " "
            return
        self.lines += filter(None, (" ".join(part.split()) for part in self.text.split("\0")))
        self.text = ""

"""Every number of a view, traced to the record that the view shows.

A record's values are facts: a value with its field and with the names that identify it. A view is
cut into pieces: cells of tables, leaves of JSON, lines and sentences. Each number of a piece must
be a fact of the field that the column, the key or the phrase around it names, and of the names
that stand beside it, rounded to the digits that are shown. Records are varied at random, so that
another fact, a constant or a number of another record does not fit by chance.
"""

import html
import json
import re
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, fields, is_dataclass, replace
from functools import lru_cache
from html.parser import HTMLParser
from typing import Any, NamedTuple
from xml.etree import ElementTree

import numpy as np

# No part of names, versions, dates, powers or places in a file.
NUMBER = (
    r"(?<![\w./:~^-])(?:[-+]?(?:\d{1,3}(?:,\d{3})+|\d+)(?:\.\d+)?(?:e[-+]?\d+)?)(?![\w^/]|[.:-]\w)"
)
UNITS = "N m|N/m|N s|N|rad/s²|rad/s|rad s-2|rad s-1|rad|Hz|kg m²|kg|J|m/s²|m/s|m|s"
QUANTITY = rf"({NUMBER})(?: ?(%|(?:[kmµn]?(?:{UNITS}))(?![\w/²])))?"
PREFIXES = {"k": 1e3, "m": 1e-3, "µ": 1e-6, "n": 1e-9}
WORDS = ("failed", "differ", "unfinished", "unresolved", "agree", "measured", "\N{CHECK MARK}")
SKIPPED = ("provenance", "schema_version", "unit")  # keys of JSON files that hold no results
LONGEST_NAME = 90  # of texts that identify what stands beside them
VARIED = 0.5  # natural logarithm of the largest factor on a varied number
COUNTS = ("entries", "steps", "states", "parameters", "blocks")  # that are varied like numbers
# Fields of records that are no results: what they hold stays as it is.
KEPT = (
    *("robot", "problem", "mechanism", "provenance", "equations", "motion", "record", "records"),
    *("time", "tolerances", "samples"),
)


class Fact(NamedTuple):
    """A value of a record, or derived; owners: names beside it; digits: the fewest shown, or 0."""

    value: Any
    field: str
    owners: tuple[str, ...] = ()
    unit: str = ""
    digits: int = 2


class Piece(NamedTuple):
    """A piece of a view, its column's or key's name, and its place, a column or a list.

    Names of facts are looked for in the scope, then in the outer text.
    """

    text: str
    scope: str = ""
    head: str = ""
    place: str = ""
    outer: str = ""


class Token(NamedTuple):
    """A number or a word with its unit, and the field that it is said to be of."""

    text: str
    unit: str
    field: str
    scope: str
    place: str
    outer: str


@dataclass(frozen=True)
class View:
    """A view of a record, and what may stand in it.

    Args:
        make: The record of a seed: other seeds have other numbers.
        render: The view's text.
        facts: The record's facts, and those that the view may derive of them.
        heads: Fields by column, or by key, of those that have another name.
        phrases: Fields, parted by commas, by phrases with ``{}`` for each number.
        wording: Numbers that are no result, as patterns, with the reason.
        shown: Fields of which every fact must be shown; of a text, word by word.
        sorted: Fields that are listed in another order than the record's.
        given: What else the view may quote of a record, such as the mechanism's description.
    """

    make: Callable[[int], Any]
    render: Callable[[Any], str]
    facts: Callable[[Any], Iterable[Fact]]
    heads: Mapping[str, str] = field(default_factory=dict)
    phrases: Mapping[str, str] = field(default_factory=dict)
    wording: Mapping[str, str] = field(default_factory=dict)
    shown: tuple[str, ...] = ()
    sorted: tuple[str, ...] = ()
    given: Callable[[Any], Any] = lambda record: ()


def vary(record: Any, seed: int) -> Any:
    """The record with every number of its results times another random factor."""
    return _vary(record, np.random.default_rng(seed))


def _vary(value: Any, rng: np.random.Generator, name: str = "") -> Any:
    if name in KEPT:
        return value
    if name == "findings" and isinstance(value, list | tuple):  # fewer of them have other counts
        value = value[int(rng.integers(0, 4)) :]
    if isinstance(value, np.ndarray) and value.dtype.kind == "f":
        return value * np.exp(rng.uniform(-VARIED, VARIED, value.shape))
    if isinstance(value, int) and name in COUNTS:
        return value + int(rng.integers(1, 1000))
    if isinstance(value, float):
        return value * float(np.exp(rng.uniform(-VARIED, VARIED)))
    if is_dataclass(value) and not isinstance(value, type):
        own = {each.name: getattr(value, each.name) for each in fields(value) if each.init}
        return replace(value, **{key: _vary(each, rng, key) for key, each in own.items()})
    if isinstance(value, tuple) and hasattr(value, "_fields"):
        return type(value)(*(_vary(e, rng, n) for e, n in zip(value, value._fields, strict=True)))
    if isinstance(value, Mapping):
        return {key: _vary(each, rng, str(key)) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return type(value)(_vary(each, rng, name) for each in value)
    return value


def list_texts(record: Any, seen: set[int] | None = None) -> Iterator[str]:
    """All texts of a record: a view may repeat them as they are."""
    seen = set() if seen is None else seen
    if isinstance(record, str):
        yield record
        return
    if isinstance(record, np.ndarray | type) or callable(record):
        return
    if isinstance(record, Mapping):
        yield from list_texts([*record.keys(), *record.values()], seen)
    elif isinstance(record, list | tuple | set | frozenset):
        for each in record:
            yield from list_texts(each, seen)
    elif hasattr(record, "__dict__") and id(record) not in seen:
        seen.add(id(record))
        yield from list_texts(vars(record), seen)


class Page(HTMLParser):
    """Pieces of an HTML text: cells under their columns, other text block by block."""

    BLOCKS = ("p", "li", "h1", "h2", "h3", "summary", "figcaption", "caption", "pre", "div", "span")
    INSIDE = ("article", "summary", "figcaption", "p", "li")  # blocks of which parts are no blocks

    def __init__(self, text: str) -> None:
        super().__init__()
        self.pieces: list[Piece] = []
        self.open: list[str] = []
        self.text, self.heading, self.tables = "", "", 0
        self.heads: list[str] = []
        self.row: list[tuple[str, str]] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag in ("br", "meta", "input", "link"):
            self.text += "\0" * (tag == "br")
            return
        named = dict(attrs)
        if label := named.get("aria-label"):
            self.pieces.append(Piece(label))
        if tag in (*self.BLOCKS, "article", "table", "td", "th"):
            self._end(self.open)
        if tag == "table":
            self.tables, self.heads = self.tables + 1, []
        self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        if tag not in self.open:
            return
        if tag in (*self.BLOCKS, "article"):
            self._end([each for n, each in enumerate(self.open) if n < len(self.open) - 1])
        if tag in ("td", "th"):
            self.row.append((tag, " ".join(self.text.replace("\0", " ").split())))
            self.text = ""
        if tag == "tr":
            self._end_row()
        while self.open.pop() != tag:
            pass

    def handle_data(self, data: str) -> None:
        if not {"script", "style", "svg", "title", "code", "pre"} & set(self.open):
            self.text += data

    def _end(self, around: list[str]) -> None:
        """The end of a block, unless it is a part of one."""
        if {"td", "th", *self.INSIDE} & set(around):
            self.text += " "
            return
        for part in self.text.split("\0"):
            text = " ".join(part.split())
            if text and self.open and self.open[-1] in ("h1", "h2", "h3", "caption"):
                self.heading = text
            self.pieces += [Piece(text)] if text else []
        self.text = ""

    def _end_row(self) -> None:
        row, self.row = self.row, []
        if all(tag == "th" or not text for tag, text in row):
            self.heads = [text for _, text in row]
            return
        heads = self.heads if len(self.heads) == len(row) else [row[0][1]] * len(row)
        first = next((n for n, (tag, text) in enumerate(row) if n and tag == "td"), len(row))
        label, group = [self.heading, *(text for _, text in row[:first])], ""
        for n, (head, (_, text)) in enumerate(zip(heads, row, strict=True)):
            group = head.partition(":")[0] if ":" in head else group
            head = head or f"column {n}"
            scope = " | ".join([*label, *(text for _, text in row[first:n]), group])
            self.pieces.append(Piece(text, scope, head, f"table {self.tables}, {n} {head}"))


def list_pieces(text: str) -> list[Piece]:
    """The pieces of a view: of HTML, XML, JSON, or lines of text."""
    if text.startswith("<?xml"):
        return list(_list_elements(ElementTree.fromstring(text)))
    if text.lstrip().startswith("<"):
        return Page(text).pieces
    if text.startswith("{"):
        return list(_list_leaves(json.loads(text), "", (), (), ""))
    return list(_list_lines(text))


def _list_lines(text: str) -> Iterator[Piece]:
    """Of lines that begin with a space, the first heads the columns of the others."""
    heads: list[tuple[int, str]] = []
    for number, line in enumerate(text.splitlines()):
        columns = [(each.start(), each[0]) for each in re.finditer(r"\S+(?: \S+)*", line)]
        if line[:1] != " " or not columns[1:]:
            heads = []
            yield Piece(line)
        elif not heads:
            heads = columns
        else:
            ends = [*(start for start, _ in heads[1:]), None]
            for (start, head), end in zip(heads, ends, strict=True):
                cell = line[start:end].strip()
                yield Piece(cell, line[:start], head, f"table at {number}, {head}")


def _list_elements(element: ElementTree.Element, scope: str = "") -> Iterator[Piece]:
    own = element.attrib
    scope += f" {own.get('classname', '').replace('.', '/')}/{own.get('name', '')}"
    for name, value in own.items():
        yield Piece(value, scope, "" if name == "message" else name, name)
    for line in (element.text or "").splitlines():
        head, _, value = line.partition(": ")
        yield Piece(value or head, scope, head.strip() if value else "", head)
    for each in element:
        yield from _list_elements(each, scope)


def _list_leaves(
    value: Any, key: str, texts: tuple[str, ...], own: tuple[str, ...], place: str
) -> Iterator[Piece]:
    """own: texts beside the value that may identify it; texts: those of what it is inside."""
    if isinstance(value, Mapping):
        names = tuple(e for e in value.values() if isinstance(e, str) and len(e) < LONGEST_NAME)
        names = tuple(each for each in names if each[-1:] != ".")
        for name, each in value.items():
            if name not in SKIPPED:
                yield from _list_leaves(each, name, (*texts, *own), names, f"{place}/{name}")
    elif isinstance(value, list):
        for number, each in enumerate(value):
            inside = f"{place}[{number}]" if isinstance(each, list) else place
            yield from _list_leaves(each, key, texts, own, inside)
    elif isinstance(value, str) and value not in WORDS:
        yield Piece(value, outer=key)
    elif value is not None and not isinstance(value, bool):
        outer = " | ".join((*texts, *own, place))
        yield Piece(str(value), " | ".join((*own, place)), key, place, outer)


def walk(view: View, seed: int) -> Iterator[str]:
    """What does not follow from the record in its view."""
    record = view.make(seed)
    yield from trace(view, record, view.render(record), view.facts(record))


def trace(view: View, record: Any, text: str, given: Iterable[Fact]) -> Iterator[str]:
    """What does not follow from facts in a view's text of a record."""
    facts = list(given)
    by_field: dict[str, list[tuple[int, Fact]]] = defaultdict(list)
    for number, fact in enumerate(facts):
        by_field[fact.field].append((number, fact))
    places: dict[tuple[str, str], int] = {}
    met: set[int] = set()
    for token in list_tokens(view, record, text, by_field.keys()):
        found, near = find_facts(token, by_field[token.field])
        met.update(found)
        if not found:
            values = ", ".join(f"{fact.value}" for _, fact in near[:4])
            yield f"{token.text} {token.unit}, {token.field}, in {token.scope[:99]!r}: {values}"
        elif token.field not in view.sorted:
            last = places.get((token.place, token.field), -1)
            later = [number for number in found if number >= last]
            places[token.place, token.field] = min(later, default=last)
            if not later:
                yield f"{token.text} of {token.field} comes too late in {token.scope[:99]!r}"
    plain = " ".join(html.unescape(text).split())
    for number, fact in enumerate(facts):
        if fact.field in view.shown and number not in met and str(fact.value) not in plain:
            yield f"not shown: {fact}"


def list_tokens(view: View, record: Any, text: str, known: Iterable[str]) -> Iterator[Token]:
    """The numbers of a view with what they are said to be, and words of a table's cells."""
    strings = set(list_texts((record, view.given(record))))
    texts = [each for each in strings if re.search(r"\d", each) and not re.fullmatch(NUMBER, each)]
    texts.sort(key=len, reverse=True)
    names = re.compile("|".join([*view.wording, *map(re.escape, texts)]) or "$^")
    known = set(known)
    for number, piece in enumerate(list_pieces(text)):
        if piece.head in SKIPPED or (piece.text in strings and piece.text not in WORDS):
            continue
        head = re.sub(r" *\[.*", "", piece.head)
        head = view.heads.get(head, head.partition(": ")[2] or head)
        head = view.heads.get(head, head)
        cleaned = names.sub(lambda found: "_" * len(found[0]), piece.text)
        scope = piece.scope if head in known else f"{piece.scope} {piece.head}"
        word = re.match("|".join(WORDS), piece.text)
        if word and piece.head != "" and not re.match(r"[\w ]*:", piece.text[word.end() :]):
            own = head if word[0] == "\N{CHECK MARK}" else "verdict"
            yield Token(word[0], "", own, scope, piece.place, piece.outer)
        unit = "".join(re.findall(r"\[(.*)\]", piece.head))
        for start, end, sentence in [(0, None, "")] if piece.scope else _split(piece.text):
            place = piece.place or f"piece {number}, {sentence}"
            scope, outer = scope if piece.scope else piece.text[start:end], piece.outer or sentence
            labels = dict(_label(view.phrases, cleaned[start:end]))
            for found in re.finditer(QUANTITY, cleaned[start:end]):
                own = labels.get(found.start(), head if head in known else "")
                shown = found[1].replace(",", "")
                yield Token(shown, found[2] or unit, own, scope, place, f"{sentence} {outer}")


def _split(text: str) -> Iterator[tuple[int, int, str]]:
    """Where clauses of a text begin and end, with their sentences."""
    start = 0
    for sentence in re.split(r"(?<=[a-z)%]\.) (?=[A-Z])", text):
        for clause in sentence.split("; "):
            at = text.index(clause, start)
            start = at + len(clause)
            yield at, start, sentence


@lru_cache
def _compile(phrase: str) -> re.Pattern[str]:
    return re.compile(phrase.replace("{}", QUANTITY))


def _label(phrases: Mapping[str, str], cleaned: str) -> Iterator[tuple[int, str]]:
    """Where numbers begin, and their fields; of two phrases the later one of the table holds."""
    for phrase, named in phrases.items():
        for found in _compile(phrase).finditer(cleaned):
            for number, own in enumerate(named.split(", ")):
                yield found.start(2 * number + 1), own


@lru_cache(maxsize=100_000)
def is_mentioned(name: str, scope: str) -> bool:
    """Whether a name stands in a text, not as a part of another."""
    return bool(re.search(rf"(?<!\w){re.escape(name)}(?!\w)", scope))


def find_facts(
    token: Token, facts: list[tuple[int, Fact]]
) -> tuple[list[int], list[tuple[int, Fact]]]:
    """Numbers of the facts that a token shows, and those that it may be of."""
    near: list[tuple[int, Fact]] = []
    for scope in filter(None, (token.scope, token.outer)):
        near = [each for each in facts if all(is_mentioned(o, scope) for o in each[1].owners)]
        most = max((sum(map(len, fact.owners)) for _, fact in near), default=0)
        found = [number for number, fact in near if is_shown(token, fact)]
        if any(sum(map(len, fact.owners)) == most for number, fact in near if number in found):
            return found, near
    return [], near


def scale_of(unit: str) -> tuple[str, float]:
    """A unit without its prefix or per cent, and how many of it those are."""
    if unit == "%":
        return "", 1e-2
    if not re.fullmatch(UNITS, unit) and unit[1:] and unit[0] in PREFIXES:
        return unit[1:], PREFIXES[unit[0]]
    return unit, 1.0


def scale_number(token: Token) -> float:
    """A token's number in its unit without a prefix."""
    return float(token.text) * scale_of(token.unit)[1]


def is_shown(token: Token, fact: Fact) -> bool:
    """Whether a token is a fact's word, or its number in a unit and rounded."""
    if isinstance(fact.value, str) or token.text in WORDS:
        return bool(token.text == fact.value)
    unit, scale = scale_of(token.unit)
    if fact.unit and unit and unit != fact.unit:
        return False
    shown, value = scale_number(token), float(fact.value)
    if isinstance(fact.value, int) or not value:
        return shown == value
    mantissa, _, exponent = token.text.partition("e")
    places = -len(mantissa.partition(".")[2])
    if not places and not exponent:
        places = len(mantissa) - max(len(mantissa.rstrip("0")), 1)
    half = 0.5000001 * 10.0 ** (places + int(exponent or 0)) * scale
    fewest = 0.51 * 10 ** (1 - fact.digits) * abs(value) if fact.digits else np.inf
    return bool(abs(shown - value) <= min(half, fewest))

"""What is wrong with a page: structure, ids, links, captions, and the drawings' axes."""

import json
import re
import xml.etree.ElementTree as ET
from html.parser import HTMLParser
from itertools import pairwise
from typing import Any

VOID = frozenset({"br", "hr", "img", "input", "link", "meta"})
_BLOCKS = """address article aside blockquote details div dl figcaption figure footer form h1 h2 h3
h4 h5 h6 header hr main nav ol p pre section summary table ul"""
BLOCKS = frozenset(_BLOCKS.split())
# Axes whose quantity is a pure number.
PURE = ("ζ", "zeta", "t / T", "base mass / arm mass", "rms misfit", "statements explained")
SVG = re.compile(r"<svg\b.*?</svg>", re.DOTALL)


class _Page(HTMLParser):
    """Tags must close in order, and no block may stand in a paragraph."""

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.ids: list[str] = []
        self.links: list[str] = []
        self.found: list[str] = []
        self.captioned: list[bool] = []  # of every open figure

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.handle_startendtag(tag, attrs)
        if tag not in VOID:
            self.open.append(tag)
        if tag == "figure":
            self.captioned.append(False)
        if tag == "figcaption":
            self.captioned[-1:] = [True]

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if "p" in self.open and tag in BLOCKS:
            self._note(f"<{tag}> in a <p>")
        if tag == "svg" and not {"figure", "td"} & set(self.open):
            self._note("a drawing outside of a <figure>")
        for name, value in attrs:
            if name == "id":
                self.ids.append(value or "")
            if name == "href" and (value or "").startswith("#"):
                self.links.append((value or "")[1:])

    def handle_endtag(self, tag: str) -> None:
        if not self.open or self.open[-1] != tag:
            self._note(f"</{tag}> closes {self.open[-1:]}")
            return
        self.open.pop()
        if tag == "figure" and not self.captioned.pop():
            self._note("a <figure> without a caption")

    def _note(self, what: str) -> None:
        self.found.append(f"line {self.getpos()[0]}: {what}")


def page_problems(html: str) -> list[str]:
    """Everything wrong with a page's structure; drawings must be XML by themselves."""
    page = _Page()
    page.feed(html)
    page.close()
    twice = {name for name in page.ids if page.ids.count(name) > 1} if _repeats(page.ids) else set()
    return [
        *page.found,
        *(f"<{tag}> is never closed" for tag in page.open),
        *(f"id {name} is not unique" for name in sorted(twice)),
        *(f"#{name} leads nowhere" for name in sorted(set(page.links) - set(page.ids))),
        *(f"{word} in the text" for word in ("nan", "None", "inf") if _says(html, word)),
        *(problem for svg in SVG.findall(html) for problem in _not_xml(svg)),
    ]


def _repeats(names: list[str]) -> bool:
    return len(set(names)) < len(names)


def _says(html: str, word: str) -> bool:
    """A Python value that slipped into a text; drawings apart, whose letters are paths."""
    text = re.sub(r"<[^>]*>", " ", SVG.sub(" ", html))
    return re.search(rf"(?<![\w.-]){word}(?![\w-])", text) is not None


def _not_xml(svg: str) -> list[str]:
    try:
        ET.fromstring(svg)
    except ET.ParseError as error:
        return [f"a drawing is not XML: {error}"]
    return []


def axis_problems(svg: str) -> list[str]:
    """Axes of a drawing with numbers at their ticks and no label with a unit.

    A label may be shared: below the same column, or left of the same row.
    """
    parser = ET.XMLParser(target=ET.TreeBuilder(insert_comments=True))
    root = ET.fromstring(svg, parser)
    axes = [group for group in root.iter(_G) if _named(group, "axes_")]
    problems = []
    for direction in (0, 1):
        labelled = [_place(one, direction) for one in axes if _has_unit(_axis(one, direction))]
        for one in axes:
            axis = _axis(one, direction)
            place = _place(one, direction)
            if _counts(axis) and not any(_near(place, other) for other in labelled):
                problems.append(f"{one.get('id')}: {'xy'[direction]} axis, labels {_labels(axis)}")
    return problems


_G = "{http://www.w3.org/2000/svg}g"


def _named(group: ET.Element, start: str) -> bool:
    return re.match(rf"(s\d+-)?{re.escape(start)}\d+$", group.get("id", "")) is not None


def _axis(axes: ET.Element, direction: int) -> ET.Element | None:
    found = [group for group in axes.findall(_G) if _named(group, "matplotlib.axis_")]
    return found[direction] if direction < len(found) else None


def _texts(group: ET.Element) -> list[str]:
    return [(node.text or "").strip() for node in group.iter(ET.Comment)]


def _labels(axis: ET.Element | None) -> list[str]:
    """Texts of an axis that stand at no tick."""
    if axis is None:
        return []
    return [text for group in axis.findall(_G) if _named(group, "text_") for text in _texts(group)]


def _counts(axis: ET.Element | None) -> bool:
    """Whether an axis has numbers at its ticks, or marks without."""
    if axis is None:
        return False
    ticks = [g for g in axis.findall(_G) if re.match(r"(s\d+-)?[xy]tick_", g.get("id", ""))]
    texts = [text for tick in ticks for text in _texts(tick)]
    return bool(ticks) and (not texts or any(re.search(r"\d", text) for text in texts[:3]))


def _has_unit(axis: ET.Element | None) -> bool:
    return any("[" in text or text in PURE for text in _labels(axis))


def _place(axes: ET.Element, direction: int) -> tuple[float, float]:
    """Extent of the axes' background: horizontal for a shared x label, vertical for a shared y."""
    background = next(group for group in axes.findall(_G) if _named(group, "patch_"))
    path = background.find("{http://www.w3.org/2000/svg}path")
    assert path is not None
    numbers = [float(number) for number in re.findall(r"-?[\d.]+", path.get("d", ""))]
    along = numbers[direction::2]
    return min(along), max(along)


def _near(one: tuple[float, float], other: tuple[float, float]) -> bool:
    return all(abs(left - right) < 2.0 for left, right in zip(one, other, strict=True))


def uneven_tables(html: str) -> list[str]:
    """Tables whose rows have different numbers of cells."""
    tables = re.findall(r"<table>(.*?)</table>", SVG.sub("", html), re.DOTALL)
    counts = [[row.count("<t") - row.count("<table") for row in t.split("<tr")[1:]] for t in tables]
    return [
        f"table {number}: {one} and {other} cells"
        for number, rows in enumerate(counts, start=1)
        for one, other in pairwise(rows)
        if one != other
    ]


def strict_json(text: str) -> dict[str, Any]:
    """JSON without NaN and infinities, which other readers refuse."""

    def refused(constant: str) -> None:
        raise AssertionError(f"{constant} is not JSON")

    return json.loads(text, parse_constant=refused)

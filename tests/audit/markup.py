"""What is wrong with a page: structure, ids, links, captions, and the drawings' axes."""

import json
import re
import xml.etree.ElementTree as ET
from collections import Counter
from collections.abc import Iterable, Iterator
from itertools import product
from typing import Any, NamedTuple

import numpy as np

_BLOCKS = """address article aside blockquote details div dl figcaption figure footer form h1 h2 h3
h4 h5 h6 header hr main nav ol p pre section summary table ul"""
BLOCKS = frozenset(_BLOCKS.split())
# Axes whose quantity is a pure number.
PURE = ("ζ", "t / T")
SVG = re.compile(r"<svg\b.*?</svg>", re.DOTALL)


def read_page(html: str) -> ET.Element:
    """A page as a tree with the drawings' comments. Raises ET.ParseError for tags out of order.

    Scripts, tags that need no end and attributes that need no value are all that is no XML.
    """
    text = re.sub(r"(?is)<!doctype[^>]*>|<(script|style)\b.*?</\1>", "", html)
    text = re.sub(r"<((?:br|hr|img|input|link|meta)\b[^<>]*?)/?>", r"<\1/>", text)
    text = re.sub(r"(<\w[^<>]*) (open|hidden|checked)(?=[ />])", r'\1 \2=""', text)
    parser = ET.XMLParser(target=ET.TreeBuilder(insert_comments=True))
    return ET.fromstring(f"<page>{text}</page>", parser)


def page_problems(html: str) -> list[str]:
    """Everything wrong with a page's structure, or with its text outside of drawings."""
    try:
        page = read_page(html)
    except ET.ParseError as error:
        return [f"not XML: {error}"]
    widths = (
        {sum(int(cell.get("colspan", "1")) for cell in row) for row in table.iter("tr")}
        for table in page.iter("table")
    )
    ids = Counter(node.get("id") for node in page.iter() if node.get("id"))
    links = {node.get("href", "") for node in page.iter() if node.get("href", "").startswith("#")}
    framed = {svg for tag in ("figure", "td") for frame in page.iter(tag) for svg in _svgs(frame)}
    text = re.sub(r"<[^>]*>", " ", SVG.sub(" ", html))
    return [
        *(f"<{node.tag}> in a <p>" for p in page.iter("p") for node in p.findall(".//*")
          if node.tag in BLOCKS),
        *("a drawing outside of a <figure>" for svg in _svgs(page) if svg not in framed),
        *("a <figure> without a caption" for figure in page.iter("figure")
          if figure.find(".//figcaption") is None),
        *(f"table {n}: rows of {each} cells" for n, each in enumerate(widths, 1) if len(each) > 1),
        *(f"id {name} is not unique" for name, count in ids.items() if count > 1),
        *(f"{name} leads nowhere" for name in sorted(links) if name[1:] not in ids),
        # Python's values that slipped in.
        *(f"{word} in the text" for word in ("nan", "None", "inf")
          if re.search(rf"(?<![\w.-]){word}(?![\w-])", text)),
    ]  # fmt: skip


def _svgs(node: ET.Element) -> Iterator[ET.Element]:
    return node.iterfind(".//{*}svg")


class Axis(NamedTuple):
    """An axis of a drawing; extent: of its axes' background along it."""

    name: str
    labels: list[str]
    is_numbered: bool
    extent: tuple[float, float]

    @property
    def has_unit(self) -> bool:
        return any("[" in text or text in PURE for text in self.labels)


def axis_problems(html: str) -> list[str]:
    """Axes of a page's drawings with numbers at their ticks and no label with a unit.

    A label may be shared: below the same column, or left of the same row.
    """
    problems = []
    for svg, direction in product(_svgs(read_page(html)), (0, 1)):
        axes = [axis for group in _groups(svg.iter(), "axes_") for axis in _axes(group, direction)]
        shared = [axis.extent for axis in axes if axis.has_unit]
        for axis in axes:
            near = [np.abs(np.subtract(axis.extent, other)).max() < 2 for other in shared]
            if axis.is_numbered and not any(near):
                problems.append(f"{axis.name}: {'xy'[direction]} axis, labels {axis.labels}")
    return problems


def _axes(group: ET.Element, direction: int) -> Iterator[Axis]:
    """The horizontal (0) or vertical (1) axis of Matplotlib's axes, if there is one."""
    for axis in _groups(group, "matplotlib.axis_")[direction : direction + 1]:
        labels = [text for one in _groups(axis, "text_") for text in _texts(one)]
        ticks = _groups(axis, "[xy]tick_")
        texts = [text for tick in ticks for text in _texts(tick)]
        # There are numbers at its ticks, or marks without.
        is_numbered = bool(ticks) and (not texts or any(re.search(r"\d", x) for x in texts[:3]))
        background = _groups(group, "patch_")[0].find("{*}path")
        ends = sorted(map(float, re.findall(r"-?[\d.]+", background.get("d", ""))[direction::2]))
        yield Axis(group.get("id", ""), labels, is_numbered, (ends[0], ends[-1]))


def _groups(nodes: Iterable[ET.Element], name: str) -> list[ET.Element]:
    return [node for node in nodes if re.fullmatch(rf"(s\d+-)?{name}\d+", node.get("id", ""))]


def _texts(group: ET.Element) -> list[str]:
    """The texts of a drawing, whose letters are paths: it has them as comments."""
    return [(node.text or "").strip() for node in group.iter(ET.Comment)]


def strict_json(text: str) -> dict[str, Any]:
    """JSON without NaN and infinities, which other readers refuse."""

    def refused(constant: str) -> None:
        raise AssertionError(f"{constant} is not JSON")

    return json.loads(text, parse_constant=refused)

"""Renders templates, with the filters that they share."""

from __future__ import annotations

import re
from functools import cache

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup, escape

from crosscheck.report.formatting import (
    describe_tally,
    format_count,
    format_length,
    format_number,
    format_percent,
    format_unit,
)

LEAST_SECTIONS = 3  # sections of a page with a list of contents
_HEADING = re.compile(r'^<h2(?: id="([^"]*)")?>(.*)</h2>$', re.MULTILINE)
# A number and its unit, or a minus and its operand, in text that is escaped.
_TOGETHER = re.compile(
    r"-?\d[\d.,e-]*(?: ± [\d.e-]+)? (?:%|(?:(?:N|kg) m|[kmµn]?(?:m|s|g|N|J|Hz)|rad|deg)\b)"
    r"|(?<![^\s(\[,=*/^])- ?[\w.(]+"
)
_BACK = '<a class="back" href="#contents" aria-label="back to the contents">\u2191</a>'


@cache
def load_templates(package: str = "crosscheck.report", lean: bool = False) -> Environment:
    """The templates of a package.

    Text in .html.j2 is escaped, and a name that is not given is an error. lean: a line of nothing
    but a statement leaves no line behind.
    """
    made = Environment(
        loader=PackageLoader(package),
        autoescape=lambda name: name is not None and name.endswith(".html.j2"),
        undefined=StrictUndefined,
        trim_blocks=lean,
        lstrip_blocks=lean,
    )
    made.filters |= {
        "number": format_number,
        "counted": format_count,
        "in_words": format_unit,
        "length_text": format_length,
        "tally": describe_tally,
        "percent": format_percent,
        "unsplit": keep_together,
        "sentence": capitalize_sentence,
    }
    return made


def keep_together(text: str) -> Markup:
    """The text, escaped, with no line's end between a number and its unit, a minus and its operand.

    By style, since characters for that would be copied with a line of code.
    """
    return Markup(_TOGETHER.sub(r'<span class="unsplit">\g<0></span>', str(escape(text))))


def capitalize_sentence(text: str) -> Markup:
    """As keep_together, with a capital unless the name of a file or an entry comes first."""
    return keep_together(re.sub("^[a-z]+(?= )", lambda word: word[0].capitalize(), text))


def render_page(template: str, **given: object) -> str:
    """A whole page: HTML text. Raises jinja2.UndefinedError for what it asks and is not given."""
    return add_contents(load_templates().get_template(f"{template}.html.j2").render(**given))


def add_contents(page: str) -> str:
    """The page with a list of its sections before the first one, and a link back from each.

    A section begins with a line of its own that holds nothing but a heading of the second level.
    """
    sections: list[str] = []

    def link_back(heading: re.Match[str]) -> str:
        place = heading[1] or f"section-{len(sections) + 1}"
        sections.append(f'<a href="#{place}">{heading[2]}</a>')
        return f'<h2 id="{place}">{heading[2]}</h2>{_BACK}'

    linked = _HEADING.sub(link_back, page)
    if len(sections) < LEAST_SECTIONS:
        return page
    contents = f'<nav id="contents" aria-label="contents">{" ".join(sections)}</nav>\n<h2 '
    return re.sub("^<h2 ", lambda _: contents, linked, count=1, flags=re.MULTILINE)

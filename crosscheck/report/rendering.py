"""Templates, filled in: the one place that says how, and which filters they have."""

from __future__ import annotations

from functools import cache

from jinja2 import Environment, PackageLoader, StrictUndefined

from crosscheck.report.formatting import (
    describe_tally,
    format_count,
    format_length,
    format_number,
    format_percent,
    format_unit,
)


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
    }
    return made


def render_page(template: str, **given: object) -> str:
    """A whole page: HTML text. Raises jinja2.UndefinedError for what it asks and is not given."""
    return load_templates().get_template(f"{template}.html.j2").render(**given)

"""What the page says: templates, which are given records and drawings and compute nothing."""

from __future__ import annotations

from functools import cache

from jinja2 import Environment
from markupsafe import Markup

from crosscheck.audit.measures.thresholds import EVIDENT, SEVERE
from crosscheck.audit.measures.undefined import format_number, format_percent
from crosscheck.report import fragments
from crosscheck.report.rendering import load_templates


@cache
def _build_environment() -> Environment:
    made = load_templates("crosscheck.audit", lean=True)
    made.filters |= {"shown": format_number, "percent": format_percent}
    made.globals["figure"] = lambda svg, caption: to_markup(fragments.render_figure(svg, caption))
    made.globals |= {"evident": EVIDENT, "severe": SEVERE}
    return made


def render_template(template: str, **given: object) -> str:
    """The html of a chapter or section. given: records, and drawings and tables as ``to_markup``.

    Raises jinja2.UndefinedError for what a template asks and is not given.
    """
    return _build_environment().get_template(f"{template}.html.j2").render(**given).strip()


def to_markup(fragment: str) -> Markup:
    """Markup of a drawing, table or section that is html already."""
    return Markup(fragment)  # made by this package's own views and templates

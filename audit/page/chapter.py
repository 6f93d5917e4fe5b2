"""What all chapters are made of: texts by templates, the names that readers see, the paper."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache

from jinja2 import Environment
from markupsafe import Markup

from crosscheck.audit.experiments.paper_conditions import (
    CONSERVATIVE,
    INTEGRAL,
    PRINTED,
    REPAIRED_RATE,
)
from crosscheck.audit.measures.thresholds import EVIDENT, SEVERE
from crosscheck.audit.measures.undefined import format_number, format_percent
from crosscheck.report import fragments
from crosscheck.report.rendering import load_templates


@dataclass(frozen=True)
class AuditChapter:
    """A chapter: a fragment of html, headings from <h3> down, figures inlined as <svg>.

    records: numbers and verdicts as they go into the JSON file, deterministic, each with an ``id``;
    outcome: what came out, in one sentence for the top of the page.
    """

    id: str
    title: str
    html: str
    records: Sequence[Mapping[str, object]] = ()
    outcome: str = ""


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


LAW_NAMES = {
    PRINTED: "omega_t as printed",
    REPAIRED_RATE: "omega_t, ring repaired",
    INTEGRAL: "angle (integral)",
    CONSERVATIVE: "angle, springs push θ",
}
# Of figures, which draw the paper's own law in the paper's own model, and others with free planets.
DRAWN_NAMES = LAW_NAMES | {PRINTED: "as modelled in the paper", INTEGRAL: "as the gears are"}


TITLE = "Joint dynamic analysis of space manipulator with planetary gear train transmission"
AUTHORS = "T. Yang, S. Yan, W. Ma and Z. Han"
CITATION = (
    f"{AUTHORS}: {TITLE}, Robotica, online 30 July 2014 (volume, pages, DOI: not known here)."
)
EXTENT_READ = (
    "What was read is the paper's text with its equations, Table I and the captions. Its figures"
    " were not seen: what a plot, a legend or an axis says is unknown here, and 'not given' means"
    " not given in the text. A figure that is drawn again is the experiment that text and caption"
    " describe, compared with what they say of it. The copy that was read names no more than the"
    " title: authors, journal and date are those of this project's bibliography."
)

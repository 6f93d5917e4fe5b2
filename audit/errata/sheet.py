"""The errata sheet, typeset: what one could send to the authors, and a chapter of the page."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import TYPE_CHECKING

import matplotlib as mpl
from markupsafe import Markup
from matplotlib.figure import Figure

from crosscheck.audit.errata.errata_texts import SheetSection, list_sections
from crosscheck.audit.experiments.paper_conditions import LABELLED
from crosscheck.audit.page.chapter import AuditChapter, render_template, to_markup
from crosscheck.report.fragments import render_table
from crosscheck.report.plots.figures import to_svg

if TYPE_CHECKING:
    from crosscheck.audit.claims.study_plan import AuditContext

ID, TITLE = "errata", "Errata sheet"


def build_chapter(context: AuditContext) -> AuditChapter:
    """The chapter of errors of equations; the other entries are in the sheet alone."""
    return build_sheet(list_sections(LABELLED, context.errata), context.effect_s, whole=False)


def build_sheet(
    sections: Sequence[SheetSection], duration_s: float, whole: bool = True
) -> AuditChapter:
    """The sheet as a chapter. whole: with all but errors of equations too.

    duration_s: of the runs behind their effects.
    """
    html = render_template(
        "errata/sheet",
        shown=[(each.heading, _draw_table(each)) for each in sections[: None if whole else 1]],
        counts={each.heading: len(each.records) for each in sections},
        duration_s=duration_s,
        whole=whole,
    )
    equations, *others = sections
    beside = ", ".join(f"{each.heading.lower()}: {len(each.records)}" for each in others)
    outcome = f"{len(equations.records)} errors in equations. Beside them {beside}."
    records = [record for section in sections for record in section.records]
    return AuditChapter(ID, TITLE, html, records, outcome)


def _draw_table(section: SheetSection) -> Markup:
    """The table as it is on the page, formulas drawn."""
    rows = section.list_rows(_draw_formula)
    return to_markup(render_table(list(section.columns.values()), rows))


@lru_cache
def _draw_formula(tex: str) -> Markup:
    """A TeX formula as an <svg> element, set by Matplotlib's own typesetter."""
    with mpl.rc_context({"mathtext.fontset": "cm"}):
        figure = Figure(figsize=(0.1, 0.1))
        # The typesetter does not know these two commands.
        supported_tex = tex.replace(r"\left", "").replace(r"\right", "")
        drawn = figure.text(0, 0, f"${supported_tex}$", fontsize=13)
        box = drawn.get_window_extent()
        figure.set_size_inches((box.width + 8) / figure.dpi, (box.height + 8) / figure.dpi)
        drawn.set_position((4 / (box.width + 8), 4 / (box.height + 8) - box.y0 / (box.height + 8)))
        return Markup(to_svg(figure))  # of this package's own

"""The errata sheet: what one could send to the authors, as a chapter and as Markdown."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from functools import lru_cache
from typing import TYPE_CHECKING, NamedTuple

import matplotlib as mpl
from markupsafe import Markup
from matplotlib.figure import Figure

from crosscheck.audit.errata.errata_texts import (
    CONTRADICTIONS_HEADING,
    GAPS_HEADING,
    HEADINGS,
    Contradiction,
    Gap,
    load_notes,
)
from crosscheck.audit.errata.erratum import CLASSES, SimulatedErratum
from crosscheck.audit.measures.undefined import JsonObject, to_json
from crosscheck.audit.page.chapter import AuditChapter
from crosscheck.audit.page.columns import Columns, format_cells, list_titles
from crosscheck.audit.page.published_paper import EXTENT_READ, PAPER
from crosscheck.audit.page.text import render_template, to_markup
from crosscheck.report.fragments import render_table
from crosscheck.report.plots.figures import to_svg

if TYPE_CHECKING:
    from crosscheck.audit.page.context import AuditContext

ID, TITLE = "errata", "Errata sheet"


def build_chapter(context: AuditContext) -> AuditChapter:
    """The chapter of errors of equations; the other entries are in the sheet alone."""
    return build_errata_sheet(context.errata, context.effect_s, whole=False)


def build_errata_sheet(
    by_arm: Mapping[str, Sequence[SimulatedErratum]], duration_s: float, whole: bool = True
) -> AuditChapter:
    """The chapter made of errata in words by arm, the first arm's as tables.

    duration_s: of the runs behind their effects; whole: with all but errors of equations too.
    """
    (first, errata), *_ = by_arm.items()
    sections, noted = list_sections(errata), load_notes()
    page = _render_counts(
        "sheet",
        errata,
        duration_s=duration_s,
        arm=first,
        whole=whole,
        sections=sections if whole else sections[:1],
        apart=_reading_specific_places(by_arm),
    )
    records = [build_record(arm, entry) for arm in by_arm for entry in by_arm[arm]]
    records += [build_note_record(note) for note in (*noted.contradictions, *noted.gaps)]
    return AuditChapter(ID, TITLE, page, records, _render_counts("outcome", errata))


def _render_counts(template: str, errata: Sequence[SimulatedErratum], **given: object) -> str:
    """A text of the sheet that has counts of its entries."""
    by_class = Counter(entry.erratum.kind for entry in errata)
    return render_template(f"errata/{template}", by_class=by_class, noted=load_notes(), **given)


def _reading_specific_places(
    by_arm: Mapping[str, Sequence[SimulatedErratum]],
) -> dict[str, list[str]]:
    """The places of the errata that one reading of Table I has and no other, by reading."""
    places = {arm: {entry.erratum.where for entry in errata} for arm, errata in by_arm.items()}
    return {
        arm: sorted(arm_places.difference(*(p for other, p in places.items() if other != arm)))
        for arm, arm_places in places.items()
        if len(places) > 1
    }


def format_markdown(errata: Sequence[SimulatedErratum]) -> str:
    """The sheet as Markdown, formulas as TeX; the errata are the chapter's."""
    introduction = _render_counts("introduction", errata)
    parts = ["# Errata sheet", PAPER.format_citation(), EXTENT_READ, introduction]
    for section in list_sections(errata):
        parts.append(f"{'#' * section.level} {section.heading}")
        if section.records:
            head = list_titles(section.columns)
            body = section.list_rows(lambda text: text.replace("|", r"\|"), "${}$".format)
            lines = [head, ["---"] * len(head), *body]
            parts.append("\n".join("| " + " | ".join(cells) + " |" for cells in lines))
    return "\n\n".join(parts) + "\n"


def build_record(arm: str, entry: SimulatedErratum) -> JsonObject:
    """An erratum with its size and effects for an arm, as JSON."""
    erratum = entry.erratum
    torque, pd = (entry.effects.get(name) for name in ("constant-torque", "pd"))
    return to_json(
        {
            "id": f"erratum/{arm}/{erratum.id}",
            "class": erratum.kind,
            "printed_tex": erratum.printed_tex,
            "derived_tex": erratum.derived_tex,
            "constant_torque_impulse_N_s": torque and torque.impulse_N_s,
            "pd_force_N": pd and pd.mesh_force_N,
            "where": erratum.where,
            "printed": erratum.printed,
            "derived": erratum.derived,
            "remark": erratum.remark,
            "denies": ", ".join(erratum.denies),
            "size": erratum.size,
            "unit": erratum.unit,
            "relative": erratum.relative,
            "constant_torque_theta_rad": torque and torque.theta_rad,
            "constant_torque_force_N": torque and torque.mesh_force_N,
            "pd_theta_rad": pd and pd.theta_rad,
            "pd_impulse_N_s": pd and pd.impulse_N_s,
        }
    )


def build_note_record(note: Contradiction | Gap) -> JsonObject:
    """A contradiction or a gap as JSON."""
    return {**asdict(note), "id": f"{type(note).__name__.lower()}/{note.id}"}


NOTATION = {
    "where": ("where", ""),
    "printed": ("printed", ""),
    "derived": ("should read", ""),
    "remark": ("remark", ""),
}
STATEMENT = NOTATION | {
    "denies": ("against claim", ""),
    "size": ("size", ".3g"),
    "unit": ("in", ""),
}
EQUATION = STATEMENT | {
    "relative": ("over its own size", ".3g"),
    "constant_torque_theta_rad": ("effect under 100 N m: angle [rad]", ".2g"),
    "constant_torque_force_N": ("mesh force [N]", ".2g"),
    "pd_theta_rad": ("effect under PD control: angle [rad]", ".2g"),
    "pd_impulse_N_s": ("impulse of a mesh [N s]", ".2g"),
}
CONTRADICTION = {
    "first": ("here", ""),
    "first_says": ("it says", ""),
    "second": ("there", ""),
    "second_says": ("it says", ""),
}
GAP = {
    "quantity": ("not given in the text", ""),
    "needed_for": ("needed for", ""),
    "here": ("here", ""),
}


class SheetSection(NamedTuple):
    """A heading of the sheet, with the table of its records, if there are any."""

    level: int
    heading: str
    columns: Columns
    records: Sequence[JsonObject] = ()

    @property
    def html(self) -> Markup:
        """The table as it is on the page, formulas drawn; nothing without records."""
        table = render_table(list_titles(self.columns), self.list_rows(str, _draw_formula))
        return to_markup(table if self.records else "")

    def list_rows(
        self, write_text: Callable[[str], str], write_formula: Callable[[str], str]
    ) -> list[list[str]]:
        """The rows; a cell is written as a formula where the record has its TeX."""
        return [
            [
                write_formula(str(tex)) if (tex := record.get(f"{name}_tex")) else write_text(text)
                for name, text in zip(self.columns, format_cells(self.columns, record), strict=True)
            ]
            for record in self.records
        ]


def list_sections(errata: Sequence[SimulatedErratum]) -> list[SheetSection]:
    """The sheet's sections, errors of equations first."""
    noted = load_notes()
    equations, statements, notation = (
        [build_record("", entry) for entry in errata if entry.erratum.kind == kind]
        for kind in CLASSES
    )
    contradictions, gaps = (
        [build_note_record(note) for note in notes] for notes in (noted.contradictions, noted.gaps)
    )
    return [
        SheetSection(2, HEADINGS["equation"], EQUATION, equations),
        SheetSection(2, "Statements", {}),
        SheetSection(3, HEADINGS["statement"], STATEMENT, statements),
        SheetSection(3, CONTRADICTIONS_HEADING, CONTRADICTION, contradictions),
        SheetSection(3, HEADINGS["notation"], NOTATION, notation),
        SheetSection(3, GAPS_HEADING, GAP, gaps),
    ]


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

"""The errata sheet: what one could send to the authors, as a chapter and as Markdown."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import matplotlib as mpl
from markupsafe import Markup
from matplotlib.figure import Figure

from crosscheck.audit.errata.errata_texts import (
    CONTRADICTIONS_HEADING,
    GAPS_HEADING,
    HEADINGS,
    Contradiction,
    Gap,
    count_errata,
    load_notes,
)
from crosscheck.audit.errata.erratum import CLASSES, ErratumClass, SimulatedErratum
from crosscheck.audit.experiments.paper_conditions import LABELLED
from crosscheck.audit.page.chapter import AuditChapter
from crosscheck.audit.page.columns import Columns, TableColumn
from crosscheck.audit.page.published_paper import EXTENT_READ, PAPER
from crosscheck.audit.page.text import render_template, to_markup
from crosscheck.report.plots.figures import to_svg

if TYPE_CHECKING:
    from crosscheck.audit.page.context import AuditContext

ID, TITLE = "errata", "Errata sheet"


@dataclass(frozen=True)
class ErrataSheet(AuditChapter):
    """The chapter with the errata sheet; errata: the errata of the first arm."""

    errata: tuple[SimulatedErratum, ...] = ()


def build_chapter(context: AuditContext) -> ErrataSheet:
    """The chapter of errors of equations; the other entries are in the sheet alone."""
    return build_errata_sheet(context.errata, context.effect_s, whole=False)


def build_errata_sheet(
    by_arm: Mapping[str, Sequence[SimulatedErratum]], duration_s: float, whole: bool = True
) -> ErrataSheet:
    """The chapter made of errata in words by arm, the first arm's as tables.

    duration_s: of the runs behind their effects; whole: with all but errors of equations too.
    """
    first, noted = next(iter(by_arm)), load_notes()
    first_errata = by_arm[first]
    rows = [
        ArmErratum(arm, simulated_erratum)
        for arm, errata in by_arm.items()
        for simulated_erratum in errata
    ]
    page = render_template(
        "errata/sheet",
        duration_s=duration_s,
        arm=first,
        whole=whole,
        sections=[
            (level, heading, to_markup(table.html(rows) if rows else ""))
            for level, heading, table, rows in _list_sections(first_errata)[: None if whole else 1]
        ],
        counts=count_errata(first_errata),
        apart=_reading_specific_places(by_arm),
    )
    notes_json = [*CONTRADICTIONS.json(noted.contradictions), *GAPS.json(noted.gaps)]
    records = [*WHOLE.json(rows), *notes_json]
    outcome = render_template("errata/outcome", counts=count_errata(first_errata))
    return ErrataSheet(ID, TITLE, page, records, outcome, tuple(first_errata))


def _errata_of_class(errata: Sequence[SimulatedErratum], kind: ErratumClass) -> list[ArmErratum]:
    return [
        ArmErratum(LABELLED, simulated_erratum)
        for simulated_erratum in errata
        if simulated_erratum.erratum.kind == kind
    ]


def _reading_specific_places(
    by_arm: Mapping[str, Sequence[SimulatedErratum]],
) -> dict[str, list[str]]:
    """The places of the errata that one reading of Table I has and no other, by reading."""
    places = {
        arm: {simulated_erratum.erratum.where for simulated_erratum in errata}
        for arm, errata in by_arm.items()
    }
    return {
        arm: sorted(arm_places.difference(*(p for other, p in places.items() if other != arm)))
        for arm, arm_places in places.items()
        if len(places) > 1
    }


def format_markdown(errata: Sequence[SimulatedErratum]) -> str:
    """The sheet as Markdown, formulas as TeX; the errata are the chapter's."""
    introduction = render_template("errata/introduction", counts=count_errata(errata))
    parts = ["# Errata sheet", PAPER.format_citation(), EXTENT_READ, introduction]
    for level, heading, table, rows in _list_sections(errata):
        parts += [f"{'#' * level} {heading}", *([table.markdown(rows)] if rows else [])]
    return "\n\n".join(parts) + "\n"


def _list_sections(
    errata: Sequence[SimulatedErratum],
) -> list[tuple[int, str, Columns[Any], Sequence[object]]]:
    """Levels, headings, columns and rows of the sheet's tables; of a part without rows no table."""
    noted = load_notes()
    rows = {kind: _errata_of_class(errata, kind) for kind in CLASSES}
    return [
        (2, HEADINGS["equation"], WHOLE, rows["equation"]),
        (2, "Statements", WHOLE, []),
        (3, HEADINGS["statement"], BY_CLASS["statement"], rows["statement"]),
        (3, CONTRADICTIONS_HEADING, CONTRADICTIONS, noted.contradictions),
        (3, HEADINGS["notation"], BY_CLASS["notation"], rows["notation"]),
        (3, GAPS_HEADING, GAPS, noted.gaps),
    ]


@dataclass(frozen=True)
class ArmErratum:
    """An erratum with its size and effects for one arm."""

    arm: str
    simulated_erratum: SimulatedErratum


@dataclass(frozen=True)
class FormulaColumn(TableColumn[ArmErratum]):
    """A column of what is printed or derived: a formula where there is one, else words."""

    def value(self, row: ArmErratum) -> str:
        words: str = getattr(row.simulated_erratum.erratum, self.name)
        return words

    def tex(self, row: ArmErratum) -> str:
        """The formula as TeX; empty where there is none."""
        formula: str = getattr(row.simulated_erratum.erratum, f"{self.name}_tex")
        return formula

    def html(self, row: ArmErratum) -> str:
        return _draw_formula(self.tex(row)) if self.tex(row) else self.text(row)

    def markdown(self, row: ArmErratum) -> str:
        return f"${self.tex(row)}$" if self.tex(row) else super().markdown(row)


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


def _erratum_column(name: str, title: str | None, attribute: str = "") -> TableColumn[ArmErratum]:
    """A column of an erratum's attribute, which has the column's name unless another is given."""
    return TableColumn(name, title, f"simulated_erratum.erratum.{attribute or name}")


def _effect_column(
    name: str, title: str | None, scenario: str, part: str
) -> TableColumn[ArmErratum]:
    """A column of one part of an erratum's effect in a scenario; None without that effect."""

    def effect_value(row: ArmErratum) -> float | None:
        effect = row.simulated_erratum.effects.get(scenario)
        return None if effect is None else getattr(effect, part)

    return TableColumn(name, title, effect_value, ".2g")


_TEXTS = (
    _erratum_column("where", "where"),
    FormulaColumn("printed", "printed"),
    FormulaColumn("derived", "should read"),
    _erratum_column("remark", "remark"),
)
_DENIES = TableColumn[ArmErratum](
    "denies", "against claim", lambda row: ", ".join(row.simulated_erratum.erratum.denies)
)
_SIZES = (_erratum_column("size", "size"), _erratum_column("unit", "in"))
_TORQUE, _PD = "effect under 100 N m: angle [rad]", "effect under PD control: angle [rad]"
_EFFECTS = (
    _erratum_column("relative", "over its own size"),
    _effect_column("constant_torque_theta_rad", _TORQUE, "constant-torque", "theta_rad"),
    _effect_column("constant_torque_force_N", "mesh force [N]", "constant-torque", "mesh_force_N"),
    _effect_column("pd_theta_rad", _PD, "pd", "theta_rad"),
    _effect_column("pd_impulse_N_s", "impulse of a mesh [N s]", "pd", "impulse_N_s"),
)
_UNSEEN = (
    _erratum_column("class", None, "kind"),
    _erratum_column("printed_tex", None),
    _erratum_column("derived_tex", None),
    _effect_column("constant_torque_impulse_N_s", None, "constant-torque", "impulse_N_s"),
    _effect_column("pd_force_N", None, "pd", "mesh_force_N"),
)


def _id(row: ArmErratum) -> str:
    return f"erratum/{row.arm}/{row.simulated_erratum.erratum.id}"


WHOLE = Columns[ArmErratum](
    _id, (*_UNSEEN, *_TEXTS, _DENIES, *_SIZES, *_EFFECTS)
)  # all of an erratum
BY_CLASS: dict[ErratumClass, Columns[ArmErratum]] = {
    "equation": WHOLE,
    "statement": Columns(_id, (*_TEXTS, _DENIES, *_SIZES)),
    "notation": Columns(_id, _TEXTS),
}
CONTRADICTIONS = Columns[Contradiction](
    lambda row: f"contradiction/{row.id}",
    (
        TableColumn("first", "here"),
        TableColumn("first_says", "it says"),
        TableColumn("second", "there"),
        TableColumn("second_says", "it says"),
    ),
)
GAPS = Columns[Gap](
    lambda row: f"gap/{row.id}",
    (
        TableColumn("quantity", "not given in the text"),
        TableColumn("needed_for", "needed for"),
        TableColumn("here", "here"),
    ),
)

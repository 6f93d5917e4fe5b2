"""The errata sheet: what one could send to the authors, as a chapter and as Markdown."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache

import matplotlib as mpl
from markupsafe import Markup
from matplotlib.figure import Figure

from crosscheck.audit.errata.erratum import CLASSES, Class, SimulatedErratum
from crosscheck.audit.errata.finder import EFFECT_S, Errata
from crosscheck.audit.errata.words import Contradiction, Gap, in_words, notes
from crosscheck.audit.experiments.cells import LABELLED, READINGS
from crosscheck.audit.page.chapter import AuditChapter
from crosscheck.audit.page.columns import Columns, TableColumn
from crosscheck.audit.page.material import Material
from crosscheck.audit.page.text import html, text
from crosscheck.report.plots.figures import to_svg

ID, TITLE = "errata", "Errata sheet"
QUICK_S = 0.05
HEADINGS: dict[Class, str] = {
    "equation": "Errors of equations",
    "statement": "Statements and data without support",
    "notation": "Notation",
}


@dataclass(frozen=True)
class ErrataSheet(AuditChapter):
    """The chapter with the errata sheet; found: the errata of the first arm."""

    found: tuple[SimulatedErratum, ...] = ()


def chapter(material: Material) -> ErrataSheet:
    """The chapter of errata for both readings of Table I (quick: for the first alone)."""
    quick = material.scale.quick
    arms = [LABELLED] if quick else list(READINGS)
    duration = material.scale.seconds(QUICK_S if quick else EFFECT_S)
    answers = material.study.answers([Errata(name, duration) for name in arms], "errata sheet")
    by_arm = {arm: in_words(found) for arm, found in zip(arms, answers, strict=True)}
    return errata_sheet(by_arm, duration)


def errata_sheet(
    by_arm: Mapping[str, Sequence[SimulatedErratum]], duration_s: float
) -> ErrataSheet:
    """The chapter made of errata in words by arm, the first arm's as tables.

    duration_s: of the runs behind their effects.
    """
    first, noted = next(iter(by_arm)), notes()
    own = by_arm[first]
    rows = [ArmErratum(arm, one) for arm, found in by_arm.items() for one in found]
    page = text(
        "errata/sheet",
        duration_s=duration_s,
        arm=first,
        tables={HEADINGS[kind]: html(BY_CLASS[kind].html(_rows(own, kind))) for kind in CLASSES},
        counts=counted(own),
        apart=_apart(by_arm),
        contradictions=html(CONTRADICTIONS.html(noted.contradictions)),
        gaps=html(GAPS.html(noted.gaps)),
    )
    notes_json = [*CONTRADICTIONS.json(noted.contradictions), *GAPS.json(noted.gaps)]
    records = [*WHOLE.json(rows), *notes_json]
    outcome = text("errata/outcome", counts=counted(own))
    return ErrataSheet(ID, TITLE, page, records, outcome, tuple(own))


@dataclass(frozen=True)
class SheetCounts:
    """How many errata of each class, how many read alone, contradictions and gaps."""

    by_class: Mapping[Class, int]
    read: int
    contradictions: int
    gaps: int


def counted(found: Sequence[SimulatedErratum]) -> SheetCounts:
    """The counts of a sheet's errata, contradictions and gaps."""
    noted, kinds = notes(), Counter(one.erratum.kind for one in found)
    read = {misprint.id for misprint in noted.misprints}
    return SheetCounts(
        {kind: kinds[kind] for kind in CLASSES},
        sum(one.erratum.id in read for one in found),
        len(noted.contradictions),
        len(noted.gaps),
    )


def _rows(found: Sequence[SimulatedErratum], kind: Class) -> list[ArmErratum]:
    return [ArmErratum(LABELLED, one) for one in found if one.erratum.kind == kind]


def _apart(by_arm: Mapping[str, Sequence[SimulatedErratum]]) -> dict[str, list[str]]:
    """The places of the errata that one reading of Table I has and no other, by reading."""
    places = {arm: {one.erratum.where for one in found} for arm, found in by_arm.items()}
    return {
        arm: sorted(own.difference(*(p for other, p in places.items() if other != arm)))
        for arm, own in places.items()
        if len(places) > 1
    }


def markdown(found: Sequence[SimulatedErratum]) -> str:
    """The sheet as Markdown, formulas as TeX; the errata are the chapter's."""
    noted = notes()
    parts = ["# Errata sheet", text("errata/introduction", counts=counted(found)).strip()]
    for kind in CLASSES:
        parts += [f"## {HEADINGS[kind]}", BY_CLASS[kind].markdown(_rows(found, kind))]
    parts += [
        "## Where the text contradicts itself",
        CONTRADICTIONS.markdown(noted.contradictions),
        "## What is missing to reproduce it",
        GAPS.markdown(noted.gaps),
    ]
    return "\n\n".join(parts) + "\n"


@dataclass(frozen=True)
class ArmErratum:
    """An erratum with its size and effects for one arm."""

    arm: str
    found: SimulatedErratum


@dataclass(frozen=True)
class FormulaColumn(TableColumn[ArmErratum]):
    """A column of what is printed or derived: a formula where there is one, else words."""

    def value(self, row: ArmErratum) -> str:
        words: str = getattr(row.found.erratum, self.name)
        return words

    def tex(self, row: ArmErratum) -> str:
        """The formula as TeX; empty where there is none."""
        formula: str = getattr(row.found.erratum, f"{self.name}_tex")
        return formula

    def html(self, row: ArmErratum) -> str:
        return _drawn(self.tex(row)) if self.tex(row) else self.text(row)

    def markdown(self, row: ArmErratum) -> str:
        return f"${self.tex(row)}$" if self.tex(row) else super().markdown(row)


@lru_cache
def _drawn(tex: str) -> Markup:
    """A TeX formula as an <svg> element, set by Matplotlib's own typesetter."""
    with mpl.rc_context({"mathtext.fontset": "cm"}):
        figure = Figure(figsize=(0.1, 0.1))
        # The typesetter does not know these two commands.
        known = tex.replace(r"\left", "").replace(r"\right", "")
        drawn = figure.text(0, 0, f"${known}$", fontsize=13)
        box = drawn.get_window_extent()
        figure.set_size_inches((box.width + 8) / figure.dpi, (box.height + 8) / figure.dpi)
        drawn.set_position((4 / (box.width + 8), 4 / (box.height + 8) - box.y0 / (box.height + 8)))
        return Markup(to_svg(figure))  # of this package's own


def _of(name: str, title: str | None, attribute: str = "") -> TableColumn[ArmErratum]:
    """A column of an erratum's attribute, which has the column's name unless another is given."""
    return TableColumn(name, title, f"found.erratum.{attribute or name}")


def _effect(name: str, title: str | None, scenario: str, part: str) -> TableColumn[ArmErratum]:
    """A column of one part of an erratum's effect in a scenario; None without that effect."""

    def of(row: ArmErratum) -> float | None:
        effect = row.found.effects.get(scenario)
        return None if effect is None else getattr(effect, part)

    return TableColumn(name, title, of, ".2g")


_TEXTS = (
    _of("where", "where"),
    FormulaColumn("printed", "printed"),
    FormulaColumn("derived", "should read"),
    _of("remark", "remark"),
)
_SIZES = (_of("size", "size"), _of("unit", "in"))
_TORQUE, _PD = "effect under 100 N m: angle [rad]", "effect under PD control: angle [rad]"
_EFFECTS = (
    _of("relative", "over its own size"),
    _effect("constant_torque_theta_rad", _TORQUE, "constant-torque", "theta_rad"),
    _effect("constant_torque_force_N", "mesh force [N]", "constant-torque", "mesh_force_N"),
    _effect("pd_theta_rad", _PD, "pd", "theta_rad"),
    _effect("pd_impulse_N_s", "impulse of a mesh [N s]", "pd", "impulse_N_s"),
)
_UNSEEN = (
    _of("class", None, "kind"),
    _of("printed_tex", None),
    _of("derived_tex", None),
    _effect("constant_torque_impulse_N_s", None, "constant-torque", "impulse_N_s"),
    _effect("pd_force_N", None, "pd", "mesh_force_N"),
)


def _id(row: ArmErratum) -> str:
    return f"erratum/{row.arm}/{row.found.erratum.id}"


WHOLE = Columns[ArmErratum](_id, (*_UNSEEN, *_TEXTS, *_SIZES, *_EFFECTS))  # all of an erratum
BY_CLASS: dict[Class, Columns[ArmErratum]] = {
    "equation": WHOLE,
    "statement": Columns(_id, (*_TEXTS, *_SIZES)),
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
        TableColumn("quantity", "not given"),
        TableColumn("needed_for", "needed for"),
        TableColumn("here", "here"),
    ),
)

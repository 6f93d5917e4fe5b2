"""Figures 4 to 20 of the paper from this project's models, each beside the claims about it."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from crosscheck.audit.experiments.cells import LABELLED, LAWS, Law
from crosscheck.audit.experiments.experiments import PD
from crosscheck.audit.figures.control import (
    figure_10,
    figure_11,
    figure_12,
    figure_13,
    figure_14,
)
from crosscheck.audit.figures.laws import figure_4, figure_5
from crosscheck.audit.figures.open_loop import figure_6, figure_7, figure_8, figure_9, figure_15
from crosscheck.audit.figures.plate import Plate, Row, rows, said
from crosscheck.audit.figures.runs import LOW_ZETA, ZETA
from crosscheck.audit.figures.shelf import Shelf
from crosscheck.audit.figures.sweeps import figure_16, figure_17, figure_18, figure_19, figure_20
from crosscheck.audit.figures.views import severe_over_zeta
from crosscheck.audit.measures.shares import Share
from crosscheck.audit.measures.third import Third
from crosscheck.audit.measures.thresholds import SEVERE
from crosscheck.audit.page.chapter import AuditChapter
from crosscheck.audit.page.material import Material
from crosscheck.audit.page.text import html, text
from crosscheck.models.errors import Diverged

PLATES: dict[int, Callable[[Shelf], Plate]] = {
    4: figure_4,
    5: figure_5,
    6: figure_6,
    7: figure_7,
    8: figure_8,
    9: figure_9,
    10: figure_10,
    11: figure_11,
    12: figure_12,
    13: figure_13,
    14: figure_14,
    15: figure_15,
    16: figure_16,
    17: figure_17,
    18: figure_18,
    19: figure_19,
    20: figure_20,
}
NUMBERS = tuple(PLATES)
ID, TITLE = "figures", "Figures 4 to 20"
QUICK_NUMBERS = (4, 5, 6, 8, 14, 17)


def chapter(material: Material) -> AuditChapter:
    """All figures, or six of them."""
    shelf = Shelf(material)
    numbers = QUICK_NUMBERS if material.scale.quick else NUMBERS
    made = [(_made(shelf, number), _rows(shelf, number)) for number in numbers]
    drawn = [plate.html(found) for plate, found in made]
    return AuditChapter(
        ID,
        TITLE,
        "\n".join([_introduction(material), *drawn]),
        [plate.to_dict(found) for plate, found in made],
        text("figures/outcome", count=len(made), claims=sum(len(found) for _, found in made)),
        [one for plate, found in made for one in said(plate.number, found)],
    )


def alone(material: Material, numbers: Iterable[int]) -> str:
    """Some figures as html, without verdicts. Raises KeyError for a number not in NUMBERS."""
    shelf = Shelf(material, whole=False)
    return "\n".join(_made(shelf, number).html(_rows(shelf, number)) for number in numbers)


def _made(shelf: Shelf, number: int) -> Plate:
    """The plate; one without a drawing if a run behind it diverges."""
    told = shelf.material.study.told
    told(f"figure {number}", 0, 1)
    try:
        plate = PLATES[number](shelf)
    except Diverged as error:
        plate = Plate(number, [], reason=str(error))
    told(f"figure {number}", 1, 1)
    return plate


def _rows(shelf: Shelf, number: int) -> list[Row]:
    return rows(shelf, number, ZETAS.get(number, ZETA))


ZETAS = dict.fromkeys((8, 9, 11, 12, 13, 14, 16, 17, 18, 19, 20), LOW_ZETA)


def _introduction(material: Material) -> str:
    """How to read the figures, and what other damping does to the third fluctuation."""
    shares = {law: severe_shares(material, law) for law in LAWS}
    starts = material.scale.most_starts
    return text(
        "figures/introduction",
        svg=html(severe_over_zeta(shares)),
        zeta=ZETA,
        low_zeta=LOW_ZETA,
        severe=SEVERE,
        starts=starts,
        seed=material.scale.first_seed,
    )


def severe_shares(material: Material, law: Law) -> dict[float, Share | None]:
    """By zeta: how many starts have a severe third fluctuation; None where too few have any."""
    return {
        cell.zeta: Third.of(known[PD]).share
        for cell, known in material.settings
        if (cell.law, cell.arm) == (law, LABELLED)
    }

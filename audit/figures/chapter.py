"""Figures 4 to 20 of the paper from this project's models, each beside the claims about it."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import partial

from crosscheck.audit.experiments.cells import LABELLED, LAWS, Law
from crosscheck.audit.experiments.experiments import PD
from crosscheck.audit.figures import angles, laws, over_laws, sweeps
from crosscheck.audit.figures.plate import Plate, Row, rows
from crosscheck.audit.figures.shelf import LOW_ZETA, ZETA, Shelf
from crosscheck.audit.figures.views import severe_over_zeta
from crosscheck.audit.measures.shares import Share
from crosscheck.audit.measures.third import Third
from crosscheck.audit.measures.thresholds import SEVERE
from crosscheck.audit.page.chapter import AuditChapter
from crosscheck.audit.page.material import Material
from crosscheck.audit.page.text import html, text
from crosscheck.models.errors import Diverged

PLATES: dict[int, Callable[[Shelf], Plate]] = {
    4: laws.figure_4,
    5: laws.figure_5,
    6: partial(angles.deviations, number=6, quantity="theta", symbol="Δθ", unit="rad"),
    7: partial(angles.deviations, number=7, quantity="theta_dot", symbol="Δω", unit="rad/s"),
    **{number: partial(over_laws.over_laws, number=number) for number in (8, 9)},
    10: angles.figure_10,
    **{number: partial(over_laws.over_laws, number=number) for number in (11, 12, 13)},
    14: over_laws.figure_14,
    15: angles.figure_15,
    16: partial(sweeps.over_sizes, number=16),
    17: sweeps.figure_17,
    **{number: partial(sweeps.over_sizes, number=number) for number in (18, 19, 20)},
}
NUMBERS = tuple(PLATES)
ID, TITLE = "figures", "Figures 4 to 20"
QUICK_NUMBERS = (4, 5, 6, 8, 14, 17)


def chapter(material: Material) -> AuditChapter:
    """The chapter with all figures, or with six of them if quick."""
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
    )


def alone(material: Material, numbers: Iterable[int]) -> str:
    """Some figures as html, without verdicts. Raises KeyError for a number not in NUMBERS."""
    shelf = Shelf(material, whole=False)
    return "\n".join(_made(shelf, number).html(_rows(shelf, number)) for number in numbers)


def _made(shelf: Shelf, number: int) -> Plate:
    """The plate of a figure; one without a drawing if a run behind it diverges."""
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
    """The chapter's introduction, with what other damping does to the third fluctuation."""
    shares: dict[Law, dict[float, Share | None]] = {law: {} for law in LAWS}
    for cell, known in material.settings:
        if cell.arm == LABELLED:
            shares[cell.law][cell.zeta] = Third.of(known[PD]).share
    return text(
        "figures/introduction",
        svg=html(severe_over_zeta(shares)),
        zeta=ZETA,
        low_zeta=LOW_ZETA,
        severe=SEVERE,
        starts=material.scale.most_starts,
        seed=material.scale.first_seed,
    )

"""Figures 4 to 20 of the paper from this project's models, each beside the claims about it."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from crosscheck.audit.experiments.cells import LABELLED, LAWS, Law
from crosscheck.audit.experiments.experiments import BACKLASH, ERROR, PD
from crosscheck.audit.figures import control, laws, open_loop, sweeps
from crosscheck.audit.figures.plate import Plate, Row, rows
from crosscheck.audit.figures.runs import LOW_ZETA, ZETA
from crosscheck.audit.figures.shelf import Shelf
from crosscheck.audit.figures.views import MICRO, severe_over_zeta
from crosscheck.audit.measures.events import THIRD_S
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
    6: lambda shelf: open_loop.deviations(shelf, 6, "theta", "Δθ", "rad"),
    7: lambda shelf: open_loop.deviations(shelf, 7, "theta_dot", "Δω", "rad/s"),
    8: open_loop.figure_8,
    9: open_loop.figure_9,
    10: control.figure_10,
    11: lambda shelf: control.whole_run(shelf, 11, "torque", "T [N m]"),
    12: lambda shelf: control.whole_run(shelf, 12, "x_sp", "x_sp1 [µm]", MICRO),
    13: lambda shelf: control.whole_run(shelf, 13, "F_sp", "F_sp1 [N]"),
    14: control.figure_14,
    15: open_loop.figure_15,
    16: lambda shelf: sweeps.forces_over(
        shelf, 16, BACKLASH, sweeps.IMPACT_WINDOW_S, sweeps.IMPACT_AXES
    ),
    17: sweeps.figure_17,
    18: lambda shelf: sweeps.spectra_over(shelf, 18, BACKLASH, sweeps.BACKLASH_AXES),
    19: lambda shelf: sweeps.forces_over(shelf, 19, ERROR, THIRD_S, sweeps.THIRD_AXES),
    20: lambda shelf: sweeps.spectra_over(shelf, 20, ERROR, sweeps.ERROR_AXES),
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

"""Figures 4 to 20 of the paper from this project's models, each with what the paper says of it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable

from crosscheck.paper.figures.control import figure_10, figure_11, figure_12, figure_13
from crosscheck.paper.figures.forces import figure_16, figure_17, figure_19
from crosscheck.paper.figures.laws import figure_4, figure_5
from crosscheck.paper.figures.motion import figure_14, figure_15
from crosscheck.paper.figures.plate import Plate, Shelf, undrawn
from crosscheck.paper.figures.runs import LAWS, LOW_ZETA, ZETA
from crosscheck.paper.figures.spectra import figure_18, figure_20
from crosscheck.paper.figures.store import trajectories
from crosscheck.paper.figures.torque import figure_6, figure_7, figure_8, figure_9
from crosscheck.paper.scale import FULL, Scale
from crosscheck.report.chapter import Chapter, rendered
from crosscheck.studies.study import Study
from models.errors import Diverged

__all__ = ["NUMBERS", "chapter", "figure", "trajectories"]

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


def chapter(study: Study, scale: Scale) -> Chapter:
    """All figures, or six of them."""
    shelf = Shelf(study, scale)
    plates = [_made(shelf, number) for number in (QUICK_NUMBERS if scale.quick else NUMBERS)]
    html = "\n".join([_introduction(), *(plate.html() for plate in plates)])
    return Chapter(ID, TITLE, html, rendered(plates), _outcome(plates))


def _outcome(plates: list[Plate]) -> str:
    counts = Counter(verdict for plate in plates for verdict in plate.verdicts.values())
    found = "; ".join(f"{verdict}: {count}" for verdict, count in counts.most_common())
    return f"of what they show: {found}."


def figure(study: Study, number: int, scale: Scale = FULL) -> str:
    """One figure as html. Raises KeyError for a number that is not in NUMBERS."""
    return _made(Shelf(study, scale), number).html()


def _made(shelf: Shelf, number: int) -> Plate:
    """The plate; one without a drawing if a run behind it diverges."""
    shelf.study.told(f"figure {number}", 0, 1)
    try:
        plate = PLATES[number](shelf)
    except Diverged as error:
        plate = undrawn(number, str(error))
    shelf.study.told(f"figure {number}", 1, 1)
    return plate


def _introduction() -> str:
    left, right = LAWS.values()
    return (
        "<p>Each figure of the paper redrawn from this project's models, with what the paper says"
        f" of it. Where the mesh phase matters, the paper's law ({left}) stands on the left and its"
        f" integral ({right}) on the right, at zeta {LOW_ZETA:g}, where the paper's third"
        f" fluctuation can show; elsewhere zeta is {ZETA:g}. The paper gives no damping. Signals"
        " too fast for the page are drawn as bands from minima to maxima; shaded parts are enlarged"
        " below. A verdict here is about the figure at its parameters: <i>holds</i> (under angle),"
        " <i>only with omega_t</i>, <i>only with angle</i>, <i>does not hold</i> or"
        " <i>undefined</i>, where a run does not show what it is about; the claims table has the"
        " wider ranges.</p>"
    )

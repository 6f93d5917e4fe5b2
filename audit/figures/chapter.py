"""Figures 4 to 20 of the paper from this project's models, each beside the claims about it."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import partial

from crosscheck.audit.figures import laws, run_figures, sweeps
from crosscheck.audit.figures.figure_data import LOW_ZETA, ZETA, FigureData, PaperFigure
from crosscheck.audit.page.chapter import AuditChapter, render_template
from crosscheck.audit.page.context import AuditContext
from crosscheck.models.errors import Diverged

FIGURE_FUNCTIONS: dict[int, Callable[[FigureData], PaperFigure]] = {
    4: laws.draw_figure_4,
    5: laws.draw_figure_5,
    6: partial(run_figures.draw_deviations, number=6, quantity="theta", label="Δθ [rad]"),
    7: partial(run_figures.draw_deviations, number=7, quantity="theta_dot", label="Δω [rad/s]"),
    **{number: partial(run_figures.draw_law_figure, number=number) for number in (8, 9)},
    10: run_figures.draw_figure_10,
    **{number: partial(run_figures.draw_law_figure, number=number) for number in (11, 12, 13)},
    14: run_figures.draw_figure_14,
    15: run_figures.draw_figure_15,
    **{number: partial(sweeps.draw_sweep_figure, number=number) for number in range(16, 21)},
}
NUMBERS = tuple(FIGURE_FUNCTIONS)
ID, TITLE = "figures", "Figures 4 to 20"


def build_chapter(context: AuditContext) -> AuditChapter:
    """The chapter with all figures."""
    figures = draw_figures(context, NUMBERS)
    return AuditChapter(
        ID,
        TITLE,
        "\n".join([_introduction(context), *(figure.to_html() for figure in figures)]),
        [figure.to_dict() for figure in figures],
        f"{len(figures)} figures redrawn, with what the paper says of each.",
    )


def draw_figures(context: AuditContext, numbers: Iterable[int]) -> list[PaperFigure]:
    """The figures of these numbers. Raises KeyError for a number not in NUMBERS."""
    data = FigureData(context)
    return [_draw_figure(data, number) for number in numbers]


def _draw_figure(data: FigureData, number: int) -> PaperFigure:
    """The plate of a figure; one without a drawing if a run behind it diverges."""
    progress = data.context.study.progress
    progress(f"figure {number}", 0, 1)
    try:
        figure = FIGURE_FUNCTIONS[number](data)
    except Diverged as error:
        figure = PaperFigure(number, [], reason=str(error))
    progress(f"figure {number}", 1, 1)
    return figure


def _introduction(context: AuditContext) -> str:
    """The chapter's introduction."""
    return render_template(
        "figures/introduction", zeta=ZETA, low_zeta=LOW_ZETA, seed=context.scale.first_seed
    )

"""Figures 4 to 20 of the paper from this project's models, each beside the claims about it."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import partial
from typing import NamedTuple

import numpy as np

from crosscheck.analytic.paper.mesh_force import dead_zone, dead_zone_tanh
from crosscheck.analytic.paper.stiffness import (
    fundamental_stiffness,
    square_wave,
    square_wave_series,
)
from crosscheck.audit.claims.study_plan import AuditContext
from crosscheck.audit.figures import run_figures, sweeps
from crosscheck.audit.figures.figure_data import LOW_ZETA, ZETA, Drawing, FigureData, PaperFigure
from crosscheck.audit.figures.plotting import MICRO, Curve, Panel, draw_panels
from crosscheck.audit.measures.stage import paper_stage
from crosscheck.audit.page.chapter import AuditChapter, render_template
from crosscheck.models.errors import Diverged
from crosscheck.models.loading import load_arm
from crosscheck.report import fragments
from crosscheck.report.fragments import COLOURS

ARM = "paper-labelled"
SHARPNESS_PER_M = (2e4, 5e4, 2e5, 1e6)  # the paper gives no sigma
HARMONICS = (1, 3, 9, 31)
MANY = 501  # for the limit of Eq. 7
CONTACT_RATIO = 1.5
SAME = 1e-12  # two printed expressions of one harmonic: rounding alone may differ
AWAY = 0.02  # of a period: this far from its jumps a truncated series can be asked to converge


def draw_figure_4(data: FigureData) -> PaperFigure:
    """The plate of Fig. 4: Eq. 6 for several sigma against Eq. 5."""
    b = paper_stage(load_arm(ARM)).backlash_m
    x = np.linspace(-3 * b, 3 * b, 3001)
    edge = MICRO * b
    curves = [Curve(MICRO * x, MICRO * dead_zone(x, b), "k", "Eq. 5", "--", 1.6)]
    for sigma, colour in zip(SHARPNESS_PER_M, COLOURS, strict=False):
        values = MICRO * dead_zone_tanh(x, b, sigma)
        curves.append(Curve(MICRO * x, values, colour, f"Eq. 6, sigma {sigma:g} 1/m"))
    label = {"ylabel": "f_k [µm]"}
    closely = {"xlim": (0.4 * edge, 1.6 * edge), "ylim": (-0.2 * edge, 0.6 * edge)}
    close = Panel(curves, {**label, **closely, "title": "the edge of the clearance"})
    rows = [tanh_sharpness(x, b, sigma) for sigma in SHARPNESS_PER_M]
    deviations = ("largest deviation [µm]", "deviation times sigma", "pull outside contact [µm]")
    scaled_rows = [(r.sigma, MICRO * r.gap_m, r.gap_m * r.sigma, MICRO * r.pull_m) for r in rows]
    cells = [[f"{value:.3g}" for value in row] for row in scaled_rows]
    caption = f"b {edge:g} µm; sigma as in the legend, the paper gives none."
    return PaperFigure(
        4,
        [Drawing(draw_panels(2.8, "x [µm]", [Panel(curves, label), close]), caption)],
        tables={"sharpness": fragments.render_table(["sigma [1/m]", *deviations], cells)},
        numbers={"deviation_um": {f"{row.sigma:g}": MICRO * row.gap_m for row in rows}},
    )


class TanhSharpness(NamedTuple):
    """Eq. 6 at a sigma [1/m]: largest deviation from Eq. 5, largest pull outside contact [m]."""

    sigma: float
    gap_m: float
    pull_m: float


def tanh_sharpness(x: np.ndarray, b: float, sigma: float) -> TanhSharpness:
    """How sharp Eq. 6 is at a sigma [1/m], over displacements x [m] with the backlash b [m]."""
    smooth = dead_zone_tanh(x, b, sigma)
    gap = np.abs(smooth - dead_zone(x, b)).max()
    return TanhSharpness(sigma, float(gap), float(-smooth[x > 0].min()))


def draw_figure_5(data: FigureData) -> PaperFigure:
    """The plate of Fig. 5: Eq. 7 with n harmonics, its fundamental, and Eq. 8."""
    stage = paper_stage(load_arm(ARM))
    k_m, k_a = stage.mesh_stiffness_N_per_m, stage.mesh_stiffness_amplitude_N_per_m
    low, high = stiffness_limits(k_m, k_a, CONTACT_RATIO)
    cycle = np.linspace(0, 2, 2001)
    series = {n: square_wave_series(cycle, low, high, CONTACT_RATIO, n) for n in (*HARMONICS, MANY)}
    eq8 = fundamental_stiffness(np.sin(2 * np.pi * cycle), k_m, k_a)
    wave = square_wave(cycle, low, high, CONTACT_RATIO)
    square = Curve(cycle, wave, "k", "square wave", "--", 1.6)
    shown = [
        Curve(cycle, series[n], colour, f"Eq. 7, n = {n}", width=1.0)
        for n, colour in zip(HARMONICS, COLOURS, strict=False)
    ]
    sine = Curve(cycle, eq8, COLOURS[4], "Eq. 8", ":", 2.4)
    label = {"ylabel": "k [N/m]"}
    drawn = [Panel([square, *shown[1:]], label), Panel([square, shown[0], sine], label)]
    smooth = np.abs(np.mod(2 * cycle + 0.5, 1) - 0.5) > 2 * AWAY
    caption = f"k_m {k_m:g} N/m, k_a {k_a:g} N/m; all pairs in phase (gamma = 0)."
    return PaperFigure(
        5,
        [Drawing(draw_panels(2.8, "t / T", drawn), caption)],
        numbers={
            "k_max_N_per_m": high,
            "k_min_N_per_m": low,
            "eq8_is_the_fundamental": bool(np.abs(series[1] - eq8).max() <= SAME * k_m),
            "series_error": float(np.abs(series[MANY] - wave)[smooth].max() / (high - low)),
            "variance_kept": float(np.var(eq8[:-1]) / np.var(wave[:-1])),
        },
    )


def stiffness_limits(k_m: float, k_a: float, contact_ratio: float) -> tuple[float, float]:
    """The stiffnesses k_min and k_max [N/m] with mean k_m and a fundamental of amplitude k_a.

    Eq. 7, i = 1: sin(2 pi (e - 1) - u) + sin(u) has the amplitude 2 |sin(pi (e - 1))|.
    """
    swing = np.pi * k_a / (2 * abs(np.sin(np.pi * (contact_ratio - 1))))
    low = k_m - swing * (contact_ratio - 1)
    return float(low), float(low + swing)


FIGURE_FUNCTIONS: dict[int, Callable[[FigureData], PaperFigure]] = {
    4: draw_figure_4,
    5: draw_figure_5,
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

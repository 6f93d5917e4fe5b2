"""Figures 4 and 5: the clearance function and the stiffness wave."""

from __future__ import annotations

import numpy as np

from analytic.backlash import dead_zone, dead_zone_tanh
from analytic.stiffness import fundamental, square_wave, square_wave_series
from crosscheck.paper.figures.plate import MICRO, Plate, Shelf, table
from crosscheck.paper.figures.verdicts import accurate, same, verdict
from crosscheck.paper.stage import paper_stage
from crosscheck.report.figures import legend, new_figure, to_svg
from crosscheck.report.fragments import COLOURS
from models.loading import load_arm

ARM = "paper-labelled"
SHARPNESS_PER_M = (2e4, 5e4, 2e5, 1e6)  # the paper gives no sigma
HARMONICS = (1, 3, 9, 31)
MANY = 501  # for the limit of Eq. 7
CONTACT_RATIO = 1.5
OTHER_RATIOS = (1.2, 1.4, CONTACT_RATIO, 1.6, 1.8)
AWAY = 0.02  # of a period: this far from its jumps a truncated series can be asked to converge


def figure_4(shelf: Shelf) -> Plate:
    """Eq. 6 for several sigma against Eq. 5."""
    b = paper_stage(load_arm(ARM)).backlash_m
    x = np.linspace(-3 * b, 3 * b, 3001)
    exact = dead_zone(x, b)
    rows = []
    for sigma in SHARPNESS_PER_M:
        smooth = dead_zone_tanh(x, b, sigma)
        gap = float(np.abs(smooth - exact).max())
        pull = float(-smooth[x > 0].min())
        rows.append((sigma, sigma * b, MICRO * gap, gap * sigma, MICRO * pull))
    sharpest = rows[-1][2] / MICRO
    head = ("sigma [1/m]", "sigma b", "largest deviation [µm]", "deviation x sigma", "pull [µm]")
    return Plate(
        4,
        "clearance function",
        _clearance_svg(x, b),
        "Eq. 6, made of hyperbolic tangents, stands in for the piecewise Eq. 5; with sigma large"
        " enough it is called sufficiently accurate. No value of sigma is given.",
        "The deviation falls as 1 / sigma. Eq. 6 is not monotone: just below contact it pulls the"
        " teeth together, which no clearance does (the dip at the right). All runs of this report"
        " use Eq. 5.",
        f"b {MICRO * b:g} µm; sigma as in the legend.",
        {f"accurate at sigma = {SHARPNESS_PER_M[-1]:g} 1/m": verdict(accurate(sharpest, b))},
        {"deviation_um": {f"{row[0]:g}": row[2] for row in rows}},
        table(head, rows),
    )


def _clearance_svg(x: np.ndarray, b: float) -> str:
    figure, grid = new_figure(1, 2, 2.8)
    for axes in grid[0]:
        axes.plot(MICRO * x, MICRO * dead_zone(x, b), "k--", label="Eq. 5", linewidth=1.6)
        for sigma, colour in zip(SHARPNESS_PER_M, COLOURS, strict=False):
            values = MICRO * dead_zone_tanh(x, b, sigma)
            axes.plot(MICRO * x, values, color=colour, label=f"Eq. 6, sigma {sigma:g} 1/m")
        axes.set(xlabel="x [µm]", ylabel="f_k [µm]")
    edge = MICRO * b
    grid[0, 1].set(xlim=(0.4 * edge, 1.6 * edge), ylim=(-0.2 * edge, 0.6 * edge))
    grid[0, 1].set_title("the edge of the clearance")
    legend(figure, grid[0, 0])
    return to_svg(figure)


def figure_5(shelf: Shelf) -> Plate:
    """Eq. 7 with n harmonics, its fundamental, and Eq. 8."""
    stage = paper_stage(load_arm(ARM))
    k_m, k_a = stage.mesh_stiffness_N_per_m, stage.mesh_stiffness_amplitude_N_per_m
    low, high = limits(k_m, k_a, CONTACT_RATIO)
    cycle = np.linspace(0, 2, 2001)
    series = {n: square_wave_series(cycle, low, high, CONTACT_RATIO, n) for n in (*HARMONICS, MANY)}
    eq8 = fundamental(np.sin(2 * np.pi * cycle), k_m, k_a)
    wave = square_wave(cycle, low, high, CONTACT_RATIO)
    gap = float(np.abs(series[1] - eq8).max())
    smooth = np.abs(np.mod(2 * cycle + 0.5, 1) - 0.5) > 2 * AWAY
    limit = float(np.abs(series[MANY] - wave)[smooth].max() / (high - low))
    kept = float(np.var(eq8[:-1]) / np.var(wave[:-1]))
    rows = [ratio_row(ratio, k_m, k_a) for ratio in OTHER_RATIOS]
    head = ("contact ratio", "phase of the fundamental [deg]", "k_max - k_min [N/m]", "mean [N/m]")
    seen = (
        f"Only contact ratio {CONTACT_RATIO:g} gives the fundamental zero phase. Eq. 7 as printed"
        " then makes its amplitude 2 (k_max - k_min) / pi, so that k_max - k_min = pi k_a / 2 ="
        f" {high - low:.4g} N/m, k_max = {high:.4g}, k_min = {low:.4g} N/m. Eq. 7 with one harmonic"
        f" differs from Eq. 8 by {gap:.2g} N/m, with {MANY} harmonics from the square wave by"
        f" {100 * limit:.2g} % away from its jumps. Eq. 8 keeps {100 * kept:.1f} % of the wave's"
        " variance."
    )
    return Plate(
        5,
        "time-variant stiffness",
        _stiffness_svg(cycle, wave, series, eq8),
        "The stiffness is a square wave between k_min (one pair of teeth) and k_max (two pairs);"
        " of its Fourier series, Eq. 7, the fundamental, Eq. 8, is deemed sufficient. Contact"
        " ratio, k_max and k_min are not given.",
        seen,
        f"k_m {k_m:g} N/m, k_a {k_a:g} N/m; the phase difference gamma of other pairs is zero.",
        {
            "Eq. 8 is the fundamental of Eq. 7": verdict(same(gap, k_m)),
            "Eq. 7 is the series of the square wave": verdict(limit < AWAY),
        },
        {"k_max_N_per_m": high, "k_min_N_per_m": low, "variance_kept": kept},
        table(head, rows),
    )


def limits(k_m: float, k_a: float, contact_ratio: float) -> tuple[float, float]:
    """(k_min, k_max) [N/m] with mean k_m and a fundamental of amplitude k_a.

    Eq. 7, i = 1: sin(2 pi (e - 1) - u) + sin(u) has the amplitude 2 |sin(pi (e - 1))|.
    """
    swing = np.pi * k_a / (2 * abs(np.sin(np.pi * (contact_ratio - 1))))
    low = k_m - swing * (contact_ratio - 1)
    return float(low), float(low + swing)


def ratio_row(contact_ratio: float, k_m: float, k_a: float) -> tuple[float, float, float, float]:
    """(contact ratio, phase of Eq. 7's fundamental [deg], k_max - k_min, mean [N/m])."""
    low, high = limits(k_m, k_a, contact_ratio)
    cycle = np.arange(360) / 360
    wave = square_wave_series(cycle, low, high, contact_ratio, 1)
    sine = np.fft.rfft(wave)[1] * 1j  # of amplitude x sin(u + phase)
    phase = float(np.round(np.degrees(np.angle(sine)), 9)) + 0.0
    return contact_ratio, phase, high - low, float(wave.mean())


def _stiffness_svg(
    cycle: np.ndarray, wave: np.ndarray, series: dict[int, np.ndarray], eq8: np.ndarray
) -> str:
    figure, grid = new_figure(1, 2, 2.8)
    for axes in grid[0]:
        axes.plot(cycle, wave, "k--", label="square wave", linewidth=1.6)
        axes.set(xlabel="t / T", ylabel="k [N/m]")
    for n, colour in zip(HARMONICS, COLOURS, strict=False):
        axes = grid[0, int(n == 1)]
        axes.plot(cycle, series[n], color=colour, label=f"Eq. 7, n = {n}", linewidth=1.0)
    grid[0, 1].plot(cycle, eq8, ":", color=COLOURS[4], label="Eq. 8", linewidth=2.4)
    legend(figure, *grid[0])
    return to_svg(figure)

"""Figures 18 and 20: spectra of both joints' accelerations over backlash and over tooth error."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import xarray as xr

from crosscheck.envelope import envelope
from crosscheck.paper import signals
from crosscheck.paper.figures.measures import HIGHEST_HZ, SPECTRUM_S, Line, line, spectrum_part
from crosscheck.paper.figures.plate import COLOURS, Plate, Shelf, conditions, same_scale, table
from crosscheck.paper.figures.runs import (
    BACKLASHES_UM,
    ERRORS_UM,
    LAWS,
    backlash_run,
    error_run,
)
from crosscheck.paper.figures.verdicts import (
    LINE,
    by_law,
    continuous,
    falls,
    near,
    rises,
    stands_out,
)
from crosscheck.report.figures import new_figure, to_svg

Sweep = Mapping[str, Mapping[float, xr.Dataset]]
Lines = dict[float, list[Line]]  # size -> shoulder, elbow
DRAWN = 300  # points of a spectrum: the largest line of every 20 Hz
STATED_HZ, TOLERANCE = 1500.0, 0.15  # "approximately", Section 4.1
PAPERS_B_UM, CONTINUOUS_UM = 50.0, 500


def figure_18(shelf: Shelf) -> Plate:
    """Over b."""
    sweep = shelf.sweep(18, BACKLASHES_UM, backlash_run)
    lines = {law: _lines(row) for law, row in sweep.items()}
    own = {law: row[PAPERS_B_UM][0] for law, row in lines.items()}
    return Plate(
        18,
        "spectra of the accelerations in the third fluctuation, for several backlashes",
        _spectra_svg(sweep, "b"),
        "The fundamental is near 1500 Hz with several multiples; it drifts down as the backlash"
        " grows, and above 500 µm the spectrum is continuous. The elbow's magnitude is much greater"
        " than the shoulder's.",
        _text("b", lines),
        conditions(sweep["angle"][PAPERS_B_UM], "b as in the legend."),
        {
            f"a line near {STATED_HZ:g} Hz at b = {PAPERS_B_UM:g} µm": by_law(
                {law: _near_stated(shoulder) for law, shoulder in own.items()}
            ),
            "the fluctuation's line drifts down as b grows": by_law(
                {law: _drifts(row) for law, row in lines.items()}
            ),
            f"lines below b = {CONTINUOUS_UM} µm, a continuous spectrum from there": by_law(
                {law: _fades(row) for law, row in lines.items()}
            ),
            "the elbow's line is larger than the shoulder's": by_law(_elbow(lines)),
        },
        {"laws": {law: _keyed("b", row) for law, row in lines.items()}},
    )


def figure_20(shelf: Shelf) -> Plate:
    """Over E."""
    sweep = shelf.sweep(20, ERRORS_UM, error_run)
    lines = {law: _lines(row) for law, row in sweep.items()}
    return Plate(
        20,
        "spectra of the accelerations in the third fluctuation, for several tooth errors",
        _spectra_svg(sweep, "E"),
        "Below 5 µm there are minor chaotic components, above it the self-excited fluctuation shows"
        " with the components of Fig. 18; from 5 to 6.3 µm it increases dramatically. The elbow's"
        " high frequencies are larger than the shoulder's.",
        _text("E", lines),
        conditions(sweep["angle"][5], "E as in the legend."),
        {
            "a fluctuation that grows with E": by_law(
                {
                    law: stands_out(_shoulder(row).max()) and rises(list(row), list(_shoulder(row)))
                    for law, row in lines.items()
                }
            ),
            "minor only below 5 µm": by_law({law: _minor_below(row) for law, row in lines.items()}),
            "the elbow's line is larger than the shoulder's": by_law(_elbow(lines)),
        },
        {"laws": {law: _keyed("E", row) for law, row in lines.items()}},
    )


def _lines(row: Mapping[float, xr.Dataset]) -> Lines:
    return {size: [line(run, joint) for joint in (0, 1)] for size, run in row.items()}


def _shoulder(lines: Lines) -> np.ndarray:
    return np.array([shoulder.size_rad_per_s2 for shoulder, _ in lines.values()])


def _drifts(lines: Lines) -> bool:
    """Among the backlashes at which there is a fluctuation, at least three."""
    found = {
        b: shoulder.frequency_Hz
        for b, (shoulder, _) in lines.items()
        if stands_out(shoulder.size_rad_per_s2)
    }
    return len(found) >= 3 and falls(list(found), list(found.values()))


def _near_stated(line: Line) -> bool:
    return stands_out(line.size_rad_per_s2) and near(line.frequency_Hz, STATED_HZ, TOLERANCE)


def _fades(lines: Lines) -> bool:
    """A continuous spectrum from 500 um on, lines below."""
    return all(continuous(s.prominence) == (b >= CONTINUOUS_UM) for b, (s, _) in lines.items())


def _elbow(lines: Mapping[str, Lines]) -> dict[str, bool]:
    return {
        law: all(
            elbow.size_rad_per_s2 > shoulder.size_rad_per_s2 for shoulder, elbow in row.values()
        )
        for law, row in lines.items()
    }


def _minor_below(lines: Lines, size_um: float = 5) -> bool:
    """No fluctuation below a size, and one from it on."""
    return all(
        stands_out(shoulder.size_rad_per_s2) == (size >= size_um)
        for size, (shoulder, _) in lines.items()
    )


def _keyed(symbol: str, row: Lines) -> dict[str, dict[str, dict[str, float]]]:
    return {
        f"{symbol} {size:g} um": {"shoulder": shoulder._asdict(), "elbow": elbow._asdict()}
        for size, (shoulder, elbow) in row.items()
    }


def _text(symbol: str, lines: Mapping[str, Lines]) -> str:
    begin, end = SPECTRUM_S
    rows = [
        (law, size, *shoulder, *elbow)
        for law, row in lines.items()
        for size, (shoulder, elbow) in row.items()
    ]
    columns = ("line [Hz]", "size [rad/s²]", "over the median")
    joints = [f"{j}, {u}" for j in ("shoulder", "elbow") for u in columns]
    return (
        f"Window {begin:g} to {end:g} s, mean removed (so nothing stands at 0 Hz), Hann; largest"
        f" line above 100 Hz. A line of {LINE:g} rad/s² counts as a fluctuation."
        f"{table(('phase law', f'{symbol} [µm]', *joints), rows)}"
    )


def _spectra_svg(sweep: Sweep, symbol: str) -> str:
    figure, grid = new_figure(2, len(sweep), 2.4)
    for column, (law, row) in enumerate(sweep.items()):
        grid[0, column].set_title(LAWS[law])
        grid[-1, column].set_xlabel("frequency [Hz]")
        for joint, axes in enumerate(grid[:, column]):
            for (size, run), colour in zip(row.items(), COLOURS, strict=False):
                frequency, amplitudes = signals.spectrum(*spectrum_part(run, joint))
                kept = frequency <= HIGHEST_HZ
                centres, _, high = envelope(frequency[kept], amplitudes[kept], DRAWN)
                label = f"{symbol} {size:g} µm"
                axes.plot(centres, high, color=colour, label=label, linewidth=0.8)
            axes.set(yscale="log", ylabel=f"{('shoulder', 'elbow')[joint]} [rad/s²]")
    same_scale(grid)
    grid[0, -1].legend(frameon=False, fontsize=7, ncols=2)
    return to_svg(figure)

"""Figures 18 and 20: spectra of both joints' accelerations over backlash and over tooth error."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import xarray as xr

from crosscheck import signals
from crosscheck.envelope import envelope
from crosscheck.paper.figures.measures import HIGHEST_HZ, SPECTRUM_S, Line, line, spectrum_part
from crosscheck.paper.figures.plate import (
    Plate,
    Shelf,
    conditions,
    same_scale,
    table,
)
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
    larger,
    near,
    rises,
    stands_out,
)
from crosscheck.paper.undefined import all_of, known
from crosscheck.report.figures import legend, log_y, new_figure, to_svg
from crosscheck.report.fragments import COLOURS

Sweep = Mapping[str, Mapping[float, xr.Dataset]]
Lines = dict[float, list[Line]]  # size -> shoulder, elbow
FAINTEST = 1e-6  # rad/s^2: what is drawn of a spectrum
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
        HOW_READ,
        conditions(sweep["angle"][PAPERS_B_UM], "b as in the legend."),
        {
            f"a line near {STATED_HZ:g} Hz at b = {PAPERS_B_UM:g} µm": by_law(
                {law: near_stated(shoulder) for law, shoulder in own.items()}
            ),
            "the fluctuation's line drifts down as b grows": by_law(
                {law: drifts(row) for law, row in lines.items()}
            ),
            f"lines below b = {CONTINUOUS_UM} µm, a continuous spectrum from there": by_law(
                {law: fades(row) for law, row in lines.items()}
            ),
            "the elbow's line is larger than the shoulder's": by_law(_elbow(lines)),
        },
        {"laws": {law: _keyed("b", row) for law, row in lines.items()}},
        _table("b", lines),
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
        HOW_READ,
        conditions(sweep["angle"][5], "E as in the legend."),
        {
            "a fluctuation that grows with E": by_law(
                {law: grows_with_error(row) for law, row in lines.items()}
            ),
            "minor only below 5 µm": by_law({law: minor_below(row) for law, row in lines.items()}),
            "the elbow's line is larger than the shoulder's": by_law(_elbow(lines)),
        },
        {"laws": {law: _keyed("E", row) for law, row in lines.items()}},
        _table("E", lines),
    )


def _lines(row: Mapping[float, xr.Dataset]) -> Lines:
    return {size: [line(run, joint) for joint in (0, 1)] for size, run in row.items()}


def of_shoulder(lines: Lines) -> np.ndarray:
    """Sizes of the shoulder's lines [rad/s^2]."""
    return np.array([shoulder.size_rad_per_s2 for shoulder, _ in lines.values()])


def grows_with_error(lines: Lines) -> bool | None:
    """Whether there is a fluctuation, and the shoulder's line grows with E."""
    sizes = of_shoulder(lines)
    return all_of((stands_out(sizes.max()), rises(list(lines), sizes)))


def drifts(lines: Lines) -> bool | None:
    """Among the backlashes at which there is a fluctuation, at least three."""
    if not known(of_shoulder(lines)):
        return None
    found = {
        b: shoulder.frequency_Hz
        for b, (shoulder, _) in lines.items()
        if stands_out(shoulder.size_rad_per_s2)
    }
    return len(found) >= 3 and falls(list(found), list(found.values()))


def near_stated(line: Line) -> bool | None:
    """Whether a fluctuation's line is where the paper has it."""
    return all_of((stands_out(line.size_rad_per_s2), near(line.frequency_Hz, STATED_HZ, TOLERANCE)))


def fades(lines: Lines) -> bool | None:
    """A continuous spectrum from 500 um on, lines below."""
    return _as_wanted({b: continuous(s.prominence) for b, (s, _) in lines.items()}, CONTINUOUS_UM)


def _elbow(lines: Mapping[str, Lines]) -> dict[str, bool | None]:
    return {law: elbow_larger(row) for law, row in lines.items()}


def elbow_larger(lines: Lines) -> bool | None:
    """Whether at every size the elbow's line is the larger one."""
    return all_of(
        larger(elbow.size_rad_per_s2, shoulder.size_rad_per_s2)
        for shoulder, elbow in lines.values()
    )


def minor_below(lines: Lines, size_um: float = 5) -> bool | None:
    """No fluctuation below a size, and one from it on."""
    found = {size: stands_out(s.size_rad_per_s2) for size, (s, _) in lines.items()}
    return _as_wanted(found, size_um)


def _as_wanted(found: Mapping[float, bool | None], from_um: float) -> bool | None:
    """No below a size, yes from it on."""
    return all_of(None if yes is None else yes == (size >= from_um) for size, yes in found.items())


def _keyed(symbol: str, row: Lines) -> dict[str, dict[str, dict[str, float]]]:
    return {
        f"{symbol} {size:g} um": {"shoulder": shoulder._asdict(), "elbow": elbow._asdict()}
        for size, (shoulder, elbow) in row.items()
    }


HOW_READ = (
    f"Window {SPECTRUM_S[0]:g} to {SPECTRUM_S[1]:g} s, mean removed (so nothing stands at 0 Hz),"
    f" Hann; largest line above 100 Hz. A line of {LINE:g} rad/s² counts as a fluctuation."
)


def _table(symbol: str, lines: Mapping[str, Lines]) -> str:
    rows = [
        (law, size, *shoulder, *elbow)
        for law, row in lines.items()
        for size, (shoulder, elbow) in row.items()
    ]
    columns = ("line [Hz]", "size [rad/s²]", "over the median")
    joints = [f"{j}, {u}" for j in ("shoulder", "elbow") for u in columns]
    return table(("phase law", f"{symbol} [µm]", *joints), rows)


def _spectra_svg(sweep: Sweep, symbol: str) -> str:
    figure, grid = new_figure(2, len(sweep), 2.4)
    for column, (law, row) in enumerate(sweep.items()):
        grid[0, column].set_title(LAWS[law])
        grid[-1, column].set_xlabel("frequency [Hz]")
        for joint, axes in enumerate(grid[:, column]):
            for (size, run), colour in zip(row.items(), COLOURS, strict=False):
                label = f"{symbol} {size:g} µm"
                axes.plot(*_drawn(run, joint), color=colour, label=label, linewidth=0.8)
            axes.set(xlim=(0, HIGHEST_HZ), ylabel=f"{('shoulder', 'elbow')[joint]} [rad/s²]")
            log_y(axes)
    same_scale(grid)
    for axes in grid.flat:
        axes.set_ylim(bottom=max(FAINTEST, axes.get_ylim()[0]))
    legend(figure, grid[0, 0])
    return to_svg(figure)


def _drawn(run: xr.Dataset, joint: int) -> tuple[np.ndarray, np.ndarray]:
    """Frequency [Hz] and largest amplitude of every bin of a drawing."""
    frequency, amplitudes = signals.spectrum(*spectrum_part(run, joint))
    kept = frequency <= HIGHEST_HZ
    if not kept.any():
        return np.empty(0), np.empty(0)
    centres, _, high = envelope(frequency[kept], amplitudes[kept], DRAWN)
    return centres, high

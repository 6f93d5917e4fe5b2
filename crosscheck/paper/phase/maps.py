"""Evidence 2: the third fluctuation over damping, tooth error, backlash, readings and laws."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm

from crosscheck.paper.fluctuation import THIRD_FLUCTUATION
from crosscheck.paper.numbers import defined
from crosscheck.paper.phase import fluctuations
from crosscheck.paper.phase.cells import (
    LABELLED,
    SWAPPED,
    Amplitudes,
    Cell,
    CellRecord,
    median_of,
    part_of,
)
from crosscheck.paper.phase.experiments import Setting
from crosscheck.paper.phase.fluctuations import Fluctuation
from crosscheck.paper.phase.verdict import (
    NEAR,
    PRESENT_RAD_PER_S2,
    Evidence,
    Presence,
    error_part,
    is_near,
    where_present,
)
from crosscheck.paper.scale import Scale
from crosscheck.paper.undefined import UNDEFINED, extreme, known, shown
from crosscheck.report.figures import new_figure, to_svg
from crosscheck.report.fragments import figure, heading, paragraph, table
from crosscheck.studies.study import Study

LAWS = (
    ("omega_t", "eq13"),
    ("omega_t", "corrected"),
    ("angle", "eq13"),
    ("angle", "corrected"),
)
ZETAS = (0.003, 0.005, 0.007, 0.01, 0.02, 0.05)
ERRORS_UM = (0.0, 1.6, 5.0, 6.3)  # of Fig. 19, and none
BACKLASH_ZETAS = (0.005, 0.02)
BACKLASHES_UM = (5.0, 25.0, 50.0, 500.0)  # of Figs. 16-17
SWAPPED_ZETAS = (0.003, 0.005, 0.02)
DECISIVE = (Setting(0.005, "eq13"), Setting(0.007, "eq13"), Setting(0.02, "corrected"))
SEEDS = 8
QUICK_SETTINGS = (Setting(0.005, "eq13"),)


class Maps(NamedTuple):
    """The evidence, under which law the tooth error's part is present, and how large it is.

    parts: [rad/s^2] of every cell by law; infinite where the run with the error diverged, nan where
    it is undefined.
    """

    evidence: Evidence
    present: Presence
    parts: dict[str, list[float]]


def maps(study: Study, scale: Scale) -> Maps:
    """Four runs if quick."""
    cells = _quick_cells() if scale.quick else _all_cells()
    found = measured(study, cells, scale)
    if not scale.quick:
        found |= _again(study, found, scale)
    both = [cell for cell in found if cell.error_um > 0 and cell.without_error in found]
    parts = {cell: part_of(cell, found) for cell in both}
    records = [_record(cell, found, part) for cell, part in parts.items()]
    by_law = {
        law: [part for cell, part in parts.items() if cell.law == law]
        for law in ("omega_t", "angle")
    }
    verdict = where_present(by_law)
    text = [heading("2. Simulation over damping, tooth error, backlash and both readings")]
    text.append(paragraph(_statement(by_law, found, verdict)))
    if scale.quick:
        text.append(table(_HEAD, [_row(r) for r in records]))
    else:
        text += [_error_map(found), _backlash_map(found), *_tables(records)]
    supports = None if verdict == Presence.UNKNOWN else verdict == Presence.PRINTED
    return Maps(Evidence("\n".join(text), records, supports), verdict, by_law)


def _quick_cells() -> list[Cell]:
    return [
        cell
        for zeta, ring in QUICK_SETTINGS
        for law in ("omega_t", "angle")
        for cell in _with_and_without(Cell(law, ring, zeta))
    ]


def _all_cells() -> list[Cell]:
    over_error = [Cell(*law, z, e) for law in LAWS for z in ZETAS for e in ERRORS_UM]
    over_backlash = [
        cell
        for law in LAWS
        for z in BACKLASH_ZETAS
        for b in BACKLASHES_UM
        for cell in _with_and_without(Cell(*law, z, backlash_um=b))
    ]
    swapped = [
        cell
        for law in LAWS
        for z in SWAPPED_ZETAS
        for cell in _with_and_without(Cell(*law, z, arm=SWAPPED))
    ]
    seeded = [
        cell
        for zeta, ring in DECISIVE
        for law in ("omega_t", "angle")
        for cell in _with_and_without(Cell(law, ring, zeta, seeds=SEEDS))
    ]
    return list(dict.fromkeys([*over_error, *over_backlash, *swapped, *seeded]))


def _with_and_without(cell: Cell) -> tuple[Cell, Cell]:
    return cell, cell.without_error


def measured(study: Study, cells: Sequence[Cell], scale: Scale) -> Amplitudes:
    """The third fluctuation of every cell's runs, see ``amplitude``."""
    variants = [scale.cut(variant) for cell in cells for variant in cell.variants()]
    runs = iter(fluctuations.measured(study, variants, THIRD_FLUCTUATION, "phase: maps"))
    return {cell: [amplitude(next(runs)) for _ in cell.variants()] for cell in cells}


def amplitude(found: Fluctuation) -> float:
    """The amplitude [rad/s^2] that was found.

    Infinite if the run diverged, nan if it ends before.
    """
    if found.diverged_s is not None:
        return math.inf
    value = found.amplitude_rad_per_s2
    return math.nan if value is None else value


def _again(study: Study, found: Amplitudes, scale: Scale) -> Amplitudes:
    """Cells of one start whose part lies near the threshold, from several starts."""
    near = [
        cell
        for cell, (first, *others) in found.items()
        if cell.error_um > 0
        and not others
        and is_near(error_part(first, found[cell.without_error][0]))
    ]
    seeded = measured(study, [replace(cell, seeds=SEEDS) for cell in near], scale)
    return {replace(cell, seeds=0): runs for cell, runs in seeded.items()}


def _record(cell: Cell, found: Amplitudes, part: float) -> CellRecord:
    with_error, without = found[cell], found[cell.without_error]
    return CellRecord(
        cell=cell,
        starts=len(with_error),
        median=defined(np.median(with_error)),
        smallest=defined(min(with_error)),
        largest=defined(max(with_error)),
        median_without_error=defined(np.median(without)),
        error_part=defined(part),
        present=None if math.isnan(part) else part >= PRESENT_RAD_PER_S2,
        diverged=math.inf in (*with_error, *without),
    )


_HEAD = (
    "reading",
    "law",
    "ring rate",
    "zeta",
    "E [µm]",
    "b [µm]",
    "starts",
    "amplitude: median (range) [rad/s²]",
    "the same with E = 0 [rad/s²]",
    "part of the tooth error [rad/s²]",
)


def _row(record: CellRecord) -> tuple[str, ...]:
    cell, missing = record.cell, "diverged" if record.diverged else UNDEFINED
    numbers = (
        record.median,
        record.smallest,
        record.largest,
        record.median_without_error,
        record.error_part,
    )
    median, low, high, without, part = (shown(value, ".1f", missing) for value in numbers)
    spread = f" ({low} to {high})" if record.starts > 1 else ""
    return (
        cell.reading,
        cell.law,
        cell.ring,
        f"{cell.zeta:g}",
        f"{cell.error_um:g}",
        f"{cell.backlash_um:g}",
        str(record.starts),
        median + spread,
        without,
        part,
    )


def _tables(records: Sequence[CellRecord]) -> list[str]:
    seeded = [_row(r) for r in records if r.starts > 1]
    swapped = [_row(r) for r in records if r.cell.arm != LABELLED]
    return [
        table(
            _HEAD,
            seeded,
            f"Decisive settings, and those within a factor of {NEAR:g} of the threshold: {SEEDS}"
            " starts perturbed by up to 1e-12 m",
        ),
        table(_HEAD, swapped, "The other reading of Table I"),
    ]


def _statement(by_law: dict[str, list[float]], found: Amplitudes, verdict: Presence) -> str:
    without = {
        law: [
            run
            for cell, runs in found.items()
            if cell.law == law and not cell.error_um
            for run in runs
        ]
        for law in by_law
    }
    present = {law: _present(parts) for law, parts in by_law.items()}
    return (
        "Question: where in the space of what the paper does not tell does the tooth error excite"
        " a third fluctuation? Amplitude: largest detailed minus rigid shoulder acceleration"
        f" in 0.5 to 1.2 s; its tooth error's part: less the same with E = 0; present from"
        f" {PRESENT_RAD_PER_S2:g} rad/s² on, a tenth of the paper's 300."
        f" In {len(by_law['omega_t'])} settings under omega_t it is present in"
        f" {present['omega_t']}, up to {_largest(by_law['omega_t'])} rad/s²; in"
        f" {len(by_law['angle'])} settings under angle in {present['angle']}, at most"
        f" {_largest(by_law['angle'], '.1f')} rad/s². What remains with E = 0 is there under both"
        f" laws: up to {_largest(without['angle'])} rad/s² under angle, the impacts kept alive by"
        f" the controller (H6), and {_largest(without['omega_t'])} under omega_t, whose false phase"
        " also enters the stiffness. Values far above 1000 rad/s² are a regime of its own, teeth"
        " hammering on both sides, which the controller can sustain by itself once kicked"
        " (section 5)."
        " The planets of a stage move as one here, as in the paper; section 3 and H7 free them."
        f" Maps: one start, or the median of {SEEDS} where the first lies within a factor of"
        f" {NEAR:g} of the threshold; the table below states the scatter."
        f" Verdict on where the tooth error's part is present: {verdict}."
    )


def _present(parts: Sequence[float]) -> str:
    """In how many settings; and in how many it is undefined, if in any."""
    undefined = sum(map(math.isnan, parts))
    count = str(sum(part >= PRESENT_RAD_PER_S2 for part in parts))
    return f"{count} ({undefined} undefined)" if undefined else count


def _largest(values: Sequence[float], form: str = ".0f") -> str:
    return "diverging" if math.inf in values else shown(extreme(values, max), form)


def _error_map(found: Amplitudes) -> str:
    drawing, grid = new_figure(1, len(LAWS), 3.0)
    for axes, (law, ring) in zip(grid[0], LAWS, strict=True):
        values = [[median_of(found[Cell(law, ring, z, e)]) for z in ZETAS] for e in ERRORS_UM]
        _heat(axes, np.array(values), ZETAS, ERRORS_UM)
        axes.set(title=f"{law}, {ring}", xlabel="zeta")
    grid[0, 0].set_ylabel("E [µm]")
    caption = (
        "Amplitude of the third fluctuation [rad/s²] over damping and tooth error; labelled"
        " reading, b = 50 µm. Bottom row, E = 0: the controller's flutter alone."
    )
    return figure(to_svg(drawing), caption)


def _backlash_map(found: Amplitudes) -> str:
    drawing, grid = new_figure(1, len(LAWS), 2.8)
    for axes, (law, ring) in zip(grid[0], LAWS, strict=True):
        cells = [[Cell(law, ring, z, backlash_um=b) for z in BACKLASH_ZETAS] for b in BACKLASHES_UM]
        parts = [[part_of(cell, found) for cell in row] for row in cells]
        _heat(axes, np.array(parts), BACKLASH_ZETAS, BACKLASHES_UM)
        axes.set(title=f"{law}, {ring}", xlabel="zeta")
    grid[0, 0].set_ylabel("b [µm]")
    caption = (
        "The tooth error's part of the third fluctuation [rad/s²], E = 5 µm less E = 0, over"
        " damping and backlash; labelled reading."
    )
    return figure(to_svg(drawing), caption)


def _in_cell(value: float) -> str:
    """Short enough for a cell: thousands as k."""
    if known(value):
        return f"{value:.0f}" if value < 1e4 else f"{value / 1e3:.0f}k"
    return "div." if value == math.inf else "-"


def _heat(axes: Axes, values: np.ndarray, columns: Sequence[float], rows: Sequence[float]) -> None:
    """Numbers on colours; every map has the same scale, 1 to 1000 rad/s^2."""
    axes.imshow(
        np.clip(values, 1, 1000),
        origin="lower",
        aspect="auto",
        cmap="YlOrRd",
        norm=LogNorm(1, 1000),
    )
    for (row, column), value in np.ndenumerate(values):
        shade = "white" if value > 200 else "black"
        axes.text(column, row, _in_cell(value), ha="center", va="center", fontsize=6.5, color=shade)
    axes.set_xticks(range(len(columns)), [f"{c:g}" for c in columns], fontsize=6.5)
    axes.set_yticks(range(len(rows)), [f"{r:g}" for r in rows], fontsize=7)
    axes.grid(visible=False)

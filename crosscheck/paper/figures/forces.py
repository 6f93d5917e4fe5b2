"""Figures 16, 17 and 19: mesh force over backlash and over tooth error."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

import xarray as xr

from crosscheck import signals
from crosscheck.paper.events import THIRD_S
from crosscheck.paper.figures.measures import Impact, energy_peak, force_swing, impact, third_force
from crosscheck.paper.figures.plate import (
    Plate,
    Shelf,
    band,
    conditions,
    same_scale,
    table,
)
from crosscheck.paper.figures.runs import (
    BACKLASHES_UM,
    ERRORS_UM,
    LAWS,
    QUICK_BACKLASHES_UM,
    backlash_run,
    error_run,
)
from crosscheck.paper.figures.verdicts import (
    FORCE_N,
    appears_at,
    by_law,
    falls,
    fluctuation_falls,
    fluctuation_rises,
    rises,
)
from crosscheck.paper.reading import arm_of, first_mesh
from crosscheck.paper.stage import paper_stage
from crosscheck.paper.undefined import UNDEFINED, known
from crosscheck.report.figures import new_figure, not_reached, to_svg
from crosscheck.report.fragments import COLOURS

Sweep = Mapping[str, Mapping[float, xr.Dataset]]
IMPACT_WINDOW_S = (0.34, 0.46)
KILO = 1e-3
SMALL_BINS = 350
HALF_STEP = "scenario.step_s=5e-6"
HALVED_UM = (5.0, 50.0)


def figure_16(shelf: Shelf) -> Plate:
    """F_sp1 over b at the side change."""
    sweep = shelf.sweep(16, BACKLASHES_UM, backlash_run)
    measured = {
        law: {b: impact(run["time"].values, first_mesh(run, "F_sp")) for b, run in row.items()}
        for law, row in sweep.items()
    }
    rows = [(law, b, *m) for law, row in measured.items() for b, m in row.items()]
    head = ("phase law", "b [µm]", "contact at [s]", "peak [N]", "bouncing [s]")
    return Plate(
        16,
        "shoulder mesh force at the side change, for several backlashes",
        small_multiples(sweep, "b", IMPACT_WINDOW_S),
        "A larger backlash makes the impact more severe, and it comes later and lasts shorter.",
        "The first contact at the other side after 0.2 s, its largest force, and how long the teeth"
        " keep parting in the 0.1 s after it. A contact near 0.2 s is no side change but vibration"
        " that already throws the teeth across a small clearance.",
        conditions(sweep["angle"][50], "b as at the panels."),
        {
            "the impact grows with b": _trend(measured, rises, lambda m: m.peak_N),
            "it comes later": _trend(measured, rises, lambda m: m.contact_s),
            "it lasts shorter": _trend(measured, falls, lambda m: m.bouncing_s),
        },
        {
            "laws": {
                law: _keyed("b", {b: m._asdict() for b, m in row.items()})
                for law, row in measured.items()
            }
        },
        table(head, rows),
    )


def _trend(
    measured: Mapping[str, Mapping[float, Impact]],
    follows: Callable[[list[float], list[float | None]], bool | None],
    number: Callable[[Impact], float | None],
) -> str:
    return by_law(
        {
            law: follows(list(row), [number(m) for m in row.values()])
            for law, row in measured.items()
        }
    )


def figure_17(shelf: Shelf) -> Plate:
    """F_sp1 over b in the third fluctuation."""
    sizes = QUICK_BACKLASHES_UM if shelf.scale.quick else BACKLASHES_UM
    sweep = shelf.sweep(17, sizes, backlash_run)
    forces, swings = _third(shelf, sweep, "b")
    return Plate(
        17,
        "shoulder mesh force in the third fluctuation, for several backlashes",
        small_multiples(sweep, "b", THIRD_S),
        "The fluctuation recedes as the backlash grows; a small backlash keeps the teeth hitting"
        " both sides of it.",
        HOW_READ,
        conditions(sweep["angle"][50], "b as at the panels, each with its own scale."),
        {
            "a fluctuation that recedes as b grows": by_law(
                {
                    law: fluctuation_falls(list(row), list(row.values()))
                    for law, row in forces.items()
                }
            )
        },
        {"laws": {law: _keyed("b", row) for law, row in forces.items()}},
        swings,
    )


def figure_19(shelf: Shelf) -> Plate:
    """F_sp1 over E in the third fluctuation."""
    sweep = shelf.sweep(19, ERRORS_UM, error_run)
    forces, swings = _third(shelf, sweep, "E")
    starts = {law: appears_at(list(row), list(row.values())) for law, row in forces.items()}
    first = {law: _first(at, forces[law]) for law, at in starts.items()}
    return Plate(
        19,
        "shoulder mesh force in the third fluctuation, for several tooth errors",
        small_multiples(sweep, "E", THIRD_S),
        "Below 1 µm nothing is excited, at 1.6 µm a minor fluctuation appears, and the force"
        " evidently grows with the error.",
        f"{HOW_READ} The smallest error at which the force swings by more than {FORCE_N:.0f} N"
        f" (what moves the shoulder by 100 rad/s²): {first['omega_t']} under omega_t,"
        f" {first['angle']} under angle.",
        conditions(sweep["angle"][5], "E as at the panels, each with its own scale."),
        {
            "a fluctuation that grows with E": by_law(
                {
                    law: fluctuation_rises(list(row), list(row.values()))
                    for law, row in forces.items()
                }
            )
        },
        {
            "laws": {law: _keyed("E", row) for law, row in forces.items()},
            "appears_at_um": starts,
        },
        swings,
    )


def _first(at_um: float | None, forces: Mapping[float, float]) -> str:
    if not known(*forces.values()):
        return UNDEFINED
    return "none" if at_um is None else f"{at_um:g} µm"


HOW_READ = (
    "± is half of the largest peak-to-peak value within 5 ms, in 0.5 to 1.2 s. Where the kinetic"
    " energy exceeds the drive's work, the meshes themselves feed energy in. The half step tells"
    " whether the integration resolves the swing or only its size."
)


def _third(shelf: Shelf, sweep: Sweep, symbol: str) -> tuple[dict[str, dict[float, float]], str]:
    """Swing of F_sp1 [N] by law and size, and the table of it."""
    forces = {law: {s: force_swing(run) for s, run in row.items()} for law, row in sweep.items()}
    halved = {} if shelf.scale.quick or symbol != "b" else _halved(shelf)
    peaks = {
        law: {size: energy_peak(run, _carrier_radii(run)) for size, run in row.items()}
        for law, row in sweep.items()
    }
    rows = [
        (law, size, forces[law][size], *peaks[law][size], halved.get((law, size)))
        for law in LAWS
        for size in sweep[law]
    ]
    head = (
        "phase law",
        f"{symbol} [µm]",
        "± F_sp1 [N]",
        "peak kinetic energy [J]",
        "drive's work till then [J]",
        "± F_sp1 at half the step [N]",
    )
    return forces, table(head, rows)


def _carrier_radii(run: xr.Dataset) -> tuple[float, ...]:
    arm = arm_of(run)
    return tuple(paper_stage(arm, place).geometry.r_cp for place in range(len(arm.joints)))


def _halved(shelf: Shelf) -> dict[tuple[str, float], float | None]:
    """(law, b) -> the swing at half the step, recorded at the same times."""
    finer = []
    for size in HALVED_UM:
        run = backlash_run("omega_t", size)
        settings = (*run.settings, HALF_STEP)
        finer.append(replace(run, settings=settings, record_every=2 * run.record_every))
    numbers = shelf.study.measures(
        [shelf.scale.cut(run) for run in finer], third_force, "half the step"
    )
    swings = (n.get("force_swing_N") for n in numbers)
    return {("omega_t", size): swing for size, swing in zip(HALVED_UM, swings, strict=True)}


def _keyed(symbol: str, row: Mapping[float, object]) -> dict[str, object]:
    return {f"{symbol} {size:g} um": value for size, value in row.items()}


def small_multiples(sweep: Sweep, symbol: str, window: tuple[float, float]) -> str:
    """F_sp1 [kN] in a window [s]: a row per size, the phase laws side by side."""
    sizes = list(sweep["angle"])
    figure, grid = new_figure(len(sizes), len(sweep), 1.15)
    for column, (law, row) in enumerate(sweep.items()):
        grid[0, column].set_title(LAWS[law])
        grid[-1, column].set_xlabel("time [s]")
        for axes, (size, run) in zip(grid[:, column], row.items(), strict=True):
            part = signals.window(run["time"].values, *window)
            time, force = run["time"].values[part], first_mesh(run, "F_sp")[part]
            band(axes, time, KILO * force, law, COLOURS[column], SMALL_BINS)
            if not time.size:
                not_reached(axes)
            axes.set(xlim=window, ylabel=f"{symbol} {size:g} µm\nF_sp1 [kN]")
            axes.tick_params(labelbottom=axes is grid[-1, column])
    same_scale(grid)
    return to_svg(figure)

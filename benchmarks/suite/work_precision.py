"""Part 3: wall time against the largest error over the whole trajectory.

PD control of the paper's arm for 3 s, 30,001 records. The error is the largest over all records, of
the angles over the largest angle or of the displacements over the play, whichever is larger.
Compiling is not counted, of no solver.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial
from typing import NamedTuple

import numpy as np

from analytic.model import PhysicalModel
from benchmarks.suite import solver_exudyn, solver_heyoka, solver_own, solvers_general
from benchmarks.suite.cases import pd_run
from benchmarks.suite.refined import refined
from benchmarks.suite.rows import Row, absent
from benchmarks.suite.single import largest_difference
from benchmarks.suite.solver import Solver
from benchmarks.suite.timing import Times, seconds_of
from models.errors import Diverged
from models.trajectory import recorded_times

TABLE = "work-precision"
# By damping ratio: the steps [s] of the refined solution, and of the one that shows how good it is.
REFINED = {0.05: (5e-6, 1e-5), 0.01: (1.25e-6, 2.5e-6)}
ACCURACIES = tuple(10.0**-decade for decade in range(3, 10))
TARGET = 0.1
SLOW_S = 5.0  # a run that takes longer is measured once, with what little it compiles
TIME, ERROR = "wall time", "largest error"


class Tried(NamedTuple):
    """A solver at one of its settings: its times, of one trajectory, and its largest error."""

    solver: str
    setting: str
    times: Times
    error: float
    own: bool


class Entry(NamedTuple):
    """How a solver is made, at which settings it runs, and whether it is this project's."""

    make: Callable[[PhysicalModel, np.ndarray], Solver]
    settings: tuple[float, ...]
    own: bool = False


TOLERANCES = (1e-6, 1e-8, 1e-10, 1e-12)
FINE = (1e-10, 1e-11, 1e-12, 1e-13, 1e-15)
STEPS = (2e-5, 1e-5, 5e-6, 2e-6, 1e-6, 5e-7)
ENTRIES: dict[str, Entry] = {
    "RK4": Entry(solver_own.runge_kutta, STEPS, own=True),
    "DOP853": Entry(partial(solvers_general.scipy_solver, method="DOP853"), TOLERANCES),
    "LSODA": Entry(solvers_general.lsoda, (*TOLERANCES, 1e-13)),
    "Radau": Entry(partial(solvers_general.scipy_solver, method="Radau"), TOLERANCES[:2]),
    "CVODE Adams": Entry(partial(solvers_general.cvode, method="Adams"), (*TOLERANCES, 1e-13)),
    "CVODE BDF": Entry(partial(solvers_general.cvode, method="BDF"), (*TOLERANCES, 1e-13)),
    "heyoka, select": Entry(solver_heyoka.by_select, STEPS[:5]),
    "heyoka, batch": Entry(solver_heyoka.by_batches, STEPS[:5]),
    "heyoka, events": Entry(solver_heyoka.by_contact_events, FINE),
    "Exudyn RK44": Entry(partial(solver_exudyn.tree, made=solver_exudyn.RungeKutta), (1e-5,)),
    "Exudyn DOPRI5": Entry(partial(solver_exudyn.tree, made=solver_exudyn.DormandPrince), (1e-5,)),
    "Exudyn alpha": Entry(
        partial(solver_exudyn.tree, made=solver_exudyn.GeneralizedAlpha), (2e-5,)
    ),
}


def measure(repeats: int) -> list[Row]:
    """Both damping ratios; with one repeat every solver at its middle setting alone."""
    return [row for ratio in REFINED for row in _case(ratio, repeats)]


def _case(ratio: float, repeats: int) -> list[Row]:
    case, model = f"zeta {ratio}", pd_run(ratio)
    grid = recorded_times(model.scenario)
    fine, coarse = (refined(model, grid, step) for step in REFINED[ratio])
    doubt = largest_difference(model, coarse.q, fine.q)
    rows = [
        Row(TABLE, case, "contact changes in 3 s", fine.changes, ""),
        Row(TABLE, case, "refined solution against the one of twice its step", doubt, "of size"),
    ]
    tried: list[Tried] = []
    for name, entry in ENTRIES.items():
        settings = entry.settings if repeats > 1 else _middle(entry.settings)
        try:
            solver = entry.make(model, grid)
        except ImportError as reason:
            rows.append(absent(TABLE, f"{case}, {name}", str(reason)))
            continue
        tried += [_tried(model, solver, value, fine.q, entry.own, repeats) for value in settings]
    for each in tried:
        rows += _rows(case, each)
    return [*rows, *_by_accuracy(case, tried)]


def _middle(settings: Sequence[float]) -> Sequence[float]:
    return settings[len(settings) // 2 :][:1]


def _tried(
    model: PhysicalModel,
    solver: Solver,
    value: float,
    reference: np.ndarray,
    own: bool,
    repeats: int,
) -> Tried:
    """The first run compiles, and gives the error; a diverged one has an infinite error."""
    found: list[np.ndarray] = []

    def run() -> None:
        found[:] = [solver.run(value)]

    try:
        first = seconds_of(run)
        again = [seconds_of(run) for _ in range(repeats if first < SLOW_S else 0)]
        seconds = tuple(each / solver.trajectories for each in again or [first])
        q = found[0]
    except Diverged:
        seconds, q = (math.nan,), np.full_like(reference, np.nan)
    whole = q.shape == reference.shape and np.isfinite(q).all()
    error = largest_difference(model, q, reference) if whole else math.inf
    setting = f"{solver.setting} {value:g}"
    return Tried(solver.name, setting, Times(seconds), error, own)


def _rows(case: str, tried: Tried) -> list[Row]:
    what, times = f"{case}, {tried.solver}, {tried.setting}", tried.times
    return [
        Row(TABLE, what, TIME, times.median, "s", spread=times.spread),
        Row(TABLE, what, ERROR, tried.error, "of size"),
    ]


def _by_accuracy(case: str, tried: Sequence[Tried]) -> list[Row]:
    """The project's fastest run that is accurate enough, against the fastest of all others."""
    rows = []
    for accuracy in ACCURACIES:
        able = [each for each in tried if each.error <= accuracy]
        own = min((t for t in able if t.own), key=_median, default=None)
        other = min((t for t in able if not t.own), key=_median, default=None)
        what = f"{case}, error at most {accuracy:.0e}"
        if own is None:
            rows.append(Row(TABLE, what, "reached by no method of the project", math.inf, "s"))
            continue
        row = Row(TABLE, what, f"{own.solver}, {own.setting}", own.times.median, "s")
        if other is None:
            rows.append(row._replace(against="reached by no other"))
            continue
        ratio = own.times.median / other.times.median
        against = f"{other.solver}, {other.setting}"
        rows.append(row._replace(against=against, ratio=ratio, target=TARGET))
    return rows


def _median(tried: Tried) -> float:
    return tried.times.median


Line = tuple[list[float], list[float]]


def curves(rows: Sequence[Row]) -> dict[str, dict[str, Line]]:
    """By case and solver: errors and seconds of its settings, by falling error."""
    errors = {row.case: row.value for row in rows if row.table == TABLE and row.quantity == ERROR}
    found: dict[str, dict[str, Line]] = {}
    for row in rows:
        if row.table != TABLE or row.quantity != TIME or not errors[row.case] < 1:
            continue
        case, rest = row.case.split(", ", 1)
        solver = rest.rpartition(", ")[0]
        line = found.setdefault(case, {}).setdefault(solver, ([], []))
        line[0].append(errors[row.case])
        line[1].append(row.value)
    return found

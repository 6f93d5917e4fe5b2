"""Part 3: wall time against the largest error over the whole trajectory.

PD control of the paper's arm for 3 s, 30,001 records. The error is the largest over all records, of
the angles over the largest angle or of the displacements over the play, whichever is larger. It is
held against ``precise`` at its smallest tolerance, and that against another program's solution.
Compiling is not counted, of no solver.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, Literal, NamedTuple

import numpy as np

from benchmarks.suite import solver_exudyn, solver_heyoka, solver_project, solvers_general
from benchmarks.suite.cases import build_pd_run
from benchmarks.suite.refined_solution import solve_refined
from benchmarks.suite.rows import Row, absent_row
from benchmarks.suite.single import largest_difference
from benchmarks.suite.solver import Solver
from benchmarks.suite.solver_project import coordinates
from benchmarks.suite.timing import Times, measure_seconds, print_progress
from crosscheck.analytic.model import PhysicalModel
from crosscheck.models.errors import Diverged
from crosscheck.models.trajectory import recorded_times

TABLE = "work-precision"
AGAINST_NAMED = "fastest at an accuracy, heyoka by select"
AGAINST_ALL = "fastest at an accuracy, heyoka with contact events, too"
# By damping ratio: the steps [s] of the refined solution that the reference is held against.
REFINED = {0.05: 1e-5, 0.01: 2.5e-6}
REFERENCE_RTOL = 1e-13
MOVED_M = 1e-20  # of the start: what it does to the run, no solver in double precision can avoid
ACCURACIES = tuple(10.0**-decade for decade in range(3, 10))
TARGET = 0.1
SLOW_S = 15.0  # a run that takes longer is measured once, with what it compiles
ENOUGH_S = 1.5  # of repeats of one run: no more begin after that
TIME, ERROR = "wall time", "largest error"
Origin = Literal["own", "another's", "with our events"]


class Entry(NamedTuple):
    """How a solver is made, and at which settings it runs.

    origin: this project's, another's as it stands, or another's with contact changes formulated as
    events by us.
    """

    make: Callable[[PhysicalModel, np.ndarray], Solver]
    settings: tuple[float, ...]
    origin: Origin = "another's"


class SolverResult(NamedTuple):
    """A solver at one of its settings: its times, of one trajectory, and its largest error; and
    whether it computes several side by side."""

    solver: str
    setting: str
    times: Times
    error: float
    origin: Origin
    batch: bool


TOLERANCES = (1e-6, 1e-8, 1e-10, 1e-12)
FINE = (1e-6, 1e-8, 1e-10, 1e-12, 1e-15)
EVERY_DECADE = tuple(10.0**-decade for decade in range(3, 13))
STEPS = (2e-5, 1e-5, 5e-6, 2e-6, 1e-6)
ENTRIES: dict[str, Entry] = {
    "RK4": Entry(solver_project.make_step_solver, STEPS, "own"),
    "RK4, batch": Entry(solver_project.make_ensemble_solver, STEPS, "own"),
    "precise": Entry(solver_project.make_precise_solver, EVERY_DECADE, "own"),
    "DOP853": Entry(partial(solvers_general.make_scipy_solver, method="DOP853"), TOLERANCES[::2]),
    "LSODA": Entry(solvers_general.make_lsoda_solver, (*TOLERANCES, 1e-13)),
    "Radau": Entry(partial(solvers_general.make_scipy_solver, method="Radau"), TOLERANCES[:1]),
    "CVODE Adams": Entry(
        partial(solvers_general.make_cvode_solver, method="Adams"), (*TOLERANCES, 1e-13)
    ),
    "CVODE BDF": Entry(
        partial(solvers_general.make_cvode_solver, method="BDF"), (*TOLERANCES, 1e-13)
    ),
    "heyoka, select": Entry(solver_heyoka.make_select_solver, STEPS),
    "heyoka, batch": Entry(solver_heyoka.make_batch_solver, STEPS),
    "heyoka, events": Entry(solver_heyoka.make_event_solver, FINE, "with our events"),
    "Exudyn RK44": Entry(partial(solver_exudyn.make_tree_solver, method="RK44"), (2e-5,)),
    "Exudyn DOPRI5": Entry(partial(solver_exudyn.make_tree_solver, method="DOPRI5"), (2e-5,)),
    "Exudyn alpha": Entry(
        partial(solver_exudyn.make_tree_solver, method="generalized-alpha"), (2e-5,)
    ),
}


def measure(repeats: int) -> list[Row]:
    """Both damping ratios; with one repeat the first, and every solver at its middle setting."""
    ratios = tuple(REFINED) if repeats > 1 else tuple(REFINED)[:1]
    return [row for ratio in ratios for row in _case(ratio, repeats)]


def _case(ratio: float, repeats: int) -> list[Row]:
    case, model = f"zeta {ratio}", build_pd_run(ratio)
    grid = recorded_times(model.scenario)
    reference = coordinates(model, model.precise(REFERENCE_RTOL))
    rows, floor = _grounds(case, model, reference, ratio)
    results: list[SolverResult] = []
    for name, entry in ENTRIES.items():
        settings = entry.settings if repeats > 1 else _middle(entry.settings)
        try:
            solver = entry.make(model, grid)
        except ImportError as reason:
            rows.append(absent_row(TABLE, f"{case}, {name}", str(reason)))
            continue
        for value in settings:
            results.append(_run_solver(model, solver, value, reference, entry.origin, repeats))
            print_progress(_describe_result(case, results[-1]))
    for each in results:
        rows += _rows(case, each)
    named = [each for each in results if each.origin != "with our events"]
    rows += _accuracy_rows(AGAINST_NAMED, case, named, floor)
    return [*rows, *_accuracy_rows(AGAINST_ALL, case, results, floor)]


def _grounds(
    case: str, model: PhysicalModel, reference: np.ndarray, ratio: float
) -> tuple[list[Row], float]:
    """How good the reference is, and how well any run is determined: the second is returned."""
    grid, step = recorded_times(model.scenario), REFINED[ratio]
    other = solve_refined(model, grid, step)
    ten = coordinates(model, model.precise(10 * REFERENCE_RTOL))
    moved = build_pd_run(ratio, start_moved_m=MOVED_M)
    floor = largest_difference(model, coordinates(moved, moved.precise(REFERENCE_RTOL)), reference)
    name = f"precise() at {REFERENCE_RTOL:g}"
    differences = {
        f"{name} against order 8 by another program, step {step:g} s": other.q,
        f"{name} against {10 * REFERENCE_RTOL:g}": ten,
    }
    rows = [Row(TABLE, case, "contact changes in 3 s", other.changes, "")]
    rows += [
        Row(TABLE, case, what, largest_difference(model, q, reference), "of size")
        for what, q in differences.items()
    ]
    rows.append(Row(TABLE, case, f"what a start moved by {MOVED_M:g} m does", floor, "of size"))
    return rows, floor


def _describe_result(case: str, result: SolverResult) -> str:
    what = f"{case}, {result.solver}, {result.setting}"
    return f"{what}: {result.times.median:.3g} s, {result.error:.1e}"


def _middle(settings: Sequence[float]) -> Sequence[float]:
    return settings[len(settings) // 2 :][:1]


def _run_solver(
    model: PhysicalModel,
    solver: Solver,
    value: float,
    reference: np.ndarray,
    origin: Origin,
    repeats: int,
) -> SolverResult:
    """The first run compiles, and gives the error; a diverged one has an infinite error."""
    solutions: list[np.ndarray] = []

    def run() -> None:
        solutions[:] = [solver.run(value)]

    try:
        first = measure_seconds(run)
        again = list[float]()
        while first < SLOW_S and len(again) < repeats and sum(again) < ENOUGH_S:
            again.append(measure_seconds(run))
        seconds = tuple(each / solver.trajectories for each in again or [first])
        q = solutions[0]
    except Diverged:
        seconds, q = (math.nan,), np.full_like(reference, np.nan)
    whole = q.shape == reference.shape and np.isfinite(q).all()
    error = largest_difference(model, q, reference) if whole else math.inf
    setting = f"{solver.setting} {value:g}"
    return SolverResult(
        solver.name, setting, Times(seconds), error, origin, solver.trajectories > 1
    )


def _rows(case: str, result: SolverResult) -> list[Row]:
    what, times = f"{case}, {result.solver}, {result.setting}", result.times
    return [
        Row(TABLE, what, TIME, times.median, "s", spread=times.spread),
        Row(TABLE, what, ERROR, result.error, "of size"),
    ]


def _accuracy_rows(
    table: str, case: str, results: Sequence[SolverResult], floor: float
) -> list[Row]:
    """The project's fastest run that is accurate enough, against the fastest of all others: one
    trajectory against one, and many side by side against many."""
    rows = []
    for accuracy in ACCURACIES:
        what = f"{case}, error at most {accuracy:.0e}"
        if accuracy < floor:
            rows.append(absent_row(table, what, f"a start moved by {MOVED_M:g} m does {floor:.0e}"))
            continue
        able = [each for each in results if each.error <= accuracy]
        rows.append(_fastest_row(table, what, [each for each in able if not each.batch]))
        batches = [each for each in able if each.batch]
        if batches:
            rows.append(_fastest_row(table, f"{what}, by trajectory of a batch", batches))
    return rows


def _fastest_row(table: str, what: str, able: Sequence[SolverResult]) -> Row:
    project_result = min((t for t in able if t.origin == "own"), key=_median_s, default=None)
    other = min((t for t in able if t.origin != "own"), key=_median_s, default=None)
    if project_result is None:
        return Row(table, what, "reached by no method of the project", math.inf, "s")
    row = Row(
        table,
        what,
        f"{project_result.solver}, {project_result.setting}",
        project_result.times.median,
        "s",
    )
    return row._replace(**_ratio_fields(project_result, other))


def _ratio_fields(project_result: SolverResult, other: SolverResult | None) -> dict[str, Any]:
    if other is None:
        return {"against": "reached by no other"}
    ratio = project_result.times.median / other.times.median
    return {"against": f"{other.solver}, {other.setting}", "ratio": ratio, "target": TARGET}


def _median_s(result: SolverResult) -> float:
    return result.times.median


Line = tuple[list[float], list[float]]


def collect_curves(rows: Sequence[Row]) -> dict[str, dict[str, Line]]:
    """By case and solver: errors and seconds of its settings, by falling error."""
    errors = {row.case: row.value for row in rows if row.table == TABLE and row.quantity == ERROR}
    curves_by_case: dict[str, dict[str, Line]] = {}
    for row in rows:
        if row.table != TABLE or row.quantity != TIME or not errors[row.case] < 1:
            continue
        case, rest = row.case.split(", ", 1)
        solver = rest.rpartition(", ")[0]
        line = curves_by_case.setdefault(case, {}).setdefault(solver, ([], []))
        line[0].append(errors[row.case])
        line[1].append(row.value)
    return curves_by_case

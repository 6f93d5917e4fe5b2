"""General solvers with the compiled right-hand side: SciPy's, and SUNDIALS' CVODE."""

from __future__ import annotations

import numpy as np
from scipy.integrate import odeint, solve_ivp

from benchmarks.suite.right_side import compile_in_place, compile_right_side, sizes
from benchmarks.suite.solver import Solver
from crosscheck.analytic.model import AnalyticModel

MOST_STEPS = 10_000_000  # between two records: the tolerance decides, no count of steps


def make_scipy_solver(model: AnalyticModel, grid: np.ndarray, method: str) -> Solver:
    """DOP853 or Radau of solve_ivp, at a relative tolerance."""
    right_side, start, size = compile_right_side(model), np.concatenate(model.start()), sizes(model)

    def run(tolerance: float) -> np.ndarray:
        span = grid[0], grid[-1]
        solution = solve_ivp(
            right_side, span, start, method, grid, rtol=tolerance, atol=tolerance * size
        )
        return solution.y.T[:, : start.size // 2]

    return Solver(f"SciPy {method}", "rtol", run)


def make_lsoda_solver(model: AnalyticModel, grid: np.ndarray) -> Solver:
    """LSODA by odeint, whose loop over the records is compiled (that of solve_ivp is not)."""
    right_side, start, size = compile_right_side(model), np.concatenate(model.start()), sizes(model)

    def run(tolerance: float) -> np.ndarray:
        options = {"rtol": tolerance, "atol": tolerance * size, "mxstep": MOST_STEPS}
        return odeint(right_side, start, grid, tfirst=True, **options)[:, : start.size // 2]

    return Solver("SciPy LSODA", "rtol", run)


def make_cvode_solver(model: AnalyticModel, grid: np.ndarray, method: str) -> Solver:
    """CVODE of scikit-sundae, Adams or BDF. Raises ImportError."""
    from sksundae.cvode import CVODE

    in_place, start, size = compile_in_place(model), np.concatenate(model.start()), sizes(model)

    def run(tolerance: float) -> np.ndarray:
        engine = CVODE(
            in_place,
            method=method,
            rtol=tolerance,
            atol=tolerance * size,
            max_num_steps=MOST_STEPS,
        )
        return engine.solve(grid, start).y[:, : start.size // 2]

    return Solver(f"CVODE {method}", "rtol", run)

"""A refined solution with SciPy's adaptive DOP853, to measure the fixed step against."""

from __future__ import annotations

import numpy as np

from crosscheck.analytic.derivation.gears import Gears
from crosscheck.analytic.kernel.states import StateEvaluator

# Sizes below which an error does not matter at relative tolerance 1: displacements of the order of
# the play and their rates at the mesh modes, against angles of the order of a radian.
MESH_SIZE_M, MESH_RATE_M_PER_S = 1e-4, 1e-1


def solve(
    states: StateEvaluator,
    gears: Gears,
    start: tuple[np.ndarray, np.ndarray],
    time: np.ndarray,
    rtol: float,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(q, v, work) at `time` (times,) [s], from `start` at time[0].

    q, v (times, n); work (times, 2) [J]: done by all forces since the start, and turned over (the
    integral of its rate's magnitude). Rows that the integrator did not reach are NaN.
    """
    from scipy.integrate import solve_ivp  # a third of a second, for references alone

    n = start[0].size

    def right_side(t: float, state: np.ndarray) -> np.ndarray:
        v = state[n : 2 * n]
        quantities = states.evaluate(t, state[:n], v)
        power = quantities.force @ v, np.abs(quantities.force) @ np.abs(v)
        return np.concatenate((v, quantities.acceleration, power))

    size = np.ones(2 * n + 2)
    meshes = np.union1d(gears.x_index, gears.subtract_index[gears.subtract_index >= 0])
    size[meshes] = MESH_SIZE_M
    size[n + meshes] = MESH_RATE_M_PER_S
    solution = solve_ivp(
        right_side,
        (time[0], time[-1]),
        np.concatenate((*start, np.zeros(2))),
        method="DOP853",
        t_eval=time,
        rtol=rtol,
        atol=rtol * size,
    )
    reached = np.full((time.size, 2 * n + 2), np.nan)
    reached[: solution.y.shape[1]] = solution.y.T
    q, v, work = np.split(reached, (n, 2 * n), axis=1)
    return np.ascontiguousarray(q), np.ascontiguousarray(v), work

"""A refined solution with SciPy's adaptive DOP853, to measure the fixed step against."""

from __future__ import annotations

import numpy as np
from scipy.integrate import solve_ivp

from analytic import kernel
from analytic.gears import Gears
from analytic.terms import Terms
from models.drive import DriveData

# Sizes below which an error does not matter at relative tolerance 1: displacements of the order of
# the play and their rates at the mesh modes, against angles of the order of a radian.
_MESH_SIZE_M, _MESH_RATE_M_PER_S = 1e-4, 1e-1


def solve(
    terms: Terms,
    gears: Gears,
    drive: DriveData,
    start: tuple[np.ndarray, np.ndarray],
    time: np.ndarray,
    rtol: float,
) -> tuple[np.ndarray, np.ndarray]:
    """States q, v of shape (times, n) at `time` (times,) [s], from `start` at time[0].

    Rows that the integrator did not reach are NaN.
    """
    n = start[0].size
    rate = np.empty(2 * n)

    def right_side(t: float, state: np.ndarray) -> np.ndarray:
        rate[:n] = state[n:]
        kernel.acceleration(terms, gears, drive, t, state[:n], state[n:], rate[n:])
        return rate.copy()

    size = np.ones(2 * n)
    size[gears.where] = _MESH_SIZE_M
    size[n + gears.where] = _MESH_RATE_M_PER_S
    solution = solve_ivp(
        right_side,
        (time[0], time[-1]),
        np.concatenate(start),
        method="DOP853",
        t_eval=time,
        rtol=rtol,
        atol=rtol * size,
    )
    states = np.full((time.size, 2 * n), np.nan)
    states[: solution.y.shape[1]] = solution.y.T
    return np.ascontiguousarray(states[:, :n]), np.ascontiguousarray(states[:, n:])

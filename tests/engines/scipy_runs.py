"""Runs of analytic models by SciPy's DOP853, stepped in Python: an outside truth for their own."""

import numpy as np
from scipy.integrate import solve_ivp

from crosscheck.analytic.model import AnalyticModel
from crosscheck.models.trajectory import recorded_times


def integrate_by_scipy(model: AnalyticModel, rtol: float) -> tuple[np.ndarray, np.ndarray]:
    """Coordinates (times, n), and works (times, 2) [J]: done by all forces, and turned over."""
    q, v = model.start()
    n = q.size

    def rates(t: float, state: np.ndarray) -> np.ndarray:
        at = model.states.evaluate(t, state[:n], state[n : 2 * n])
        v = state[n : 2 * n]
        powers = at.force @ v, np.abs(at.force) @ np.abs(v)
        return np.concatenate((v, at.acceleration, powers))

    time = recorded_times(model.scenario)
    angular = model.layout.angular
    # An error of a displacement counts beside the play, of its rate beside that of mesh modes.
    sizes = np.concatenate([np.where(angular, 1.0, 1e-4), np.where(angular, 1.0, 0.1), np.ones(2)])
    start = np.concatenate([q, v, np.zeros(2)])
    span = time[0], time[-1]
    run = solve_ivp(rates, span, start, method="DOP853", t_eval=time, rtol=rtol, atol=rtol * sizes)
    assert run.success
    return run.y[:n].T, run.y[2 * n :].T

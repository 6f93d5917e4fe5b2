"""A refined solution to measure errors against: steps of order 8 that end where teeth meet or part.

Within a step every side of every tooth stays as it is, so the equations are smooth there and the
order holds; a step that would pass a contact change is shortened, by bisection, until it ends just
behind it. The coefficients are Dormand and Prince's (SciPy's table of DOP853).
"""

from __future__ import annotations

from functools import cache
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from scipy.integrate import DOP853

from crosscheck.analytic.model import AnalyticModel
from crosscheck.analytic.paper.mesh_force import total_error
from crosscheck.analytic.paper.mesh_frequency import mesh_phase

NEAR = 1e-13  # of a step: how closely the end of one is brought to a contact change
ROUNDING = 1e-12  # of the time between two records: what is left of it is no step


class RefinedSolution(NamedTuple):
    """States q, v of shape (records, n) on the recording grid, and how many contact changes."""

    q: np.ndarray
    v: np.ndarray
    changes: int


def contact_sides(model: AnalyticModel, t: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Which flank of every mesh touches, (meshes,): 1 or -1, 0 where none does."""
    gears = model.gears
    of_two, joint = gears.subtract_index >= 0, gears.theta
    x = q[gears.x_index] - of_two * q[gears.subtract_index]
    phase = mesh_phase(gears.phase, gears.rate, gears.offset, t, q[joint], v[joint])
    gap = x - total_error(phase, gears.E, gears.error_phase, gears.static_error)
    return np.where(gap > gears.b, 1, np.where(gap <= -gears.b, -1, 0))


def take_high_order_step(model: AnalyticModel, t: float, h: float, state: np.ndarray) -> np.ndarray:
    """The state (2, n) after h [s]."""
    table, rates = tableau(), np.zeros((len(tableau()) - 1, *state.shape))
    for stage, row in enumerate(table[:-1]):
        q, v = state + h * np.tensordot(row[:stage], rates[:stage], 1)
        rates[stage] = v, model.states.evaluate(t + row[-1] * h, q, v).acceleration
    return state + h * np.tensordot(table[-1, :-1], rates, 1)


def find_step_to_change(
    model: AnalyticModel, t: float, longest: float, state: np.ndarray, sides: np.ndarray
) -> tuple[float, np.ndarray, np.ndarray]:
    """Length [s] of a step, the longest, or until just behind a change of the sides (meshes,); the
    state and the sides there."""
    low, high, h = 0.0, longest, longest
    while True:
        end = take_high_order_step(model, t, h, state)
        ahead = contact_sides(model, t + h, *end)
        changed = (ahead != sides).any()
        if h == high and (not changed or high - low <= NEAR * longest):
            return h, end, ahead
        if changed:
            high = h
        else:
            low = h
        h = high if high - low <= NEAR * longest else low + (high - low) / 2


@cache
def tableau() -> np.ndarray:
    """Rows of the twelve stages with their nodes, then the weights, shape (13, 13)."""
    stages = DOP853.n_stages
    table = np.zeros((stages + 1, stages + 1))
    table[:stages, :stages] = DOP853.A[:stages, :stages]
    table[:stages, stages] = DOP853.C[:stages]
    table[stages, :stages] = DOP853.B
    return table


def solve_refined(model: AnalyticModel, grid: np.ndarray, step: float) -> RefinedSolution:
    """From the model's start along the grid (records,) [s], by steps of at most `step` [s]."""
    state, changes = np.array(model.start()), 0
    sides, states = contact_sides(model, grid[0], *state), [state]
    for begin, end in pairwise(grid):
        span, done = end - begin, 0.0
        whole = span / np.ceil(span / step)
        while done < span * (1 - ROUNDING):
            longest = min(whole, span - done)
            passed, state, ahead = find_step_to_change(model, begin + done, longest, state, sides)
            done += passed
            changes += int((ahead != sides).sum())
            sides = ahead
        states.append(state)
    kept = np.array(states)
    return RefinedSolution(kept[:, 0], kept[:, 1], changes)

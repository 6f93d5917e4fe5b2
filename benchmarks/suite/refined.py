"""A refined solution to measure errors against: steps of order 8 that end where teeth meet or part.

Within a step every side of every tooth stays as it is, so the equations are smooth there and the
order holds; a step that would pass a contact change is shortened, by bisection, until it ends just
behind it. The coefficients are Dormand and Prince's (SciPy's table of DOP853).
"""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

import numpy as np
from numba import njit
from scipy.integrate import DOP853

from analytic import kernel
from analytic.gears import Gears
from analytic.model import AnalyticModel
from analytic.terms import Terms
from models.drive import DriveData

NEAR = 1e-13  # of a step: how closely the end of one is brought to a contact change
ROUNDING = 1e-12  # of the time between two records: what is left of it is no step


class Refined(NamedTuple):
    """States q, v of shape (records, n) on the recording grid, and how many contact changes."""

    q: np.ndarray
    v: np.ndarray
    changes: int


@njit(cache=True)
def sides_of(gears: Gears, t: float, q: np.ndarray, v: np.ndarray, out: np.ndarray) -> None:
    """Which flank of every mesh touches into out (meshes,): 1 or -1, 0 where none does."""
    for i in range(out.size):
        phase = kernel.phase_of(gears, i, t, q, v)
        gap = kernel.gap_of(gears, i, phase, np.sin(phase), q)
        out[i] = 1 if gap > gears.b[i] else -1 if gap <= -gears.b[i] else 0


@njit(cache=True)
def high_order_step(
    terms: Terms,
    gears: Gears,
    drive: DriveData,
    table: np.ndarray,
    t: float,
    h: float,
    q: np.ndarray,
    v: np.ndarray,
    rates: np.ndarray,
    end: np.ndarray,
) -> None:
    """State after h [s] into end (2, n).

    table (stages + 1, stages + 1): the row of every stage, its node last; the weights' row last.
    rates (2, stages, n) is room.
    """
    stages = rates.shape[1]
    for stage in range(stages + 1):
        for i in range(q.size):
            dq, dv = 0.0, 0.0
            for before in range(min(stage, stages)):
                dq += table[stage, before] * rates[0, before, i]
                dv += table[stage, before] * rates[1, before, i]
            end[0, i] = q[i] + h * dq
            end[1, i] = v[i] + h * dv
        if stage < stages:
            rates[0, stage] = end[1]
            node = t + table[stage, stages] * h
            kernel.acceleration(terms, gears, drive, node, end[0], end[1], rates[1, stage])


@njit(cache=True)
def step_to_change(
    terms: Terms,
    gears: Gears,
    drive: DriveData,
    table: np.ndarray,
    t: float,
    longest: float,
    state: np.ndarray,
    sides: np.ndarray,
    rates: np.ndarray,
    end: np.ndarray,
    ahead: np.ndarray,
) -> float:
    """Length [s] of a step from the state (2, n): the longest, or until just behind a change of the
    sides (meshes,). State and sides there go into end and ahead."""
    low, high, h = 0.0, longest, longest
    while True:
        high_order_step(terms, gears, drive, table, t, h, state[0], state[1], rates, end)
        sides_of(gears, t + h, end[0], end[1], ahead)
        changed = (ahead != sides).any()
        if h == high and (not changed or high - low <= NEAR * longest):
            return h
        if changed:
            high = h
        else:
            low = h
        h = high if high - low <= NEAR * longest else low + (high - low) / 2


@njit(cache=True)
def through_contacts(
    terms: Terms,
    gears: Gears,
    drive: DriveData,
    table: np.ndarray,
    start: np.ndarray,
    grid: np.ndarray,
    step: float,
) -> tuple[np.ndarray, int]:
    """States (records, 2, n) on the grid (records,) [s] by steps of at most `step` [s], and the
    number of contact changes."""
    n, meshes = start.shape[1], gears.where.size
    rates = np.empty((2, table.shape[0] - 1, n))
    states, end, state = np.empty((grid.size, 2, n)), np.empty((2, n)), start.copy()
    sides, ahead = np.empty(meshes, np.int64), np.empty(meshes, np.int64)
    sides_of(gears, grid[0], state[0], state[1], sides)
    states[0], changes = state, 0
    for k in range(grid.size - 1):
        span, done = grid[k + 1] - grid[k], 0.0
        whole = span / np.ceil(span / step)
        while done < span * (1 - ROUNDING):
            t, longest = grid[k] + done, min(whole, span - done)
            done += step_to_change(
                terms, gears, drive, table, t, longest, state, sides, rates, end, ahead
            )
            changes += (ahead != sides).sum()
            state[:], sides[:] = end, ahead
        states[k + 1] = state
    return states, changes


@cache
def tableau() -> np.ndarray:
    """Rows of the twelve stages with their nodes, then the weights, shape (13, 13)."""
    stages = DOP853.n_stages
    table = np.zeros((stages + 1, stages + 1))
    table[:stages, :stages] = DOP853.A[:stages, :stages]
    table[:stages, stages] = DOP853.C[:stages]
    table[stages, :stages] = DOP853.B
    return table


def refined(model: AnalyticModel, grid: np.ndarray, step: float) -> Refined:
    """From the model's start along the grid (records,) [s], by steps of at most `step` [s]."""
    start = np.array(model.start())
    states, changes = through_contacts(
        model.terms, model.gears, model.drive, tableau(), start, grid, step
    )
    return Refined(states[:, 0], states[:, 1], int(changes))

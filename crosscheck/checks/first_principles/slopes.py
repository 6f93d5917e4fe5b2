"""Slopes of a function of coordinates by central differences, and the bias that follows from M's.

c_i = sum over j, k of (dM_ij/dq_k - 1/2 dM_jk/dq_i) q_j' q_k'  (Siciliano et al., Robotics, 7.2).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

# The mass matrix of a chain of revolute joints holds no harmonic of a joint angle above the second
# (a rotation enters a velocity once, the energy squares it). For such f, f' is exactly a weighted
# sum of central differences over pi / 4 and 3 pi / 4: sum of w sin(m h) = m / 2 for m = 1, 2.
QUARTER_TURNS, QUARTER_WEIGHTS = (1, 3), ((np.sqrt(0.5) + 1) / 2, (np.sqrt(0.5) - 1) / 2)
# Mesh displacements must not enter M at all; over so much [m] a trace of them would show.
DISPLACEMENT_M = 1e-4
# Of order 8, for any smooth function, over short steps.
SMOOTH_WEIGHTS = 4 / 5, -1 / 5, 4 / 105, -1 / 280


class SlopeRule(NamedTuple):
    """f' as the sum of weights (k, n) times f(q + m h) - f(q - m h), m the multiples (k,).

    steps (n,): h of each coordinate; tolerance: of the bias that follows, for the reason given,
    relative to the terms that are summed.
    """

    multiples: tuple[int, ...]
    steps: np.ndarray
    weights: np.ndarray
    tolerance: float
    reason: str


def make_exact_rule(angular: np.ndarray) -> SlopeRule:
    """The rule for M by joint angles and, where angular (n,) is False, by displacements [m]."""
    weights = np.where(angular, np.transpose([QUARTER_WEIGHTS]), [[0.5 / DISPLACEMENT_M], [0.0]])
    steps, reason = np.where(angular, np.pi / 4, DISPLACEMENT_M), "slopes exact but for rounding"
    return SlopeRule(QUARTER_TURNS, steps, weights, 1e-11, reason)


def make_smooth_rule(steps: np.ndarray) -> SlopeRule:
    """The rule of order 8 over steps (n,)."""
    reason = "differences of M of order 8 leave 3e-12"
    return SlopeRule((1, 2, 3, 4), steps, np.outer(SMOOTH_WEIGHTS, 1 / steps), 1e-10, reason)


def compute_slopes(
    function: Callable[[np.ndarray], np.ndarray], q: np.ndarray, rule: SlopeRule
) -> np.ndarray:
    """Slopes (n, states, ...) along each coordinate of a function of many q (states, n)."""
    shifts = np.multiply.outer([[far, -far] for far in rule.multiples], np.diag(rule.steps))
    moved = q + shifts[..., None, :]  # (k, 2, n, states, n)
    values = function(moved.reshape(-1, q.shape[1]))
    values = values.reshape(*moved.shape[:-1], *values.shape[1:])
    return np.einsum("kn,kns...->ns...", rule.weights, values[:, 0] - values[:, 1])


def christoffel_force(slopes: np.ndarray, v: np.ndarray) -> np.ndarray:
    """The force C(q, v) v (states, n) of slopes (n, states, n, n) of a mass matrix."""
    along = np.einsum("ksij,sk,sj->si", slopes, v, v)
    return along - np.einsum("isjk,sj,sk->si", slopes, v, v) / 2

"""Derivatives by central differences of high order, and what a mass matrix demands of a bias.

A bias is a quadratic form of rates.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from crosscheck.checks.first_principles.slopes import SMOOTH_WEIGHTS

Curve = Callable[[float], np.ndarray]
STEPS = 0.5 ** np.arange(1, 16)
# Of f' h and of f'' h^2: weights of f(-4 h) ... f(4 h), of order 8 and of order 6.
CENTRAL = {
    1: (
        np.array([1 / 280, -4 / 105, 1 / 5, -4 / 5, 0, 4 / 5, -1 / 5, 4 / 105, -1 / 280]),
        np.array([0, -1 / 60, 3 / 20, -3 / 4, 0, 3 / 4, -3 / 20, 1 / 60, 0]),
    ),
    2: (
        np.array([-1 / 560, 8 / 315, -1 / 5, 8 / 5, -205 / 72, 8 / 5, -1 / 5, 8 / 315, -1 / 560]),
        np.array([0, 1 / 90, -3 / 20, 3 / 2, -49 / 18, 3 / 2, -3 / 20, 1 / 90, 0]),
    ),
}
ENOUGH = 1e-13  # accuracy of differences at which refinement stops, relative to the values
Field = Callable[[np.ndarray], np.ndarray]  # M (n, n) or gravity (n,) at coordinates (n,)
# At steps that turn joints by this angle [rad] central differences of eighth order differentiate a
# mass matrix whose angles come at most twofold to 1e-12 of its size.
TURN_RAD, SHIFT_M = 0.03, 1e-4


def derivative(curve: Curve, order: int) -> tuple[np.ndarray, np.ndarray]:
    """f'(0) or f''(0) of f: s -> (n,), and how uncertain each is, relative to the largest |f| near.

    By the step at which two methods agree best, for each component by itself: both see other
    truncation and other rounding, so their difference bounds both.
    """
    best, uncertain = np.zeros(0), np.zeros(0)
    for step in STEPS:
        values = np.array([curve(k * step) for k in range(-4, 5)])
        high, low = (w @ values / step**order for w in CENTRAL[order])
        size = np.abs(values).max(axis=0)
        size[size == 0] = 1.0
        difference = np.abs(high - low) / size
        difference[~np.isfinite(difference)] = np.inf
        if not best.size:
            best, uncertain = high, difference
        better = difference < uncertain
        best, uncertain = np.where(better, high, best), np.where(better, difference, uncertain)
        if (uncertain < ENOUGH).all():
            break
    return best, uncertain


def rate_terms(bias: Callable[[np.ndarray], np.ndarray], steps: np.ndarray) -> np.ndarray:
    """B (n, n, n): bias_i = sum over j <= k of B[i, j, k] u_j u_k; zeros below the diagonal.

    Exactly, from the bias at unit rates: what a pair of them adds to what each has alone. Rates
    are in proportion to steps (n,), since in different units a pair's share may vanish.
    A bias at many states (states, n), with steps for each (states, n), has B (states, n, n, n).
    """
    rates, n = 2.0 ** np.round(np.log2(steps / TURN_RAD)), steps.shape[-1]
    units = [rates * unit for unit in np.eye(n)]
    alone = [bias(unit) for unit in units]
    terms = np.zeros((*alone[0].shape, n, n))
    for j in range(n):
        terms[..., j, j] = alone[j]
        for k in range(j + 1, n):
            terms[..., j, k] = bias(units[j] + units[k]) - alone[j] - alone[k]
    pairs: np.ndarray = rates[..., None, :, None] * rates[..., None, None, :]
    return terms / pairs


def christoffel_terms(slopes: np.ndarray) -> np.ndarray:
    """B (n, n, n), as in rate_terms, that follows from M: dM_ij/dx_k - 1/2 dM_jk/dx_i, paired.

    slopes (n, n, n): of M along each coordinate.
    """
    terms = np.einsum("kij->ijk", slopes) - np.einsum("ijk->ijk", slopes) / 2
    return fold_rate_pairs(terms)


def find_slopes(values: Field, x: np.ndarray, steps: np.ndarray, *, curved: bool) -> np.ndarray:
    """The derivatives (n, ...) of values along each coordinate.

    steps (n,): by which each coordinate is changed to differentiate. curved: whether values bend by
    more than the joints' angles, so that smaller steps may be better.
    """
    find = _certain_slope if curved else _slope
    return np.array([find(values, x, k, step) for k, step in enumerate(steps)])


def fold_rate_pairs(terms: np.ndarray) -> np.ndarray:
    """A quadratic form's coefficients (..., n, n, n) gathered on j <= k."""
    return np.triu(terms + np.swapaxes(terms, -1, -2)) * (1 - np.eye(terms.shape[-1]) / 2)


def difference_steps(jacobian: np.ndarray, angular: np.ndarray) -> np.ndarray:
    """Steps (n,) of the coordinates x that turn all joints together no further than TURN_RAD.

    jacobian (n, n): dq/dx; angular (n,): which of q are angles. A coordinate that turns none moves
    a displacement by SHIFT_M.
    """
    turned = turns(jacobian, angular)
    shifted = np.abs(jacobian[~angular]).max(axis=0, initial=0.0)
    with np.errstate(divide="ignore"):
        return np.where(turned > 0, TURN_RAD / turned, SHIFT_M / shifted)


def turns(jacobian: np.ndarray, angular: np.ndarray) -> np.ndarray:
    """How far each coordinate of x turns the joints, added up over these, shape (n,)."""
    return np.abs(jacobian[angular]).sum(axis=0)


def _certain_slope(values: Field, x: np.ndarray, k: int, step: float) -> np.ndarray:
    """The slope along a coordinate, by the best of several steps, none of them wider.

    A step may leave the map's range, where the values need not be; NaN where all do.
    """
    along, shape = step / 2 * np.eye(x.size)[k], values(x).shape

    def answer(s: float) -> np.ndarray:
        try:
            return values(x + s * along).ravel()
        except (ArithmeticError, ValueError):
            return np.full(int(np.prod(shape)), np.nan)

    slope, uncertain = derivative(answer, 1)
    slope[~np.isfinite(uncertain)] = np.nan
    return slope.reshape(shape) / (step / 2)


def _slope(values: Field, x: np.ndarray, k: int, step: float) -> np.ndarray:
    along, sides = step * np.eye(x.size)[k], range(1, len(SMOOTH_WEIGHTS) + 1)
    changes = [values(x + far * along) - values(x - far * along) for far in sides]
    return np.tensordot(SMOOTH_WEIGHTS, changes, 1) / step

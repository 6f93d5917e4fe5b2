"""Derivatives by central differences of high order, each with its own uncertainty."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

Curve = Callable[[float], np.ndarray]
STEPS = 0.5 ** np.arange(1, 16)
# Weights of f(-4 h) ... f(4 h), of order 8 and of order 6, for f' h and for f'' h^2.
FIRST = (
    np.array([1 / 280, -4 / 105, 1 / 5, -4 / 5, 0, 4 / 5, -1 / 5, 4 / 105, -1 / 280]),
    np.array([0, -1 / 60, 3 / 20, -3 / 4, 0, 3 / 4, -3 / 20, 1 / 60, 0]),
)
SECOND = (
    np.array([-1 / 560, 8 / 315, -1 / 5, 8 / 5, -205 / 72, 8 / 5, -1 / 5, 8 / 315, -1 / 560]),
    np.array([0, 1 / 90, -3 / 20, 3 / 2, -49 / 18, 3 / 2, -3 / 20, 1 / 90, 0]),
)
ENOUGH = 1e-13  # of the size of what is differenced


def slope(curve: Curve) -> tuple[np.ndarray, np.ndarray]:
    """f'(0) of f: s -> (n,), and how uncertain each is, relative to the largest |f| nearby."""
    return _derivative(curve, FIRST, 1)


def curvature(curve: Curve) -> tuple[np.ndarray, np.ndarray]:
    """f''(0), the same way."""
    return _derivative(curve, SECOND, 2)


def _derivative(
    curve: Curve, weights: tuple[np.ndarray, np.ndarray], order: int
) -> tuple[np.ndarray, np.ndarray]:
    """The step at which two orders agree best, for each component by itself.

    Both see other truncation and other rounding, so their difference bounds both.
    """
    best, uncertain = np.zeros(0), np.zeros(0)
    for step in STEPS:
        values = np.array([curve(k * step) for k in range(-4, 5)])
        high, low = (w @ values / step**order for w in weights)
        size = np.abs(values).max(axis=0)
        size[size == 0] = 1.0
        apart = np.abs(high - low) / size
        apart[~np.isfinite(apart)] = np.inf
        if not best.size:
            best, uncertain = high, apart
        better = apart < uncertain
        best, uncertain = np.where(better, high, best), np.where(better, apart, uncertain)
        if (uncertain < ENOUGH).all():
            break
    return best, uncertain

"""Backlash clearance, Eqs. 5-6."""

from __future__ import annotations

import numpy as np


def dead_zone(x: np.ndarray | float, b: np.ndarray | float) -> np.ndarray:
    """f_k(x, b) of Eq. 5 [m]: displacement beyond a clearance of half width b; x, b [m]."""
    beyond = np.where(x > b, np.subtract(x, b), 0.0)
    return np.where(np.less_equal(x, np.negative(b)), np.add(x, b), beyond)


def dead_zone_tanh(
    x: np.ndarray | float, b: np.ndarray | float, sigma: np.ndarray | float
) -> np.ndarray:
    """f_k(x, b) of Eq. 6 [m], the smooth stand-in; x, b [m], sigma [1/m]."""
    right = np.tanh(sigma * np.subtract(x, b))
    left = np.tanh(sigma * np.add(x, b))
    return x + np.divide(x, 2) * (right - left) - np.divide(b, 2) * (right + left)

"""Backlash clearance, Eqs. 5-6."""

from __future__ import annotations

import numpy as np
from numba import vectorize


@vectorize(cache=True)
def dead_zone(x: float, b: float) -> float:
    """f_k(x, b) of Eq. 5 [m]: displacement beyond a clearance of half width b; x, b [m]."""
    if x > b:
        return x - b
    if x <= -b:
        return x + b
    return 0.0


@vectorize(cache=True)
def dead_zone_tanh(x: float, b: float, sigma: float) -> float:
    """f_k(x, b) of Eq. 6 [m], the smooth stand-in; x, b [m], sigma [1/m]."""
    right = np.tanh(sigma * (x - b))
    left = np.tanh(sigma * (x + b))
    return x + x / 2 * (right - left) - b / 2 * (right + left)

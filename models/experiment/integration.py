"""A step of the classical Runge-Kutta method, for models whose engine has none."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np


def classical_step(
    acceleration: Callable[[Any, np.ndarray, np.ndarray], np.ndarray],
    at: tuple[Any, Any, Any],
    q: np.ndarray,
    v: np.ndarray,
    h: float,
) -> tuple[np.ndarray, np.ndarray]:
    """q and v after a step h [s] of the classical Runge-Kutta method, of fourth order.

    at: what the acceleration is a function of beside q and v, at beginning, middle and end.
    """
    begin, middle, end = at
    a1 = acceleration(begin, q, v)
    v2 = v + h / 2 * a1
    a2 = acceleration(middle, q + h / 2 * v, v2)
    v3 = v + h / 2 * a2
    a3 = acceleration(middle, q + h / 2 * v2, v3)
    v4 = v + h * a3
    a4 = acceleration(end, q + h * v3, v4)
    return q + h / 6 * (v + 2 * v2 + 2 * v3 + v4), v + h / 6 * (a1 + 2 * a2 + 2 * a3 + a4)

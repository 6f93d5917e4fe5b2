"""The right-hand side y' = f(t, y), y = (q, v), compiled for one model: for other solvers."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numba import njit

from analytic import kernel
from analytic.model import AnalyticModel

RightSide = Callable[[float, np.ndarray], np.ndarray]
# Sizes beside which an error does not matter at relative tolerance 1: displacements of the order of
# the play [m] and their rates at the mesh modes [m/s], against angles of the order of a radian.
MESH_SIZES = 1e-4, 1e-1


def compiled_in_place(model: AnalyticModel) -> Any:
    """f(t, y, out), the model's numbers frozen in: a call hands over nothing but the state."""
    terms, gears, drive, n = model.terms, model.gears, model.drive, len(model.layout)

    @njit
    def in_place(t: float, y: np.ndarray, out: np.ndarray) -> None:
        out[:n] = y[n:]
        kernel.acceleration(terms, gears, drive, t, y[:n], y[n:], out[n:])

    in_place(0.0, np.concatenate(model.start()), np.empty(2 * n))
    return in_place


def compiled(model: AnalyticModel) -> RightSide:
    """f(t, y) as a new array (2 n,)."""
    in_place = compiled_in_place(model)

    @njit
    def right_side(t: float, y: np.ndarray) -> np.ndarray:
        out = np.empty_like(y)
        in_place(t, y, out)
        return out

    right_side(0.0, np.concatenate(model.start()))
    return right_side


def sizes(model: AnalyticModel) -> np.ndarray:
    """Of every entry of y (2 n,): absolute tolerances are the relative one times these."""
    angular = model.layout.angular
    of_q, of_v = (np.where(angular, 1.0, size) for size in MESH_SIZES)
    return np.concatenate([of_q, of_v])

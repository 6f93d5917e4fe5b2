"""The right-hand side y' = f(t, y), y = (q, v), by a model's machine code: for other solvers."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from crosscheck.analytic.model import AnalyticModel

RightSide = Callable[[float, np.ndarray], np.ndarray]
# Sizes beside which an error does not matter at relative tolerance 1: displacements of the order of
# the play [m] and their rates at the mesh modes [m/s], against angles of the order of a radian.
MESH_SIZES = 1e-4, 1e-1


def compile_in_place(model: AnalyticModel) -> Any:
    """f(t, y, out) by the model's machine code."""
    states, n = model.states, len(model.layout)

    def evaluate_in_place(t: float, y: np.ndarray, out: np.ndarray) -> None:
        out[:n] = y[n:]
        out[n:] = states.evaluate(t, y[:n], y[n:]).acceleration

    return evaluate_in_place


def compile_right_side(model: AnalyticModel) -> RightSide:
    """f(t, y) as a new array (2 n,)."""
    states, n = model.states, len(model.layout)

    def right_side(t: float, y: np.ndarray) -> np.ndarray:
        return np.concatenate([y[n:], states.evaluate(t, y[:n], y[n:]).acceleration])

    return right_side


def sizes(model: AnalyticModel) -> np.ndarray:
    """Of every entry of y (2 n,): absolute tolerances are the relative one times these."""
    angular = model.layout.angular
    of_q, of_v = (np.where(angular, 1.0, size) for size in MESH_SIZES)
    return np.concatenate([of_q, of_v])

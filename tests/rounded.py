"""How far rounding moves what the plain kernel says: its tolerance against another way to it.

Another way to the same equations rounds every number of them a few times, each time otherwise. So
the plain kernel is asked again with all its numbers, and the state, moved by a rounding at random;
what that moves is the equations' own conditioning, cancellations and all.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from analytic import kernel
from analytic.model import AnalyticModel
from models.scenario import Scenario

EPS = float(np.finfo(float).eps)
DRAWS = 12  # of roundings, of which the largest effect counts
# The largest of twelve draws may miss the worst direction by a factor of three, and a number is
# rounded a few times on its way; measured over every switch: at most 2.7.
ROUNDINGS = 10.0


def rounded(value: Any, draw: np.random.Generator) -> Any:
    """A number, an array or a record of them, every entry moved by up to a rounding."""
    if isinstance(value, tuple):
        parts = [rounded(part, draw) for part in value]
        return type(value)(*parts) if hasattr(value, "_fields") else tuple(parts)
    if isinstance(value, np.ndarray) and value.dtype == float:
        return value * (1 + EPS * draw.uniform(-1, 1, value.shape))
    return value


def moved(model: AnalyticModel, seed: int) -> tuple[Any, Any, Any]:
    """Terms, gears and drive of a model, all moved."""
    draw = np.random.default_rng(seed)
    return rounded((model.terms, model.gears, model.drive), draw)


def accelerations_and_forces(
    parts: tuple[Any, Any, Any], t: float, q: np.ndarray, v: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Of the plain kernel."""
    terms, gears, drive = parts
    acceleration, forces = np.empty_like(q), np.empty(gears.where.size)
    kernel.acceleration(terms, gears, drive, t, q, v, acceleration)
    kernel.elastic_forces(gears, t, q, v, forces)
    return acceleration, forces


def run(
    parts: tuple[Any, Any, Any], scenario: Scenario, start: tuple[np.ndarray, np.ndarray]
) -> tuple[np.ndarray, np.ndarray]:
    """Of the plain kernel: states q, v (records, n)."""
    return kernel.integrate(*parts, *start, scenario.step_s, scenario.steps, scenario.stride)

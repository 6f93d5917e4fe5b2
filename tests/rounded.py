"""How far rounding moves what the equations say: the tolerance of one way to them against another.

Another way to the same equations rounds every number of them a few times, each time otherwise. So
they are evaluated again with all numbers, and the state, moved by a rounding at random; what that
moves is the equations' own conditioning, cancellations and all.
"""

from typing import Any

import numpy as np

from crosscheck.analytic.model import AnalyticModel
from crosscheck.models.experiment.scenario import Scenario
from tests.equations import Parts, runge_kutta

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


def parts_of(model: AnalyticModel) -> Parts:
    """Of a model."""
    return Parts(model.terms, model.gears, model.drive)


def moved(model: AnalyticModel, seed: int) -> Parts:
    """Of a model, all numbers moved."""
    moved_parts: Parts = rounded(parts_of(model), np.random.default_rng(seed))
    return moved_parts


def run(
    parts: Parts, scenario: Scenario, start: tuple[np.ndarray, np.ndarray]
) -> tuple[np.ndarray, np.ndarray]:
    """States q, v (records, n)."""
    return runge_kutta(parts, start, scenario.step_s, scenario.steps, scenario.stride)

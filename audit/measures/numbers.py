"""Numbers that may be undefined: the event did not happen within the run, or the run diverged."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from crosscheck.audit.experiments.variant import Numbers


def quotient(one: float | None, other: float | None) -> float:
    """One number over another; nan if either is undefined or the other is 0."""
    if one is None or other is None or other == 0:
        return math.nan
    return one / other


def defined(value: float | np.floating | None) -> float | None:
    """A plain float, or None for what is undefined."""
    return float(value) if value is not None and math.isfinite(value) else None


def finite(numbers: Mapping[str, float | None]) -> Numbers:
    """Plain floats, None for what is undefined."""
    return {name: defined(value) for name, value in numbers.items()}

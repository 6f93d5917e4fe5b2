"""The band of frequencies in which a record's torques say something of the robot."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from crosscheck.identification.estimation import LinearFit
from crosscheck.identification.sampling import ROWS

RAISED = 2.0**0.5  # from a tried bandwidth to the next
# White noise grows by 1.19 from one to the next. A residual that grows by more is of what no model
# of rigid links explains: elastic gears, noise of accelerations, which makes armatures too small.
GROWN = 1.25
GAIN = 0.98  # of errors: a band that makes them no less has no information of its own


class BandQuality(NamedTuple):
    """Geometric means of the joints' residuals and of the estimates' standard errors in a band."""

    residual: float
    error: float


def choose_bandwidth(
    measure: Callable[[float], BandQuality], lowest: float, highest: float
) -> float:
    """The bandwidth [Hz] beyond which errors fall no more, or the residual grows too much.

    Args:
        measure: What a fit below a bandwidth leaves.
        lowest: The first one tried [Hz].
        highest: None beyond it is tried.
    """
    chosen, least = lowest, measure(lowest)
    while (tried := chosen * RAISED) <= highest:
        quality = measure(tried)
        is_better = quality.error < GAIN * least.error
        if not is_better or has_grown(least.residual, quality.residual, 1):
            break
        chosen, least = tried, quality
    return chosen


def has_grown(residual: float, wider: float, steps: int) -> bool:
    """Whether a residual of a band so many steps wider is more than noise makes it."""
    return wider > GROWN**steps * residual


def measure_fit(fit: LinearFit) -> BandQuality:
    """Of the fit of all terms in a band, parameters counted; what has no error counts for none."""
    rows = float(count_independent(fit.shown).sum())
    left = fit.sigma * np.sqrt(rows / max(rows - len(fit.values), 1.0))
    errors = fit.errors[fit.errors > 0]
    logarithms = np.log(left), np.log(errors if errors.size else np.ones(1))
    return BandQuality(*(float(np.exp(each.mean())) for each in logarithms))


def count_independent(shown: np.ndarray) -> np.ndarray:
    """Independent ones (n,) of rows that count (rows, n): two in a band's shortest period."""
    return np.maximum(2 / ROWS * shown.sum(axis=0), 1.0)

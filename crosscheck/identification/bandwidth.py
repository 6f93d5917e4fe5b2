"""The band of frequencies in which a record's torques say something of the robot."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from crosscheck.identification.estimation import LinearFit

RAISED = 2.0**0.5  # from a tried bandwidth to the next
GAIN = 0.98  # of errors: a band that makes them no less has no information of its own


def choose_bandwidth(measure: Callable[[float], float], lowest: float, highest: float) -> float:
    """The bandwidth [Hz] beyond which errors fall no more.

    Args:
        measure: Mean error of the estimates in a band.
        lowest: The first one tried [Hz].
        highest: None beyond it is tried.
    """
    chosen, least = lowest, measure(lowest)
    while (tried := chosen * RAISED) <= highest:
        error = measure(tried)
        if not error < GAIN * least:
            break
        chosen, least = tried, error
    return chosen


def measure_error(fit: LinearFit) -> float:
    """The geometric mean of the estimates' errors; what has none counts for none.

    Errors of blocks are no measure: of many bands they are smallest in one by chance. What no model
    of rigid links explains, such as elastic gears, makes residuals grow, and these the errors.
    """
    errors = fit.pooled_errors[fit.pooled_errors > 0]
    return float(np.exp(np.log(errors).mean())) if errors.size else 1.0

"""The band of frequencies in which a record's torques say something of the robot."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from crosscheck.identification.estimation import estimate_deviations

RAISED = 2.0**0.5  # from a tried bandwidth to the next
# Of the least residual in narrower bands: a band that leaves more adds what no model of rigid links
# explains (elastic gears, noise of derivatives).
GROWN = 1.2


def choose_bandwidth(measure: Callable[[float], float], lowest: float, highest: float) -> float:
    """The largest bandwidth [Hz] before the residual grows.

    Args:
        measure: What a fit leaves of all that is below a bandwidth.
        lowest: The first one tried [Hz].
        highest: None beyond it is tried.
    """
    chosen, least = lowest, measure(lowest)
    while (tried := chosen * RAISED) <= highest:
        left = measure(tried)
        if left > GROWN * least:
            break
        chosen, least = tried, min(least, left)
    return chosen


def measure_residual(columns: np.ndarray, torque: np.ndarray, shown: np.ndarray) -> float:
    """Geometric mean over the joints of the residuals' deviations, parameters counted.

    Args:
        columns: Of the parameters (rows, n, p).
        torque: What they shall make (rows, n).
        shown: Which of these say something (rows, n).
    """
    count, parameters = shown.sum(axis=0), columns.shape[2]
    deviations = estimate_deviations(columns, torque, shown)
    rows = int(count.sum())
    return float(np.exp(np.log(deviations).mean()) * np.sqrt(rows / max(rows - parameters, 1)))

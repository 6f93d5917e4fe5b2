"""The band of frequencies in which a record's torques say something of the robot."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from crosscheck.identification.estimation import LinearFit

RAISED = 2.0**0.5  # from a tried bandwidth to the next
# Of the least residual in narrower bands: a band that leaves more adds what no model of rigid links
# explains (elastic gears, noise of derivatives).
GROWN = 1.2


def choose_bandwidth(
    fit_band: Callable[[float], LinearFit], lowest: float, highest: float
) -> float:
    """The largest bandwidth [Hz] before the residual grows.

    Args:
        fit_band: The fit of all that is below a bandwidth.
        lowest: The first one tried [Hz].
        highest: None beyond it is tried.
    """
    chosen, least = lowest, _mean_residual(fit_band(lowest))
    while (tried := chosen * RAISED) <= highest:
        left = _mean_residual(fit_band(tried))
        if left > GROWN * least:
            break
        chosen, least = tried, min(least, left)
    return chosen


def _mean_residual(fit: LinearFit) -> float:
    """Geometric mean over the joints of the residuals' deviations, parameters counted."""
    rows, parameters = int(fit.shown.sum()), len(fit.values)
    return float(np.exp(np.log(fit.sigma).mean()) * np.sqrt(rows / max(rows - parameters, 1)))

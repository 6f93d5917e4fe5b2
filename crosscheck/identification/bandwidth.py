"""Chooses the band of frequencies of a record whose torques are used."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from crosscheck.identification.estimation import LinearFit
from crosscheck.identification.terms import TermEstimate

RAISED = 2.0**0.5  # ratio of successive bandwidths
GAIN = 0.98  # ratio of errors by which a wider band must improve


@dataclass(frozen=True)
class BandResult:
    """A bandwidth [Hz], and the estimates in it.

    is_sound: whether it holds enough of the motion for these to say something of another band's.
    """

    bandwidth: float
    estimates: tuple[TermEstimate, ...]
    is_sound: bool = True


def combine_bands(
    estimates: Sequence[TermEstimate], bandwidth: float, others: Sequence[BandResult]
) -> tuple[TermEstimate, ...]:
    """Estimates in a band, with errors that also count the estimates in other bands.

    Blocks of rows show noise alone: the effect of a filter or friction's sign is equal in all. Rows
    of one band are part of the other's: by noise estimates are less apart than the worse is wrong.
    What a narrower one is apart beyond that is the systematic part; a wider one holds more of what
    the model may lack, and makes an estimate that is beyond both intervals one of the band.
    """
    combined = []
    for each in estimates:
        again = [
            (band.is_sound, band.bandwidth > bandwidth, other)
            for band in others
            for other in band.estimates
            if other.term == each.term
        ]
        excess = [
            (other.value - each.value) ** 2 - max(other.half_width, each.half_width) ** 2
            for is_sound, is_wider, other in again
            if is_sound and not is_wider
        ]
        systematic = max([0.0, *excess]) ** 0.5
        error = float(np.hypot(each.error, systematic))
        half_width = each.half_width * error / each.error if each.error else 0.0
        beyond = (
            other.value
            for _, is_wider, other in again
            if is_wider and abs(other.value - each.value) > max(half_width, other.half_width)
        )
        combined.append(
            replace(
                each,
                error=error,
                half_width=half_width,
                systematic=systematic,
                doubled=next(beyond, None),
            )
        )
    return tuple(combined)


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

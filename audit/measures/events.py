"""The events of a run that the paper speaks of, each defined once for claims, figures and fits.

Times are in s from the start of the run, None for what does not happen in it. A mesh force [N] is
that of the shoulder's first sun-planet mesh: positive while the flanks touch that drive the arm
from the start, negative on the opposite ones, 0 within the clearance. ``excess`` is the shoulder's
acceleration less that of the rigid arm [rad/s^2]. Arrays are (times,).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from crosscheck import signals

THIRD_S = (0.5, 1.2)  # the "third fluctuation", well after the side change at 0.3 s
PEAK_S = 0.1  # around its largest value: what its frequency is read off
SIDE_AFTER_S = 0.25  # the starting vibration no longer turns the mesh force
AT_ONCE_S = 0.02  # so soon after an event there is nothing but the event itself
IMPACT_S = 0.1  # what follows a side change within this time belongs to it
RETURN_S = (1.3, 2.4)  # between the third fluctuation's side changes and the end's
STABLE_S = 2.6  # "stable after": Section 3.2


class SideChange(NamedTuple):
    """The teeth's way to the opposite flanks: when [s] they left the first, when [s] they met.

    left_s is nan for teeth that were on no flank before.
    """

    left_s: float
    met_s: float


def third_peak(time: np.ndarray, excess: np.ndarray, window: slice) -> slice:
    """The samples of PEAK_S around the largest excess in a window that is not empty."""
    inside = time[window]
    centre = inside[int(np.argmax(np.abs(excess[window])))]
    begin = min(max(centre - PEAK_S / 2, inside[0]), inside[-1] - PEAK_S)
    near = signals.window(inside, begin, begin + PEAK_S)
    return slice(window.start + near.start, window.start + near.stop)


def side_change(time: np.ndarray, force: np.ndarray) -> SideChange | None:
    """The teeth's change of sides: the first contact of the opposite flanks once the start is over.

    None where teeth vibrate across their clearance before the load has changed its sign: they then
    touch both flanks all the time.
    """
    later = signals.window(time, SIDE_AFTER_S, np.inf)
    met = signals.crossing_time_below(time[later], force[later], 0.0)
    if met is None:
        return None
    parts = (met - IMPACT_S, met), (met, met + IMPACT_S)
    before, after = (force[signals.window(time, *part)] for part in parts)
    if (before < 0).any() or after.mean() > 0:
        return None
    held = np.flatnonzero(force[: int(np.searchsorted(time, met))] > 0)
    return SideChange(float(time[held[-1]]) if held.size else np.nan, met)


def third_window(time: np.ndarray, *forces: np.ndarray) -> slice:
    """The third fluctuation's samples once no impact of these sun meshes' side changes is left.

    With a wide clearance the teeth's way takes long, the elbow's longer than the shoulder's.
    """
    changes = [side_change(time, force) for force in forces]
    met_s = max((side.met_s for side in changes if side is not None), default=-np.inf)
    begin, end = THIRD_S
    if met_s + IMPACT_S < end - PEAK_S:
        begin = max(begin, met_s + IMPACT_S)
    return signals.window(time, begin, end)


def bounce_duration(time: np.ndarray, force: np.ndarray, met_s: float) -> float:
    """How long [s] after flanks met they last part again, or touch the others, within IMPACT_S."""
    part = signals.window(time, met_s, met_s + IMPACT_S)
    open_samples = np.flatnonzero(force[part] >= 0)
    return float(time[part][open_samples[-1]] - met_s) if open_samples.size else 0.0


def zero_crossings(values: np.ndarray) -> np.ndarray:
    """Indices of the samples that are the last before values pass zero."""
    return np.flatnonzero(np.diff(np.signbit(values)))


def teeth_return(time: np.ndarray, force: np.ndarray) -> float | None:
    """Time [s] of the first contact of the driving flanks after the last of the opposite ones."""
    part = signals.window(time, *RETURN_S)
    opposite = np.flatnonzero(force[part] < 0)
    if not opposite.size:
        return None
    after = slice(part.start + int(opposite[-1]), part.stop)
    return signals.crossing_time_above(time[after], force[after], 0.0)


def overshoot(angle: np.ndarray, target: float) -> float:
    """How far an angle [rad] goes beyond its step 0 to ``target``, over the step."""
    return float(angle.max()) / target - 1


def setback(angle: np.ndarray, target: float) -> float:
    """How far an angle [rad] falls back on its way from 0 to its largest value, over the step."""
    way = angle[: int(np.argmax(angle)) + 1]
    return float((np.maximum.accumulate(way) - way).max()) / target


def distance_from(time: np.ndarray, angle: np.ndarray, target: float, begin_s: float) -> float:
    """Largest distance of an angle [rad] from its target from a time on, over the step 0 to it.

    nan for a run that ends before.
    """
    late = angle[int(np.searchsorted(time, begin_s)) :]
    return signals.amplitude(late - target) / target

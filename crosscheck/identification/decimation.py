"""Signals of a recording at even times, with no more rows than a band of frequencies needs."""

from __future__ import annotations

from math import floor, log2
from typing import NamedTuple

import numpy as np
from scipy.signal import firwin, upfirdn

from crosscheck.identification.recording import Recording

# Rows in the shortest period of a band, at least: signals filtered to the band then have less than
# 1e-11 of their amplitude at the highest frequency that rows resolve, and when a joint's direction
# turns is told to a 64th of the period.
RESOLVED = 64.0
# Before every second row is left out, what is beyond a quarter of their rate is taken away: six
# digits of it, by a symmetric filter without phase.
TAPS, WINDOW = 33, ("kaiser", 12.3)


class EvenSignals(NamedTuple):
    """Rows of position and torque (rows, n) so much time apart [s]."""

    step: float
    position: np.ndarray
    torque: np.ndarray


class DecimatedSignals:
    """A recording's signals at even times, and with half, a quarter, ... of their rows.

    Nothing that is asked of a band is lost: it lies far below the rate of the rows that are left.

    Args:
        recording: Times that are not even are made so by lines between rows.
        torque: Of the recording, on one side of the gears (rows, n).
    """

    def __init__(self, recording: Recording, torque: np.ndarray) -> None:
        self._levels = [_space_evenly(recording.time, recording.position, torque)]

    def select(self, bandwidth: float) -> EvenSignals:
        """The signals with the fewest rows that are enough for a bandwidth [Hz]."""
        level = max(floor(-log2(RESOLVED * bandwidth * self._levels[0].step)), 0)
        while len(self._levels) <= level:
            finest = self._levels[-1]
            halves = halve_rows(finest.position), halve_rows(finest.torque)
            self._levels.append(EvenSignals(2 * finest.step, *halves))
        return self._levels[level]


def halve_rows(signal: np.ndarray) -> np.ndarray:
    """Every second row of a signal (rows, n), the first among them, low-passed before."""
    pad = min(TAPS // 2, len(signal) - 1)
    taps = firwin(2 * pad + 1, 0.5, window=WINDOW)
    filtered = upfirdn(taps, continue_signal(signal, pad, pad), down=2, axis=0)
    return np.ascontiguousarray(filtered[pad : pad + (len(signal) + 1) // 2])


def continue_signal(signal: np.ndarray, before: int, behind: int) -> np.ndarray:
    """A signal (rows, n) with so many rows more at its ends: turned about them."""
    return np.concatenate(
        [
            2 * signal[0] - signal[before:0:-1],
            signal,
            2 * signal[-1] - signal[-2 : -behind - 2 : -1],
        ]
    )


def _space_evenly(time: np.ndarray, position: np.ndarray, torque: np.ndarray) -> EvenSignals:
    """The signals at even times, as they are where the times are even to 1e-3 of a step."""
    step = float((time[-1] - time[0]) / (len(time) - 1))
    even = time[0] + step * np.arange(len(time))
    if np.abs(even - time).max() < 1e-3 * step:
        return EvenSignals(step, position, torque)
    signals = (
        np.column_stack([np.interp(even, time, column) for column in signal.T])
        for signal in (position, torque)
    )
    return EvenSignals(step, *signals)

"""Signals of a recording at even times."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from crosscheck.recordings.record import Record

EVEN = 1e-3  # share of a step: times so near to even ones count as even


class EvenSignals(NamedTuple):
    """Rows of position and torque (rows, n) so much time apart [s]."""

    step: float
    position: np.ndarray
    torque: np.ndarray


def space_signals(recording: Record, torque: np.ndarray) -> EvenSignals:
    """A recording's positions and a torque of it (rows, n) at even times, by lines between rows."""
    signals, time = [recording.position, torque], recording.time
    even, step = np.linspace(time[0], time[-1], len(time), retstep=True)
    if np.abs(even - time).max() >= EVEN * step:
        signals = [
            np.column_stack([np.interp(even, time, each) for each in signal.T])
            for signal in signals
        ]
    return EvenSignals(recording.step, *signals)


def continue_signal(signal: np.ndarray, before: int, behind: int) -> np.ndarray:
    """A signal (rows, ...) with so many rows more at its ends: turned about them."""
    return np.concatenate(
        [
            2 * signal[0] - signal[before:0:-1],
            signal,
            2 * signal[-1] - signal[-2 : -behind - 2 : -1],
        ]
    )

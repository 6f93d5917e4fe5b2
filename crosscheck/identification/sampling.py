"""Recordings in a band of frequencies: motions without phase shift, and rows no denser than it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.fft import irfft, rfft, rfftfreq

from crosscheck.identification.recording import Recording

# Of the Butterworth filter that runs forth and back: its square in size, and no phase.
ORDER = 4
MOST_ROWS = 20_000  # of a long record they stand further apart: estimates need no more
PADDED = 5.0  # shortest periods that a recording is continued by, turned about its ends
ROWS = 4.0  # in the shortest period of the band
EDGE = 1.0  # shortest periods that each end loses, where the filter has data of one side alone
# Below this share of its fastest rate a joint stands: friction may then hold any torque.
SLOW = 0.01


@dataclass(frozen=True)
class BandSample:
    """Rows of all recordings in a band up to a bandwidth [Hz].

    q, v, a (rows, n): motion; moving (rows, n): whether a joint does not stand; direction (rows,
    n): of joints' rates; shared_direction (rows, shared): of motors that several joints turn;
    torque (rows, n), and torque_rate, its slope in time; starts: the first row of each recording,
    then the count of rows; step [s]: between rows.
    """

    bandwidth: float
    q: np.ndarray
    v: np.ndarray
    a: np.ndarray
    moving: np.ndarray
    direction: np.ndarray
    shared_direction: np.ndarray
    torque: np.ndarray
    torque_rate: np.ndarray
    starts: tuple[int, ...]
    step: float


def sample(
    recordings: Sequence[Recording],
    torques: Sequence[np.ndarray],
    shared: np.ndarray,
    bandwidth: float,
) -> BandSample:
    """Filter recordings and take rows of them.

    Times that are not even are made so by lines between rows: a band is far below the rows' rate.

    Args:
        torques: Of each recording (rows, n).
        shared: Rates of motors that several joints turn, for rates of joints (shared, n).
        bandwidth: Where the filter, forth and back, lets half of an amplitude pass [Hz].
    """
    seconds = sum(float(each.time[-1] - each.time[0]) for each in recordings)
    spacing = max(1 / (ROWS * bandwidth), seconds / MOST_ROWS)
    pairs = zip(recordings, torques, strict=True)
    filtered = [_filter_recording(*pair, shared, bandwidth, spacing) for pair in pairs]
    fastest = np.max([np.abs(each.rates).max(axis=0) for each in filtered], axis=0)
    parts, starts = [], [0]
    for each in filtered:
        direction = _filter_direction(each, fastest, bandwidth)
        count = each.q.shape[1]
        v = each.rates[each.rows, :count]
        sides = direction[:, :count], direction[:, count:]
        parts.append((each.q, v, each.a, *sides, each.torque, each.torque_rate))
        starts.append(starts[-1] + len(each.rows))
    q, v, a, direction, shared_direction, torque, slope = (
        np.concatenate(each) for each in zip(*parts, strict=True)
    )
    moving = np.abs(v) > SLOW * fastest[: v.shape[1]]
    return BandSample(
        bandwidth=bandwidth,
        q=q,
        v=v,
        a=a,
        moving=moving,
        direction=direction,
        shared_direction=shared_direction,
        torque=torque,
        torque_rate=slope,
        starts=tuple(starts),
        step=spacing,
    )


def lowest_bandwidth(recordings: Sequence[Recording]) -> float:
    """The least bandwidth [Hz] whose edges leave most of every recording."""
    return max(20 * EDGE / float(each.time[-1] - each.time[0]) for each in recordings)


def highest_bandwidth(recordings: Sequence[Recording]) -> float:
    """The largest bandwidth [Hz] that every recording's rows resolve."""
    return min(1 / (2 * ROWS * each.step) for each in recordings)


class _FilteredRecording(NamedTuple):
    """A recording in a band: its step [s], which rows are kept, and signals.

    q, a, torque, torque_rate (rows kept, n); rates of joints, then of motors that several joints
    turn, of all rows.
    """

    step: float
    rows: np.ndarray
    q: np.ndarray
    rates: np.ndarray
    a: np.ndarray
    torque: np.ndarray
    torque_rate: np.ndarray


def _filter_recording(
    recording: Recording, torque: np.ndarray, shared: np.ndarray, bandwidth: float, spacing: float
) -> _FilteredRecording:
    step, (position, torque) = _space_evenly(recording.time, recording.position, torque)
    edge = int(EDGE / (bandwidth * step))
    rows = np.arange(edge, len(position) - edge, spacing / step).astype(int)
    q, v, a = _filter(position, step, bandwidth, (0, 1, 2))
    torque, slope = _filter(torque, step, bandwidth, (0, 1))
    rates = np.hstack([v, v @ shared.T])
    return _FilteredRecording(step, rows, q[rows], rates, a[rows], torque[rows], slope[rows])


def _filter_direction(
    recording: _FilteredRecording, fastest: np.ndarray, bandwidth: float
) -> np.ndarray:
    """Signs of the rates at the rows kept, between -1 and 1 where they are slow."""
    slow = SLOW * np.where(fastest > 0, fastest, 1.0)
    signs = np.clip(recording.rates / slow, -1.0, 1.0)
    (direction,) = _filter(signs, recording.step, bandwidth, (0,))
    return direction[recording.rows]


def _space_evenly(time: np.ndarray, *signals: np.ndarray) -> tuple[float, list[np.ndarray]]:
    """Mean step [s], and signals (rows, n) at even times."""
    step = float((time[-1] - time[0]) / (len(time) - 1))
    even = time[0] + step * np.arange(len(time))
    if np.abs(even - time).max() < 1e-3 * step:
        return step, list(signals)
    return step, [
        np.column_stack([np.interp(even, time, column) for column in signal.T])
        for signal in signals
    ]


def _filter(
    signal: np.ndarray, step: float, bandwidth: float, orders: tuple[int, ...]
) -> list[np.ndarray]:
    """Derivatives of these orders of a filtered signal (rows, n)."""
    rows = len(signal)
    pad = min(int(PADDED / (bandwidth * step)), rows - 1)
    long = np.concatenate(
        [
            2 * signal[0] - signal[pad:0:-1],
            signal,
            2 * signal[-1] - signal[-2 : -pad - 2 : -1],
        ]
    )
    # Without the line from end to end, what the transform continues periodically has no step.
    slope = (long[-1] - long[0]) / ((len(long) - 1) * step)
    time = step * np.arange(-pad, len(long) - pad)
    line = long[0] + slope * (time - time[0])[:, None]
    frequency = rfftfreq(len(long), step)[:, None]
    passed = rfft(long - line, axis=0) / (1 + (frequency / bandwidth) ** (2 * ORDER))
    lines = {0: line, 1: slope, 2: np.zeros_like(slope)}
    kept = slice(pad, pad + rows)
    derivatives = []
    for order in orders:
        whole = irfft(passed * (2j * np.pi * frequency) ** order, len(long), axis=0)
        derivatives.append((whole + lines[order])[kept])
    return derivatives

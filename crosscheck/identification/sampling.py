"""Recordings in a band of frequencies: motions without phase shift, and rows no denser than it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from scipy.fft import irfft, next_fast_len, rfft, rfftfreq

from crosscheck.identification.decimation import DecimatedSignals, EvenSignals, continue_signal
from crosscheck.identification.recording import Recording

# Of the Butterworth filter that runs forth and back: its square in size, and no phase.
ORDER = 4
TOGETHER = 1000  # rows of which columns are made at a time
MOST_ROWS = 20_000  # of a long record they stand further apart: estimates need no more
# Shortest periods that a recording is continued by, turned about its ends: what is beyond them
# weighs less than 1e-10 in the filter.
PADDED = 10.0
ROWS = 4.0  # in the shortest period of the band
EDGE = 1.0  # shortest periods that each end loses, where the filter has data of one side alone
# Below this share of its fastest rate a joint stands: friction may then hold any torque.
SLOW = 0.01
# Of the power of a joint's motion: in a band that holds less, edges and noise are what is left.
MOTION_SHARE = 0.9


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

    def pieces(self) -> Iterator[tuple[slice, BandSample]]:
        """All rows, some at a time, and which: as of one recording each."""
        for first in range(0, len(self.q), TOGETHER):
            rows = slice(first, min(first + TOGETHER, len(self.q)))
            signals = {
                name: value[rows] for name, value in vars(self).items() if np.ndim(value) == 2
            }
            yield rows, replace(self, **signals, starts=(0, rows.stop - first))


def sample(
    recordings: Sequence[DecimatedSignals], shared: np.ndarray, bandwidth: float
) -> BandSample:
    """Filter recordings and take rows of them.

    Args:
        recordings: Position and torque of each.
        shared: Rates of motors that several joints turn, for rates of joints (shared, n).
        bandwidth: Where the filter, forth and back, lets half of an amplitude pass [Hz].
    """
    signals = [each.select(bandwidth) for each in recordings]
    seconds = sum(each.step * (len(each.position) - 1) for each in signals)
    spacing = max(1 / (ROWS * bandwidth), seconds / MOST_ROWS)
    filtered = [_filter_recording(each, shared, bandwidth, spacing) for each in signals]
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
    """The least bandwidth [Hz] that holds the motion, and whose edges leave most of a recording."""
    edges = (20 * EDGE / float(each.time[-1] - each.time[0]) for each in recordings)
    return max(*edges, *map(motion_bandwidth, recordings))


def motion_bandwidth(recording: Recording) -> float:
    """Below it half of the joints have most of their motion's power [Hz]."""
    rows = next_fast_len(len(recording.time), real=True)
    moved = recording.position - recording.position.mean(axis=0)
    power = np.cumsum(np.abs(rfft(moved.T, rows)) ** 2, axis=1)
    holds = (power >= MOTION_SHARE * power[:, -1:]).argmax(axis=1)
    return float(np.median(rfftfreq(rows, recording.step)[holds]))


def highest_bandwidth(recordings: Sequence[Recording]) -> float:
    """The largest bandwidth [Hz] that every recording's rows resolve."""
    return min(1 / (2 * ROWS * each.step) for each in recordings)


Rows = np.ndarray | slice


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
    signals: EvenSignals, shared: np.ndarray, bandwidth: float, spacing: float
) -> _FilteredRecording:
    step, position, torque = signals
    edge = int(EDGE / (bandwidth * step))
    rows = np.arange(edge, len(position) - edge, spacing / step).astype(int)
    q, v, a = _filter(position, step, bandwidth, ((0, rows), (1, slice(None)), (2, rows)))
    torque, slope = _filter(torque, step, bandwidth, ((0, rows), (1, rows)))
    return _FilteredRecording(step, rows, q, np.hstack([v, v @ shared.T]), a, torque, slope)


def _filter_direction(
    recording: _FilteredRecording, fastest: np.ndarray, bandwidth: float
) -> np.ndarray:
    """Signs of the rates at the rows kept, between -1 and 1 where they are slow."""
    slow = SLOW * np.where(fastest > 0, fastest, 1.0)
    signs = np.clip(recording.rates / slow, -1.0, 1.0)
    (direction,) = _filter(signs, recording.step, bandwidth, ((0, recording.rows),))
    return direction


def _filter(
    signals: np.ndarray, step: float, bandwidth: float, asked: Sequence[tuple[int, Rows]]
) -> list[np.ndarray]:
    """Derivatives of filtered signals (rows, n): each of an order, at the rows asked for.

    One signal after the other: all of a long recording's at once would take much memory.
    """
    columns = [list(_filter_signal(each, step, bandwidth, asked)) for each in signals.T]
    return [np.column_stack(parts) for parts in zip(*columns, strict=True)]


def _filter_signal(
    signal: np.ndarray, step: float, bandwidth: float, asked: Sequence[tuple[int, Rows]]
) -> Iterator[np.ndarray]:
    """The same of a single signal (rows,)."""
    rows = len(signal)
    pad = min(int(PADDED / (bandwidth * step)), rows - 1)
    behind = min(next_fast_len(rows + 2 * pad, real=True) - rows - pad, rows - 1)
    long = continue_signal(signal, pad, behind)
    # Without the line from end to end, what the transform continues periodically has no step.
    slope = (long[-1] - long[0]) / ((len(long) - 1) * step)
    line = long[0] + slope * (step * np.arange(len(long)))
    frequency = rfftfreq(len(long), step)
    passed = rfft(long - line) / (1 + (frequency / bandwidth) ** (2 * ORDER))
    kept = slice(pad, pad + rows)
    lines = {0: line[kept], 1: np.full(rows, slope), 2: np.zeros(rows)}
    for order, at in asked:
        turned = irfft(passed * (2j * np.pi * frequency) ** order, len(long))[kept]
        yield turned[at] + lines[order][at]

"""Recordings in a band of frequencies: motions without phase shift, and rows no denser than it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from math import ceil, floor, log2
from typing import Any, NamedTuple

import numpy as np
from scipy.fft import irfft, next_fast_len, rfft, rfftfreq
from scipy.interpolate import CubicSpline
from scipy.sparse import block_diag, csr_array

from crosscheck.recordings.record import Record

# Order of the Butterworth filter, which runs forth and back: its square in size, and no phase. At
# half of its band it removes 2e-5 of an amplitude; order 4 would remove 4e-3, which lower bands
# would turn into errors of inertia.
ORDER = 8
# Torques are no linear functions of motions: what a filter takes from a motion is missing in their
# products far below the band. So motions pass so many times the band, are put into the columns, and
# these pass the band itself by the same weights as the torques: that leaves any linear model true.
MOTION_BAND = 4.0
# Torques and friction's directions pass so many times the band of motions: what a filter takes from
# them near the band of motions is still in columns.
TORQUE_BAND = 2.0
# Rows in the shortest period of the band of motions, at least, of signals that are filtered to it:
# these have 1e-14 of their amplitude at the highest frequency that the rows resolve.
RESOLVED = 32.0
TOGETHER = 1000  # rows of which columns are made at a time
MOST_ROWS = 20_000  # rows of a long record: estimates need no more
# Shortest periods that a recording is continued by, turned about its ends: what is beyond them
# weighs less than 1e-10 in the filter.
PADDED = 20.0
ROWS = 4.0  # rows in the shortest period of the band
DENSE = 4  # rows of motion from a row to the next: twice in the torques' own shortest period
REACH = 1.0  # shortest periods before and behind a row that count in it
SOFT = 1.25  # bands of motions of which their filter leaves something
FINE, WEIGHED = 400, 10  # frequencies of the band of motions, and rows, that say how much it leaves
# Shortest periods of the motion's band that each end loses: what follows after them is missing.
EDGE = 4.0
# Below this share of its fastest rate a joint stands: friction may then hold any torque.
SLOW = 0.01
# Below this share of it a direction counts in parts: less, and signs of rounding count; more, and
# rows beside a turn do not have the whole friction that their torques have.
RAMP = 1e-6
# Standard deviations of a rate's noise below which its sign is not known.
UNSURE = 4.0
# Longest turn in shortest periods of the motion's band: a longer one is a rest.
TURN = 1 / 4
CUBIC = 4  # coefficients of the curve over a turn
# Share of a joint's motion power that a band must hold: with less, edges and noise dominate.
MOTION_SHARE = 0.9
LEAST_PERIODS = 20.0  # periods of a band in a recording
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


@dataclass(frozen=True)
class BandSample:
    """Rows of all recordings in a band up to a bandwidth [Hz].

    q, v, a (rows, n): motion; moving (rows, n): whether a joint does not stand; direction (rows,
    n): of joints' rates; shared_direction (rows, shared): of motors that several joints turn;
    torque (rows, n), and torque_rate, its slope in time; starts: the first row of each recording,
    then the count of rows; step [s]: between rows; dense: denser rows of the wider band of motions,
    and weights (rows, dense rows) that make a row of these, None where nothing was filtered;
    acceleration_noise (n,): standard deviations that white noise of positions leaves in the band.
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
    dense: BandSample | None = None
    weights: csr_array | None = None
    acceleration_noise: np.ndarray | None = None

    @property
    def states(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Positions, rates and accelerations (rows, n)."""
        return self.q, self.v, self.a

    @property
    def motion(self) -> BandSample:
        """Rows to make columns of, which `filter` then makes the rows of the band."""
        return self if self.dense is None else self.dense

    def filter(self, values: np.ndarray) -> np.ndarray:
        """Values (rows of motion, ...) in the band, as the torques are."""
        if self.weights is None:
            return values
        filtered = self.weights @ values.reshape(len(values), -1)
        return filtered.reshape(-1, *values.shape[1:])

    def select(self, rows: slice) -> BandSample:
        """These rows, as of one recording."""
        signals = {name: value[rows] for name, value in vars(self).items() if name in SIGNALS}
        selected = replace(self, **signals, starts=(0, len(self.q[rows])))
        if self.dense is None or self.weights is None:
            return selected
        weights = self.weights[rows]
        reached = slice(int(weights.indices.min()), int(weights.indices.max()) + 1)
        dense = self.dense.select(reached)
        return replace(selected, dense=dense, weights=weights[:, reached])

    def pieces(self) -> Iterator[tuple[slice, BandSample]]:
        """All rows, some at a time, and which: as of one recording each."""
        for first in range(0, len(self.q), TOGETHER):
            rows = slice(first, min(first + TOGETHER, len(self.q)))
            yield rows, self.select(rows)

    def turn(self, zeros: np.ndarray) -> BandSample:
        """The same with other zeros (n,) of the positions."""
        dense = None if self.dense is None else self.dense.turn(zeros)
        return replace(self, q=self.q + zeros, dense=dense)


SIGNALS = (
    *("q", "v", "a", "moving", "direction", "shared_direction"),
    *("torque", "torque_rate"),
)


def sample(recordings: Sequence[EvenSignals], shared: np.ndarray, bandwidth: float) -> BandSample:
    """Filter recordings and take rows of them.

    Args:
        recordings: Position and torque of each.
        shared: Rates of motors that several joints turn, for rates of joints (shared, n).
        bandwidth: Where the filter, forth and back, lets half of an amplitude pass [Hz].
    """
    step = max(each.step for each in recordings)
    wide = min(MOTION_BAND, 1 / (ROWS * bandwidth * step))
    spacing = max(1 / (DENSE * ROWS * bandwidth), step)
    seconds = sum(each.step * (len(each.torque) - 1) for each in recordings)
    every = max(round(1 / (ROWS * bandwidth * spacing)), ceil(seconds / (MOST_ROWS * spacing)))
    motions = [_filter_motion(each, shared, wide * bandwidth, spacing) for each in recordings]
    fastest = np.max([np.abs(each.rates).max(axis=0) for each in motions], axis=0)
    parts, weights, starts, joints = [], [], [0], recordings[0].position.shape[1]
    for each, given in zip(motions, recordings, strict=True):
        v = each.rates[each.rows, :joints]
        torques = _filter_torques(each, given, shared, fastest, wide * bandwidth)
        parts.append((each.q, v, each.a, *torques))
        weights.append(_weigh_rows(bandwidth * each.step * each.rows, every))
        starts.append(starts[-1] + weights[-1].shape[0])
    names = [name for name in SIGNALS if name != "moving"]
    dense: dict[str, Any] = dict(
        zip(names, map(np.concatenate, zip(*parts, strict=True)), strict=True)
    )
    together = csr_array(block_diag(weights))
    rows = {name: together @ value for name, value in dense.items()}
    slow = SLOW * fastest[:joints]

    def gather(signals: dict[str, Any], band: float, step: float) -> BandSample:
        moving = np.abs(signals["v"]) > slow
        return BandSample(band, **signals, moving=moving, starts=(0, len(moving)), step=step)

    return replace(
        gather(rows, bandwidth, every * spacing),
        starts=tuple(starts),
        dense=gather(dense, wide * bandwidth, spacing),
        weights=together,
        acceleration_noise=_measure_acceleration_noise(motions, weights, wide * bandwidth)[:joints],
    )


def _measure_acceleration_noise(
    motions: Sequence[_FilteredMotion], weights: Sequence[csr_array], band: float
) -> np.ndarray:
    """What the noise of rates (joints and shared,) in the band of motions is of filtered ones.

    Each derivative takes white noise times its frequency. Of some rows, since dense ones are not
    quite even, with weights (rows, times) of each motion's.
    """
    frequencies, power = np.linspace(0.0, SOFT * band, FINE), []
    let_pass = 1 / (1 + (frequencies / band) ** (2 * ORDER))
    for motion, table in zip(motions, weights, strict=True):
        times, passed = motion.step * motion.rows, []
        for row in np.linspace(0, table.shape[0] - 1, WEIGHED).astype(int):
            weighed = slice(table.indptr[row], table.indptr[row + 1])
            turned = np.exp(2j * np.pi * np.outer(frequencies, times[table.indices[weighed]]))
            passed.append(np.abs(turned @ table.data[weighed]) ** 2)
        left = SOFT * np.mean(frequencies**4 * let_pass**2 * np.mean(passed, axis=0))
        power.append(3 * (2 * np.pi / band) ** 2 * left * motion.rate_noise**2)
    noise: np.ndarray = np.sqrt(np.mean(power, axis=0))
    return noise


def _weigh_rows(times: np.ndarray, every: int) -> csr_array:
    """Weights (rows, times) of a low-pass without phase, a row at one of so many times.

    A sinc function in Hamming's window, 1 in sum: half of an amplitude passes at frequency 1.

    Args:
        times: In shortest periods of the band.
    """
    inside = (times - times[0] > REACH) & (times[-1] - times > REACH)
    centres = times[np.flatnonzero(inside)[::every]]
    first = np.searchsorted(times, centres - REACH)
    last = np.searchsorted(times, centres + REACH, side="right")
    counts = last - first
    ends = np.concatenate([[0], np.cumsum(counts)])
    places = np.arange(ends[-1]) + np.repeat(first - ends[:-1], counts)
    distances = times[places] - np.repeat(centres, counts)
    values = np.sinc(2 * distances) * (0.54 + 0.46 * np.cos(np.pi * distances / REACH))
    values /= np.repeat(np.add.reduceat(values, ends[:-1]), counts)
    return csr_array((values, places, ends), shape=(len(centres), len(times)))


def lowest_bandwidth(recordings: Sequence[Record]) -> float:
    """The least bandwidth [Hz] that holds the motion, and whose edges leave most of a recording."""
    edges = (LEAST_PERIODS / float(each.time[-1] - each.time[0]) for each in recordings)
    return max(*edges, *map(motion_bandwidth, recordings))


def motion_bandwidth(recording: Record) -> float:
    """Below it half of the joints have most of their motion's power [Hz]."""
    rows = next_fast_len(len(recording.time), real=True)
    moved = recording.position - recording.position.mean(axis=0)
    power = np.cumsum(np.abs(rfft(moved.T, rows)) ** 2, axis=1)
    holds = (power >= MOTION_SHARE * power[:, -1:]).argmax(axis=1)
    return float(np.median(rfftfreq(rows, recording.step)[holds]))


def highest_bandwidth(recordings: Sequence[Record]) -> float:
    """The largest bandwidth [Hz] that every recording's rows resolve."""
    return min(1 / (2 * ROWS * each.step) for each in recordings)


class _FilteredMotion(NamedTuple):
    """A recording's motion in a band: its step [s] and signals.

    stride: recorded rows in a step; rows: which steps are kept; q, a (rows kept, n); rates of
    joints, then of motors that several joints turn, at all steps, and standard deviations of their
    noise.
    """

    step: float
    stride: int
    rows: np.ndarray
    q: np.ndarray
    rates: np.ndarray
    a: np.ndarray
    rate_noise: np.ndarray


def _filter_motion(
    given: EvenSignals, shared: np.ndarray, bandwidth: float, spacing: float
) -> _FilteredMotion:
    stride = 2 ** max(floor(-log2(RESOLVED * bandwidth * given.step)), 0)
    step, taken = stride * given.step, given.position[::stride]
    edge = int(EDGE / (bandwidth * step))
    rows = np.arange(edge, len(taken) - edge, spacing / step).astype(int)
    asked = (0, slice(None)), (1, slice(None)), (2, rows)
    q, v, a = _filter(given.position.T, len(given.position), given.step, bandwidth, stride, asked)
    # White noise has as much in each hertz of the band as beyond it, where there is no motion.
    beyond = (taken - q)[edge : len(q) - edge].var(axis=0) / (1 / (2 * given.step) - bandwidth)
    variance = beyond * (2 * np.pi) ** 2 * bandwidth**3 / 3
    noise = np.sqrt(np.append(variance, shared**2 @ variance))
    return _FilteredMotion(step, stride, rows, q[rows], np.hstack([v, v @ shared.T]), a, noise)


def _filter_torques(
    motion: _FilteredMotion,
    given: EvenSignals,
    shared: np.ndarray,
    fastest: np.ndarray,
    bandwidth: float,
) -> list[np.ndarray]:
    """Signs of joints' and of shared motors' rates at the rows kept, torques and their slopes.

    Signs are taken at the times of the recorded torques. While the noise of a rate hides when it
    changes its sign, a curve leads over both.
    """
    size, count, joints = np.where(fastest > 0, fastest, 1.0), len(fastest), given.torque.shape[1]
    least = np.clip(UNSURE * motion.rate_noise, RAMP * size, SLOW * size)
    known = motion.step * np.arange(len(motion.rates))
    times, most = given.step * np.arange(len(given.torque)), int(TURN / (bandwidth * given.step))

    def bridge_turns() -> Iterator[np.ndarray]:
        turns = []  # of each joint and shared motor: first rows, and rows behind the last
        for turning in range(count):
            rates = CubicSpline(known, motion.rates[:, turning])(times)
            hidden = np.abs(rates) < least[turning]
            edges = np.flatnonzero(np.diff(hidden, prepend=False, append=False)).reshape(-1, 2)
            turns.append(edges[np.diff(edges)[:, 0] <= most])
            signs = np.clip(rates / (RAMP * size[turning]), -1.0, 1.0)
            yield _bridge(signs, turns[turning])
        for joint, torque in enumerate(given.torque.T):
            # A shared motor's turn is in the torques of all its joints.
            signal = _bridge(torque.copy(), turns[joint])
            for motor in np.flatnonzero(shared[:, joint]):
                signal = _bridge(signal, turns[joints + motor])
            yield signal

    asked, band = ((0, motion.rows), (1, motion.rows)), TORQUE_BAND * bandwidth
    values, slopes = _filter(bridge_turns(), len(times), given.step, band, motion.stride, asked)
    return [*np.split(values, [joints, count], axis=1), slopes[:, count:]]


def _bridge(signal: np.ndarray, turns: np.ndarray) -> np.ndarray:
    """A signal (rows,), changed in place where a turn is hidden: cubics through rows beside it.

    turns (turns, 2): first rows, and rows behind the last.
    """
    firsts, lengths = turns[:, 0], np.diff(turns)[:, 0]
    for length in np.unique(lengths):
        reach = max(CUBIC // 2, (length + 1) // 2)
        inner = np.arange(length)
        beside = np.concatenate([np.arange(-reach, 0), length + np.arange(reach)])
        powers = [np.vander(2 * each / length, CUBIC) for each in (inner, beside)]
        weights = powers[0] @ np.linalg.pinv(powers[1])
        begins = firsts[(lengths == length) & (firsts >= reach)]
        begins = begins[begins + length + reach <= len(signal)]
        signal[begins[:, None] + inner] = signal[begins[:, None] + beside] @ weights.T
    return signal


def _filter(
    signals: Iterable[np.ndarray],
    rows: int,
    step: float,
    bandwidth: float,
    stride: int,
    asked: Sequence[tuple[int, np.ndarray | slice]],
) -> list[np.ndarray]:
    """Derivatives of filtered signals (rows,), each of an order, at given ones of their strides.

    One signal after the other: all of a long recording's at once would take much memory.
    """
    columns = []
    pad = min(int(PADDED / (bandwidth * step)), rows - 1) // stride * stride
    whole = stride * next_fast_len(ceil((rows + 2 * pad) / stride), real=True)
    behind = min(whole - rows - pad, rows - 1)
    count = (rows + pad + behind) // stride
    frequency = rfftfreq(count, stride * step)
    turning = 2j * np.pi * frequency
    passed = 1 / (stride * (1 + (frequency / bandwidth) ** (2 * ORDER)))
    kept = slice(pad // stride, pad // stride + ceil(rows / stride))
    for signal in signals:
        long = continue_signal(signal, pad, behind)
        # Without the line from end to end, what the transform continues periodically has no step.
        slope = (long[-1] - long[0]) / (len(long) - 1)
        line = long[0] + slope * np.arange(len(long))
        spectrum = rfft(long - line)[: len(frequency)] * passed
        lines = line[::stride][kept], slope / step, 0.0
        derivatives = ((irfft(spectrum * turning**order, count), order, at) for order, at in asked)
        columns.append([(each[kept] + lines[order])[at] for each, order, at in derivatives])
    return [np.column_stack(parts) for parts in zip(*columns, strict=True)]

"""Signals of a recording at even times, and of a long one with fewer rows."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import chain
from math import ceil, log2
from typing import NamedTuple

import numpy as np
from scipy.signal import firwin, upfirdn

from crosscheck.recordings.record import Record

# Before every second row is left out, what is beyond a quarter of their rate is taken away: six
# digits of it, by a symmetric filter without phase.
TAPS, WINDOW = 33, ("kaiser", 12.3)
MOST_ROWS = 2**19  # rows that are kept: a longer recording is halved while it is read
EVEN = 1e-3  # share of a step: times so near to even ones count as even


class EvenSignals(NamedTuple):
    """Rows of position and torque (rows, n) so much time apart [s]."""

    step: float
    position: np.ndarray
    torque: np.ndarray


def space_signals(recording: Record, torque: np.ndarray) -> EvenSignals:
    """A recording's positions and a torque of it (rows, n) at even times, by lines between rows."""
    signals = recording.position, torque
    even = (next(space_pieces([each], recording.time)) for each in signals)
    return EvenSignals(recording.step, *even)


def condense(
    time: np.ndarray, pieces: Iterable[np.ndarray], count: int
) -> tuple[np.ndarray, np.ndarray]:
    """Times and rows (rows, count) of signals that come in pieces, no more rows than are kept.

    Rows of a long recording are at even times, and of single precision: 24 bits are more than
    encoders tell. No more than a piece is held at once beside what is kept.
    """
    halvings = max(ceil(log2(len(time) / MOST_ROWS)), 0)
    if halvings:
        pieces = space_pieces(pieces, time)
        time = np.linspace(time[0], time[-1], len(time))[:: 2**halvings]
    for _ in range(halvings):
        pieces = halve_pieces(pieces)
    kept = np.empty((len(time), count), dtype=np.float32 if halvings else float)
    done = 0
    for piece in pieces:
        kept[done : done + len(piece)] = piece
        done += len(piece)
    return time, kept


def halve_pieces(pieces: Iterable[np.ndarray]) -> Iterator[np.ndarray]:
    """Every second row of a signal, the first among them, low-passed before.

    It comes in pieces (rows, n), the first longer than the taps.
    """
    left = iter(pieces)
    first, pad = next(left), TAPS // 2
    taps = firwin(TAPS, 0.5, window=WINDOW)
    rest = 2 * first[0] - first[pad:0:-1]  # turned about the end, as behind the last piece
    for piece in chain([first], left, [None]):
        behind = 2 * rest[-1] - rest[-2 : -pad - 2 : -1] if piece is None else piece
        rest = np.concatenate([rest, behind])
        count = (len(rest) - 2 * pad + 1) // 2
        yield upfirdn(taps, rest, down=2, axis=0)[pad : pad + count]
        rest = rest[2 * count :]


def space_pieces(pieces: Iterable[np.ndarray], time: np.ndarray) -> Iterator[np.ndarray]:
    """Signals (rows, n) at even times by lines between rows, as they are where times are even."""
    even, step = np.linspace(time[0], time[-1], len(time), retstep=True)
    if np.abs(even - time).max() < EVEN * step:
        yield from pieces
        return
    kept: list[np.ndarray] = []  # the row before a piece, from which a line leads to it
    row = done = 0
    for piece in pieces:
        signals = np.concatenate([*kept, piece])
        times = time[row : row + len(signals)]
        until = int(np.searchsorted(even, times[-1], side="right"))
        yield np.column_stack([np.interp(even[done:until], times, each) for each in signals.T])
        kept, row, done = [piece[-1:]], row + len(signals) - 1, until


def continue_signal(signal: np.ndarray, before: int, behind: int) -> np.ndarray:
    """A signal (rows, n) with so many rows more at its ends: turned about them."""
    return np.concatenate(
        [
            2 * signal[0] - signal[before:0:-1],
            signal,
            2 * signal[-1] - signal[-2 : -behind - 2 : -1],
        ]
    )

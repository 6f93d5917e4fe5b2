"""Numbers that decide what a signal does: events, amplitudes, frequencies, settling.

All functions take plain arrays, time [s] of shape (times,) equally spaced, and return plain floats;
``None`` or nan where the event does not happen.
"""

from __future__ import annotations

import numpy as np


def window(time: np.ndarray, begin: float, end: float) -> slice:
    """Samples with begin <= t < end [s]."""
    return slice(int(np.searchsorted(time, begin)), int(np.searchsorted(time, end)))


def amplitude(values: np.ndarray) -> float:
    """Largest magnitude."""
    return float(np.abs(values).max())


def peak_to_peak(values: np.ndarray) -> float:
    """Largest minus smallest value."""
    return float(np.ptp(values))


def onset(time: np.ndarray, values: np.ndarray, fraction: float = 0.5) -> float | None:
    """First time [s] at which the magnitude reaches this fraction of its largest value."""
    size = np.abs(values)
    if size.max() == 0:
        return None
    return float(time[np.argmax(size >= fraction * size.max())])


def first_below(time: np.ndarray, values: np.ndarray, level: float) -> float | None:
    """First time [s] at which values fall below a level; None if they never do."""
    below = values < level
    return float(time[np.argmax(below)]) if below.any() else None


def first_above(time: np.ndarray, values: np.ndarray, level: float) -> float | None:
    """First time [s] at which values rise above a level; None if they never do."""
    return first_below(time, -values, -level)


def spectrum(time: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(frequency [Hz], single-sided amplitude) of the values less their mean, Hann window."""
    centred = values - values.mean()
    weights = np.hanning(values.size)
    amplitudes = 2 * np.abs(np.fft.rfft(centred * weights)) / weights.sum()
    return np.fft.rfftfreq(values.size, time[1] - time[0]), amplitudes


def dominant_frequency(time: np.ndarray, values: np.ndarray, above_hz: float = 100.0) -> float:
    """Frequency [Hz] of the largest line above ``above_hz``, refined by a parabola through it."""
    frequency, amplitudes = spectrum(time, values)
    first = int(np.searchsorted(frequency, above_hz))
    peak = first + int(np.argmax(amplitudes[first:]))
    if peak in (0, amplitudes.size - 1):
        return float(frequency[peak])
    left, middle, right = np.log(amplitudes[peak - 1 : peak + 2] + 1e-300)
    shift = 0.5 * (left - right) / (left - 2 * middle + right)
    return float(frequency[peak] + shift * frequency[1])


def settling_time(time: np.ndarray, values: np.ndarray, target: float, band: float) -> float | None:
    """Time [s] after which values stay within target +- band; None if they do not at the end."""
    outside = np.abs(values - target) > band
    if not outside.any():
        return float(time[0])
    last = int(np.flatnonzero(outside)[-1])
    return None if last + 1 >= time.size else float(time[last + 1])

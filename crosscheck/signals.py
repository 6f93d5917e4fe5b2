"""Numbers that decide what a signal does: events, amplitudes, frequencies; its envelope.

All functions take plain arrays, time [s] of shape (times,) equally spaced. Numbers are plain
floats: a time is None where the event does not happen, a size nan where there are no samples.
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np

SPECTRUM_SAMPLES = 4  # fewer leave nothing of a Hann window but its middle
VIBRATION_HZ = 100.0  # faster than any motion of an arm


def window(time: np.ndarray, begin: float, end: float) -> slice:
    """Slice of the samples with begin <= t < end [s]."""
    return slice(int(np.searchsorted(time, begin)), int(np.searchsorted(time, end)))


def amplitude(values: np.ndarray) -> float:
    """Largest magnitude of the values."""
    return float(np.abs(values).max()) if values.size else np.nan


def peak_to_peak(values: np.ndarray) -> float:
    """Largest minus smallest value."""
    return float(np.ptp(values)) if values.size else np.nan


def middle(values: np.ndarray) -> float:
    """Half way between the largest and the smallest value."""
    return float(values.max() + values.min()) / 2 if values.size else np.nan


def mean_value(values: np.ndarray) -> float:
    """Mean of all samples."""
    return float(values.mean()) if values.size else np.nan


def onset(time: np.ndarray, values: np.ndarray, fraction: float = 0.5) -> float | None:
    """First time [s] at which the magnitude reaches this fraction of its largest value."""
    size = np.abs(values)
    if size.max(initial=0.0) == 0:
        return None
    return float(time[np.argmax(size >= fraction * size.max())])


def crossing_time_below(time: np.ndarray, values: np.ndarray, level: float) -> float | None:
    """First time [s] at which values fall below a level; None if they never do."""
    below = values < level
    return float(time[np.argmax(below)]) if below.any() else None


def crossing_time_above(time: np.ndarray, values: np.ndarray, level: float) -> float | None:
    """First time [s] at which values rise above a level; None if they never do."""
    return crossing_time_below(time, -values, -level)


def spectrum(time: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(frequency [Hz], single-sided amplitude) of the values less their mean, Hann window.

    Both arrays are empty if there are too few samples for one frequency.
    """
    if values.size < SPECTRUM_SAMPLES:
        return np.empty(0), np.empty(0)
    centred = values - values.mean()
    weights = _hann(values.size)
    amplitudes = 2 * np.abs(np.fft.rfft(centred * weights)) / weights.sum()
    return np.fft.rfftfreq(values.size, time[1] - time[0]), amplitudes


@lru_cache(maxsize=8)
def _hann(samples: int) -> np.ndarray:
    """A Hann window (samples,), not to be written to."""
    weights = np.hanning(samples)
    weights.flags.writeable = False
    return weights


class SpectralLine(NamedTuple):
    """A line of a spectrum: frequency [Hz], and single-sided amplitude as the signal's unit."""

    frequency_Hz: float
    amplitude: float


def largest_line(
    time: np.ndarray, values: np.ndarray, above_hz: float, below_hz: float = np.inf
) -> SpectralLine:
    """The largest line from ``above_hz`` on, below ``below_hz``, refined by a parabola through it.

    Frequency and amplitude are nan if there is none.
    """
    frequency, amplitudes = spectrum(time, values)
    band = window(frequency, above_hz, below_hz)
    if amplitudes[band].max(initial=0.0) == 0:
        return SpectralLine(np.nan, np.nan)
    peak = band.start + int(np.argmax(amplitudes[band]))
    size = float(amplitudes[peak])
    if peak in (0, amplitudes.size - 1):
        return SpectralLine(float(frequency[peak]), size)
    left, middle, right = np.log(amplitudes[peak - 1 : peak + 2] + 1e-300)
    shift = 0.5 * (left - right) / (left - 2 * middle + right)
    return SpectralLine(float(frequency[peak] + shift * frequency[1]), size)


def dominant_frequency(
    time: np.ndarray, values: np.ndarray, above_hz: float = VIBRATION_HZ
) -> float:
    """Frequency [Hz] of the largest line above ``above_hz``; nan if there is none."""
    return largest_line(time, values, above_hz).frequency_Hz


def band_rms(time: np.ndarray, values: np.ndarray, above_hz: float, below_hz: float) -> float:
    """Root mean square of what a signal has from one frequency to below another.

    It is taken from the power of a Hann window, so that a steady sine of amplitude A inside gives
    A / sqrt(2); nan where there are too few samples for one frequency.
    """
    frequency, amplitudes = spectrum(time, values)
    if not frequency.size:
        return np.nan
    weights = _hann(values.size)
    lines = amplitudes[window(frequency, above_hz, below_hz)]
    # A line's power is spread over as many as the window is wide, in bins.
    wide = values.size * np.square(weights).sum() / weights.sum() ** 2
    return float(np.sqrt(np.square(lines).sum() / (2 * wide)))


def envelope(
    time: np.ndarray, values: np.ndarray, bins: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(bin centres, minima, maxima) of values (times,) in equal bins of consecutive samples.

    A fast signal is so drawn honestly: by the smallest and largest value in every bin.
    """
    edges = np.linspace(0, time.size, min(bins, time.size) + 1).astype(int)[:-1]
    low, high = np.minimum.reduceat(values, edges), np.maximum.reduceat(values, edges)
    ends = np.append(edges[1:], time.size) - 1
    return (time[edges] + time[ends]) / 2, low, high

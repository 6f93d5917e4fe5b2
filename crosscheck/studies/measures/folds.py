"""Numbers of signals, gathered piece by piece for many members at once.

A fold takes pieces of a signal, time (records,) [s] and values (records, *columns), and ends with
one or two numbers for every column. Except for spectra it keeps no past samples. The numbers are
defined as in ``crosscheck.signals`` for a whole signal; nan means that the event did not happen, or
that there was no sample.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import ClassVar

import numpy as np

Numbers = tuple[np.ndarray, ...]


class Fold(ABC):
    """A number, or two, of every column of a signal, gathered piece by piece.

    parts: suffixes of its numbers' names; ends: whether the last record alone counts.
    """

    parts: tuple[str, ...] = ("",)
    ends: ClassVar[bool] = False

    @abstractmethod
    def take(self, time: np.ndarray, values: np.ndarray) -> None:
        """Take in the next piece of the signal, not empty."""

    @abstractmethod
    def numbers(self) -> Numbers:
        """The numbers of all columns, each of shape (*columns,)."""


class RangeFold(Fold):
    """Fold for the largest minus the smallest value."""

    def __init__(self, columns: tuple[int, ...]) -> None:
        self.high, self.low = np.full(columns, -np.inf), np.full(columns, np.inf)

    def take(self, time: np.ndarray, values: np.ndarray) -> None:
        np.maximum(self.high, values.max(axis=0), out=self.high)
        np.minimum(self.low, values.min(axis=0), out=self.low)

    def numbers(self) -> Numbers:
        size = self.size()
        return (np.where(np.isfinite(size), size, np.nan),)

    def size(self) -> np.ndarray:
        """What is made of both, not finite without a sample."""
        return self.high - self.low


class PeakFold(RangeFold):
    """Fold for the largest magnitude."""

    def size(self) -> np.ndarray:
        return np.maximum(self.high, -self.low)


class AverageFold(Fold):
    """Fold for the mean, or the root mean square."""

    def __init__(self, columns: tuple[int, ...], squared: bool) -> None:
        self.squared = squared
        self.total, self.count = np.zeros(columns), 0

    def take(self, time: np.ndarray, values: np.ndarray) -> None:
        self.total += (np.square(values) if self.squared else values).sum(axis=0)
        self.count += time.size

    def numbers(self) -> Numbers:
        mean = self.total / self.count if self.count else np.full_like(self.total, np.nan)
        return (np.sqrt(mean) if self.squared else mean,)


class LastFold(Fold):
    """Fold for the last value less a target, one for all or (*columns,)."""

    ends = True

    def __init__(self, columns: tuple[int, ...], target: np.ndarray | float = 0.0) -> None:
        self.target, self.value = target, np.full(columns, np.nan)

    def take(self, time: np.ndarray, values: np.ndarray) -> None:
        self.value = values[-1].copy()

    def numbers(self) -> Numbers:
        return (self.value - self.target,)


class FirstTimeFold(Fold):
    """Fold for the time of the first record that meets a condition."""

    def __init__(
        self, columns: tuple[int, ...], condition: Callable[[np.ndarray], np.ndarray]
    ) -> None:
        self.condition, self.time = condition, np.full(columns, np.nan)

    def take(self, time: np.ndarray, values: np.ndarray) -> None:
        is_met = self.condition(values)
        new = np.isnan(self.time) & is_met.any(axis=0)
        self.time[new] = time[is_met.argmax(axis=0)][new]

    def numbers(self) -> Numbers:
        return (self.time,)


class FirstLossFold(FirstTimeFold):
    """Fold for the time of the first record without a force after one with it."""

    def __init__(self, columns: tuple[int, ...]) -> None:
        super().__init__(columns, self._contact_losses)
        self.carried = np.zeros(columns, dtype=bool)

    def _contact_losses(self, values: np.ndarray) -> np.ndarray:
        before = np.logical_or.accumulate(np.concatenate([[self.carried], values != 0]), axis=0)
        self.carried = before[-1]
        return before[:-1] & (values == 0)


class NoContactShareFold(AverageFold):
    """Fold for the share of the records without a force; nan of a joint that has no such mesh."""

    def __init__(self, columns: tuple[int, ...]) -> None:
        super().__init__(columns, squared=False)

    def take(self, time: np.ndarray, values: np.ndarray) -> None:
        super().take(time, np.where(np.isnan(values), np.nan, values == 0))


class SettlingFold(Fold):
    """Fold for the time after which values stay within a band about their targets, (*columns,)."""

    def __init__(self, target: np.ndarray, band: float) -> None:
        self.target, self.band = target, band
        self.since = np.full(target.shape, np.nan)
        self.inside = np.zeros(target.shape, dtype=bool)  # at the last record seen

    def take(self, time: np.ndarray, values: np.ndarray) -> None:
        outside = ~(np.abs(values - self.target) <= self.band)
        left = outside.any(axis=0)
        # The record after the last one outside; past the end, it comes with the next piece.
        after = time.size - outside[::-1].argmax(axis=0)
        back = left & (after < time.size)
        self.since[back] = time[np.minimum(after, time.size - 1)][back]
        entered = ~left & ~self.inside
        self.since[entered] = time[0]
        self.inside = ~outside[-1]

    def numbers(self) -> Numbers:
        return (np.where(self.inside, self.since, np.nan),)


class SpectrumFold(Fold):
    """Fold that needs the whole signal: it is kept, until the numbers are asked for.

    measure: numbers of one column, from times, its whole signal (records,) and a band; parts:
    suffixes of their names.
    """

    def __init__(
        self,
        columns: tuple[int, ...],
        measure: Callable[..., float | tuple[float, ...]],
        band: tuple[float, float],
        parts: tuple[str, ...] = ("",),
    ) -> None:
        self.columns, self.measure, self.band, self.parts = columns, measure, band, parts
        self.time: list[np.ndarray] = []
        self.values: list[np.ndarray] = []

    def take(self, time: np.ndarray, values: np.ndarray) -> None:
        self.time.append(time.copy())
        self.values.append(values.reshape(time.size, -1).copy())  # the kernel's to reuse

    def numbers(self) -> Numbers:
        found = np.full((len(self.parts), int(np.prod(self.columns))), np.nan)
        if self.time:
            time, values = np.concatenate(self.time), np.concatenate(self.values)
            for column, signal in enumerate(values.T):
                if np.isfinite(signal).all():
                    whole = np.ascontiguousarray(signal)
                    found[:, column] = self.measure(time, whole, *self.band)
        return tuple(row.reshape(self.columns) for row in found)

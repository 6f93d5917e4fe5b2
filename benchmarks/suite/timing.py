"""Repeated runs in turn (ABAB ...), so that what else the machine does falls on all alike."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Mapping
from statistics import median
from typing import NamedTuple


class Times(NamedTuple):
    """Of every repeat [s]."""

    seconds: tuple[float, ...]

    @property
    def median(self) -> float:
        """[s]"""
        return median(self.seconds)

    @property
    def spread(self) -> float:
        """Largest less least over the median."""
        return (max(self.seconds) - min(self.seconds)) / self.median

    def median_ratio(self, other: Times) -> float:
        """Median of the ratios, repeat by repeat."""
        pairs = zip(self.seconds, other.seconds, strict=True)
        return median(seconds / others for seconds, others in pairs)


def print_progress(what: str) -> None:
    """A line for whoever waits."""
    print(f"  {what}", file=sys.stderr, flush=True)


def wall_s() -> float:
    """Of the clock [s]: what a user waits for."""
    return time.perf_counter()


def processor_s() -> float:
    """Of this process alone, all its threads [s]: for what one core does, whoever else wants it."""
    return time.process_time()


def measure_seconds(run: Callable[[], object], clock: Callable[[], float] = wall_s) -> float:
    """Time [s] of one call."""
    began = clock()
    run()
    return clock() - began


def run_in_turn(
    runs: Mapping[str, Callable[[], object]], repeats: int, clock: Callable[[], float] = wall_s
) -> dict[str, Times]:
    """Each run once unmeasured, then all of them in turn, `repeats` times."""
    for run in runs.values():
        run()
    rounds = [
        {name: measure_seconds(run, clock) for name, run in runs.items()} for _ in range(repeats)
    ]
    return {name: Times(tuple(each[name] for each in rounds)) for name in runs}


def divide_times(times: Mapping[str, Times], units: Mapping[str, int]) -> dict[str, Times]:
    """The times of one step, or of one trajectory, where a run takes so many."""
    return {
        name: Times(tuple(seconds / units[name] for seconds in run_times.seconds))
        for name, run_times in times.items()
    }

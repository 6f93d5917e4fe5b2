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

    def over(self, other: Times) -> float:
        """Median of the ratios, repeat by repeat."""
        pairs = zip(self.seconds, other.seconds, strict=True)
        return median(own / others for own, others in pairs)


def progress(what: str) -> None:
    """A line for whoever waits."""
    print(f"  {what}", file=sys.stderr, flush=True)


def wall() -> float:
    """Of the clock [s]: what a user waits for."""
    return time.perf_counter()


def processor() -> float:
    """Of this process alone, all its threads [s]: for what one core does, whoever else wants it."""
    return time.process_time()


def seconds_of(run: Callable[[], object], clock: Callable[[], float] = wall) -> float:
    """Time [s] of one call."""
    began = clock()
    run()
    return clock() - began


def in_turn(
    runs: Mapping[str, Callable[[], object]], repeats: int, clock: Callable[[], float] = wall
) -> dict[str, Times]:
    """Each run once unmeasured, then all of them in turn, `repeats` times."""
    for run in runs.values():
        run()
    rounds = [{name: seconds_of(run, clock) for name, run in runs.items()} for _ in range(repeats)]
    return {name: Times(tuple(each[name] for each in rounds)) for name in runs}


def per_unit(times: Mapping[str, Times], units: Mapping[str, int]) -> dict[str, Times]:
    """The times of one step, or of one trajectory, where a run takes so many."""
    return {
        name: Times(tuple(seconds / units[name] for seconds in found.seconds))
        for name, found in times.items()
    }

"""The classical Runge-Kutta method, for models whose engine has none."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TypeVar

import numpy as np

from crosscheck.models.experiment.scenario import Scenario

Given = TypeVar("Given")


def integrate_steps(
    acceleration: Callable[[Given, np.ndarray, np.ndarray], np.ndarray],
    given: Callable[[int], tuple[Given, Given, Given]],
    q: np.ndarray,
    v: np.ndarray,
    h: float,
) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """q and v after each step h [s] of the classical Runge-Kutta method, of fourth order, forever.

    given: what the acceleration is a function of beside q and v, at beginning, middle and end of a
    step, counted from 0.
    """
    number = 0
    while True:
        begin, middle, end = given(number)
        a1 = acceleration(begin, q, v)
        v2 = v + h / 2 * a1
        a2 = acceleration(middle, q + h / 2 * v, v2)
        v3 = v + h / 2 * a2
        a3 = acceleration(middle, q + h / 2 * v2, v3)
        v4 = v + h * a3
        a4 = acceleration(end, q + h * v3, v4)
        q, v = q + h / 6 * (v + 2 * v2 + 2 * v3 + v4), v + h / 6 * (a1 + 2 * a2 + 2 * a3 + a4)
        yield q, v
        number += 1


def integrate_scenario(
    acceleration: Callable[[float, np.ndarray, np.ndarray], np.ndarray],
    start: tuple[np.ndarray, np.ndarray],
    scenario: Scenario,
) -> tuple[np.ndarray, np.ndarray]:
    """q and v (records, n) of a scenario's run by its fixed steps, from a start.

    acceleration: of time [s], q and v. From a record on that is not finite, all are NaN.
    """
    h, records = scenario.step_s, scenario.steps // scenario.stride + 1
    qs, vs = np.full((2, records, start[0].size), np.nan)
    qs[0], vs[0] = start

    def stage_times(number: int) -> tuple[float, float, float]:
        t = number * h
        return t, t + h / 2, t + h

    steps = integrate_steps(acceleration, stage_times, *start, h)
    for number, (q, v) in zip(range(1, scenario.steps + 1), steps, strict=False):
        if number % scenario.stride == 0:
            if not (np.isfinite(q).all() and np.isfinite(v).all()):
                break
            qs[number // scenario.stride], vs[number // scenario.stride] = q, v
    return qs, vs

"""Random states of an arm in a user's coordinates, with a scenario's torques."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from crosscheck.checks.answers import random_states
from crosscheck.checks.invariants import torques_at
from crosscheck.models.arm.arm import Arm
from crosscheck.models.errors import InputError
from crosscheck.models.experiment.drive import drive_data
from crosscheck.models.experiment.scenario import Scenario
from crosscheck.trial.coordinates.frame import Frame

FIRST = 20  # poses that a map may not reach, before it is one that reaches none


class UserState(NamedTuple):
    """t [s]; x, u (n,), the user's coordinates and rates; q, v (n,), the project's.

    torque (joints,): output torques [N m] of the scenario's drive.
    """

    t: float
    x: np.ndarray
    u: np.ndarray
    q: np.ndarray
    v: np.ndarray
    torque: np.ndarray


@lru_cache(maxsize=8)  # every question of a trial asks at the same ones
def states_of(
    frame: Frame, arm: Arm, scenario: Scenario, count: int, seed: int
) -> tuple[UserState, ...]:
    """States on both flanks of the teeth, at any pose, moving briskly.

    A pose that no x gives is moved towards one that some x gives. Raises InputError.
    """
    return tuple(_states(frame, arm, scenario, count, seed))


def _states(
    frame: Frame, arm: Arm, scenario: Scenario, count: int, seed: int
) -> Iterator[UserState]:
    drive, theta = drive_data(scenario, len(arm.joints)), frame.layout.theta
    drawn = random_states(frame.layout, arm, count, seed)
    for t, x, v in zip(drawn.t, _places(frame, drawn.q), drawn.v, strict=True):
        q = frame.position(x)
        u = np.linalg.solve(frame.jacobian(x), v)
        torque = torques_at(drive, float(t), q[theta], v[theta])
        yield UserState(float(t), x, u, q, v, torque)


def _places(frame: Frame, drawn: np.ndarray) -> Iterator[np.ndarray]:
    """x of each q (count, n). Raises InputError where no x gives any of the first ones."""
    if frame.matrix is not None:
        yield from map(frame.place, drawn)
        return
    known = None
    for q in drawn[:FIRST]:
        with suppress(InputError):
            known = frame.place(q)
            break
    known = frame.place(drawn[0]) if known is None else known
    for q in drawn:
        yield frame.nearest(q, known)

"""Random states of an arm, in a user's coordinates and in the project's."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import suppress
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from crosscheck.checks.answers import States, sample_states
from crosscheck.checks.corners import sample_corner_states
from crosscheck.models.errors import InputError
from crosscheck.models.experiment.drive import drive_data, torques_at
from crosscheck.models.loading import Case
from crosscheck.trial.coordinates.frame import Frame

FIRST = 20  # poses that a map may not reach, before it is one that reaches none


class UserState(NamedTuple):
    """A state of the arm in the user's coordinates and in the project's.

    t [s]; x, u (n,), the user's coordinates and rates; q, v (n,), the project's; torque (joints,):
    output torques [N m] of the scenario's drive. Of several states each has these along a first
    axis.
    """

    t: Any
    x: np.ndarray
    u: np.ndarray
    q: np.ndarray
    v: np.ndarray
    torque: np.ndarray


def stack_states(states: Sequence[UserState]) -> UserState:
    """Several states as one of arrays."""
    return UserState(*map(np.array, zip(*states, strict=True)))


@lru_cache(maxsize=8)  # every question of a trial asks at the same ones
def draw_states(frame: Frame, case: Case, count: int, seed: int) -> tuple[UserState, ...]:
    """Random states on both flanks of the teeth, at any pose, moving briskly; then all corners.

    These are on each side of every branch of the mesh laws. A pose that no x gives is shifted
    towards one that some x gives. Raises InputError.
    """
    arm, theta = case.arm, frame.layout.theta
    drive = drive_data(case.scenario, len(arm.joints))
    random = sample_states(frame.layout, arm, count, seed)
    corners = sample_corner_states(frame.layout, arm, case.switches, seed)
    drawn, states = States(*map(np.concatenate, zip(random, corners, strict=True))), []
    for t, x, v in zip(drawn.t.tolist(), find_coordinates(frame, drawn.q), drawn.v, strict=True):
        q = frame.position(x)
        u = np.linalg.solve(frame.jacobian(x), v)
        states.append(UserState(t, x, u, q, v, torques_at(drive, t, q[theta], v[theta])))
    return tuple(states)


def find_coordinates(frame: Frame, drawn: np.ndarray) -> Iterator[np.ndarray]:
    """An x for each q (count, n). Raises InputError where no x gives any of the first ones."""
    if frame.matrix is not None:
        yield from map(frame.place, drawn)
        return
    reachable_x = None
    for q in drawn[:FIRST]:
        with suppress(InputError):
            reachable_x = frame.place(q)
            break
    reachable_x = frame.place(drawn[0]) if reachable_x is None else reachable_x
    for q in drawn:
        yield frame.find_nearest(q, reachable_x)

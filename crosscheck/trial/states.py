"""Random states of an arm in a user's coordinates, with a scenario's torques."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from crosscheck.checks.answers import random_states
from crosscheck.checks.invariants import torques_at
from crosscheck.trial.frame import Frame
from models.arm import Arm
from models.drive import drive_data
from models.scenario import Scenario


class State(NamedTuple):
    """t [s]; x, u (n,), the user's coordinates and rates; q, v (n,), the project's.

    torque (joints,): output torques [N m] of the scenario's drive.
    """

    t: float
    x: np.ndarray
    u: np.ndarray
    q: np.ndarray
    v: np.ndarray
    torque: np.ndarray


def states_of(frame: Frame, arm: Arm, scenario: Scenario, count: int, seed: int) -> list[State]:
    """States on both flanks of the teeth, at any pose, moving briskly. Raises InputError."""
    return list(_states(frame, arm, scenario, count, seed))


def _states(frame: Frame, arm: Arm, scenario: Scenario, count: int, seed: int) -> Iterator[State]:
    drive, theta = drive_data(scenario, len(arm.joints)), frame.layout.theta
    for t, drawn, v in zip(*random_states(frame.layout, arm, count, seed), strict=True):
        x = frame.place(drawn)
        q = frame.position(x)
        u = np.linalg.solve(frame.jacobian(x), v)
        torque = torques_at(drive, float(t), q[theta], v[theta])
        yield State(float(t), x, u, q, v, torque)

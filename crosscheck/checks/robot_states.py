"""Random states of a robot, at which its models answer."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from crosscheck.models.robot.robot import Robot


class RandomStates(NamedTuple):
    """Random states: coordinates, rates, accelerations (states, n), torques (states, free)."""

    q: np.ndarray
    v: np.ndarray
    a: np.ndarray
    torques: np.ndarray

    def first(self, count: int) -> RandomStates:
        """The first of the states."""
        return RandomStates(*(each[:count] for each in self))


def sample_states(robot: Robot, count: int, seed: int) -> RandomStates:
    """Random states of a robot, `count` of them.

    Coordinates are within their limits and at most +-pi or 1 m about the middle of these, rates
    within theirs and at most 2 rad/s or m/s.
    """
    rng = np.random.default_rng(seed)
    shape = (count, len(robot.coordinates))
    ranges = np.array([motion_range(robot, number) for number in robot.coordinates])
    most = [min(robot.joints[number].limits.velocity, 2.0) for number in robot.coordinates]
    q = rng.uniform(ranges[:, 0], ranges[:, 1], shape)
    v = rng.uniform(-1, 1, shape) * most
    return RandomStates(q, v, rng.uniform(-5, 5, shape), rng.uniform(-10, 10, shape))


def motion_range(robot: Robot, number: int) -> tuple[float, float]:
    """The range of a joint's coordinate: its limits, at most +-pi or 1 m about their middle."""
    joint = robot.joints[number]
    half = np.pi if joint.kind == "revolute" else 1.0
    lower, upper = joint.limits.lower, joint.limits.upper
    if not np.isfinite([lower, upper]).all():
        middle = min(max(0.0, lower + half), upper - half)
        return middle - half, middle + half
    middle, half = (lower + upper) / 2, min(half, (upper - lower) / 2)
    return middle - half, middle + half

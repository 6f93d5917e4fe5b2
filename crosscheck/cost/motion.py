"""The motion along which costs are measured: a seeded sum of sines within a robot's limits."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from crosscheck.cost.agreement import motion_range
from crosscheck.models.robot.interface import RobotModel

HARMONICS = 5
PERIOD = 4.0  # [s], unless efforts ask for a longer one
SWEPT = 0.8  # of each joint's range at most
RATE = 1.0  # [rad/s] or [m/s] of a joint without a velocity limit
GRID = 2000  # instants in a period at which limits are kept


@dataclass(frozen=True)
class Motion:
    """Of period [s]; sines of joint and harmonic: sizes, phases (n, harmonics) about middle (n,).

    limited_by: the joint whose effort limit asks for the period; none if empty.
    """

    period: float
    middle: np.ndarray
    sizes: np.ndarray
    phases: np.ndarray
    limited_by: str

    def at(self, time: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Coordinates, rates and accelerations at times [s], each (times, n)."""
        rates = 2 * np.pi * np.arange(1, HARMONICS + 1) / self.period
        angles = rates * time[:, None, None] + self.phases
        sines, cosines = self.sizes * np.sin(angles), self.sizes * np.cos(angles)
        return (
            self.middle + sines.sum(axis=2),
            (rates * cosines).sum(axis=2),
            -(rates**2 * sines).sum(axis=2),
        )


def excitation(model: RobotModel, seed: int) -> Motion:
    """Within limits of position, rate and effort; model: whose torques those are."""
    robot = model.robot
    rng = np.random.default_rng(seed)
    ranges = np.array([motion_range(robot, number) for number in robot.coordinates])
    limits = [robot.joints[number].limits for number in robot.coordinates]
    fastest = np.array([each.velocity if np.isfinite(each.velocity) else RATE for each in limits])
    shape = (len(ranges), HARMONICS)
    sizes = rng.uniform(0.3, 1, shape) / np.arange(1, HARMONICS + 1)
    drawn = Motion(PERIOD, np.zeros(len(ranges)), sizes, rng.uniform(0, 2 * np.pi, shape), "")
    time = PERIOD * np.arange(GRID) / GRID
    q, v, _ = drawn.at(time)
    lowest, highest = q.min(axis=0), q.max(axis=0)
    swept = SWEPT * (ranges[:, 1] - ranges[:, 0]) / (highest - lowest)
    factor = np.minimum(swept, fastest / np.abs(v).max(axis=0))
    middle = ranges.mean(axis=1) - factor * (lowest + highest) / 2
    chosen = Motion(PERIOD, middle, sizes * factor[:, None], drawn.phases, "")
    slower, limited_by = _slower(model, chosen.at(time))
    return replace(chosen, period=PERIOD * slower, limited_by=limited_by)


def _slower(
    model: RobotModel, motion: tuple[np.ndarray, np.ndarray, np.ndarray]
) -> tuple[float, str]:
    """How much longer the period has to be for the effort limits, and of which joint.

    In a period longer by a factor torques are those of the weight and 1 / factor^2 of the rest.
    """
    q, v, a = motion
    weight = model.gravity(q)
    rest = model.inverse_dynamics(q, v, a) - weight
    longest, limited_by = 1.0, ""
    for column, number in enumerate(model.robot.coordinates):
        joint, held, more = model.robot.joints[number], weight[:, column], rest[:, column]
        effort = joint.limits.effort
        if np.isfinite(effort) and (np.abs(held) < effort).all():
            needed = np.abs(more) / (effort - np.sign(more) * held)
            factor = float(np.sqrt(needed.max()))
            if factor > longest:
                longest, limited_by = factor, joint.name
    return longest, limited_by


def too_heavy(model: RobotModel, motion: Motion) -> list[str]:
    """Joints that cannot hold their weight along the motion within their effort limit."""
    time = motion.period * np.arange(GRID) / GRID
    most = np.abs(model.gravity(motion.at(time)[0])).max(axis=0)
    joints = [model.robot.joints[number] for number in model.robot.coordinates]
    return [
        joint.name for joint, load in zip(joints, most, strict=True) if load >= joint.limits.effort
    ]

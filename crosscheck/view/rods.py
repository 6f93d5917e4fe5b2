"""A robot as rods: where joints stand on each body, and where the ground is."""

from __future__ import annotations

import numpy as np

from crosscheck.models.robot.robot import BASE, Robot


def find_rod_ends(robot: Robot) -> dict[int, list[np.ndarray]]:
    """Positions of joints and of the tip on every body and the ground, in its frame."""
    ends: dict[int, list[np.ndarray]] = {number: [] for number in range(BASE, len(robot.joints))}
    for joint in robot.joints:
        ends[joint.parent].append(joint.placement.position)
    tip = robot.frames[robot.tip]
    ends[tip.body].append(tip.placement.position)
    return ends


def find_upward(robot: Robot) -> np.ndarray:
    """The direction (3,) against gravity in the base's frame, z where there is none."""
    size = np.linalg.norm(robot.gravity)
    return 0.0 - robot.gravity / size if size else np.array([0.0, 0.0, 1.0])

"""Scene of a robot's run: links as rods between joints, and joint angles over time."""

from __future__ import annotations

from typing import Any

import numpy as np

from crosscheck.models.robot.robot import BASE
from crosscheck.view.rods import find_rod_ends, find_upward
from crosscheck.view.scene import encode_numbers
from crosscheck.view.trajectory_file import Run


def describe_robot_scene(run: Run) -> dict[str, Any]:
    """What of the data for the page's script is a robot's own."""
    theta, robot = run.signals["theta"], run.mechanism
    ends = find_rod_ends(robot)
    lengths = [max(np.linalg.norm(end) for end in each) for each in ends.values() if each]
    slides = [joint.kind == "prismatic" for joint in robot.joints]
    slid = np.abs(theta[:, slides]).max(axis=0)
    return {
        "described": f"The whole robot: {len(robot.joints)} joints, {len(robot.rotors)} rotors",
        "drawn": "The robot, its links as rods and its joints in motion. ",
        "payload": False,
        "teeth": True,
        "reach": float(sum(lengths, 0.0) + slid.sum()) or 1.0,
        "ground": _points(ends[BASE]),
        "up": find_upward(robot).tolist(),
        "joints": [
            {
                "kind": joint.kind,
                "name": joint.name,
                "parent": joint.parent,
                "rotation": joint.placement.rotation.tolist(),
                "position": joint.placement.position.tolist(),
                "axis": joint.axis.tolist(),
                "ends": _points(ends[number]),
                "theta": encode_numbers(theta[:, number]),
            }
            for number, joint in enumerate(robot.joints)
        ],
    }


def _points(ends: list[np.ndarray]) -> list[list[float]]:
    return [end.round(9).tolist() for end in ends if np.linalg.norm(end) > 0]

"""Scene of a robot's run: links as rods between joints, and joint angles over time."""

from __future__ import annotations

from typing import Any

import numpy as np

from crosscheck.models.robot.robot import BASE
from crosscheck.view.rods import find_rod_ends, find_upward
from crosscheck.view.scene import MOST_FRAMES, encode_numbers
from crosscheck.view.trajectory_file import RobotRun


def build_robot_scene(run: RobotRun) -> dict[str, Any]:
    """Data for the page's script: lengths in m, angles in rad, numbers as base64 of float32."""
    every = -(-run.time.size // MOST_FRAMES)
    time, theta, robot = run.time[::every], run.theta[::every], run.robot
    ends = find_rod_ends(robot)
    lengths = [max(np.linalg.norm(end) for end in each) for each in ends.values() if each]
    slides = [joint.kind == "prismatic" for joint in robot.joints]
    slid = np.abs(theta[:, slides]).max(axis=0)
    whole, moving = "The whole robot", "its links as rods and its joints in motion"
    return {
        "name": robot.name,
        "model": run.model,
        "described": f"{whole}: {len(robot.joints)} joints, {len(robot.rotors)} rotors",
        "drawn": f"The robot, {moving}. ",
        "frames": time.size,
        "every": every,
        "start_s": float(time[0]),
        "step_s": float(time[1] - time[0]),
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

"""Trials of a robot's equations, without a command line."""

from typing import Any

from crosscheck.models.robot.robot import Robot
from crosscheck.trial.input.equations import Equations
from crosscheck.trial.request import TrialRequest
from crosscheck.trial.robots import trial


def run_robot_trial(
    equations: Equations, robot: Robot, *, name: str = "yours", **asked: Any
) -> trial.RobotTrial:
    """The trial of equations of a robot."""
    return trial.run_robot_trial(TrialRequest(name, equations, robot, **asked))

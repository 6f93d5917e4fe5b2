"""Trials of a robot's equations, without a command line."""

from typing import Any

from crosscheck.models.robot.robot import Robot
from crosscheck.trial.input.equations import Equations
from crosscheck.trial.request import TrialRequest
from crosscheck.trial.result import Trial
from crosscheck.trial.trial import run_trial


def run_robot_trial(equations: Equations, robot: Robot, **more: Any) -> Trial:
    """The trial of equations of a robot."""
    given = {"name": "yours", "equations": equations, "mechanism": robot, **more}
    return run_trial(TrialRequest(**given))

"""Trials of a robot's equations, without a command line."""

from typing import Any

from crosscheck.models.robot.robot import Level, Robot
from crosscheck.registry import build_robot_model
from crosscheck.trial.input.equations import Equations
from crosscheck.trial.request import TrialRequest
from crosscheck.trial.result import Trial
from crosscheck.trial.trial import run_trial


def run_robot_trial(equations: Equations, robot: Robot, **more: Any) -> Trial:
    """The trial of equations of a robot."""
    given = {"name": "yours", "equations": equations, "mechanism": robot, **more}
    return run_trial(TrialRequest(**given))


def robot_equations(own: Robot, level: Level = "coupled", engine: str = "analytic") -> Equations:
    """A robot's equations by any engine, one state at a time."""
    model = build_robot_model(engine, own, level)
    return Equations(
        mass_matrix=lambda q: model.mass_matrix(q[None])[0],
        bias=lambda q, v: model.bias(q[None], v[None])[0],
        gravity=lambda q: model.gravity(q[None])[0],
    )

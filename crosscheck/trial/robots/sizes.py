"""How large each entry of a robot's equations is by nature, at each rigid level."""

from __future__ import annotations

from crosscheck.analytic.robot.model import AnalyticRobot
from crosscheck.checks.robot_states import RandomStates, RobotSizes, compute_sizes
from crosscheck.models.errors import InputError
from crosscheck.models.robot.integration import conditioning_error
from crosscheck.models.robot.robot import RIGID, Level, Robot

EARTH = 10.0  # m/s^2, of robots that stand in space


def compute_sizes_by_level(
    robot: Robot, stated: str, states: RandomStates
) -> dict[Level, RobotSizes]:
    """The sizes at each rigid level.

    Levels whose mass matrix is singular are left out. Raises InputError where none remains, or
    where the one that equations state is one of them.
    """
    sizes: dict[Level, RobotSizes] = {}
    for level in RIGID:
        try:
            mass = AnalyticRobot(robot, level).mass_matrix(states.q)
            sizes[level] = compute_sizes(robot, mass, states, least_gravity=EARTH)
        except InputError:
            if level == stated:
                raise
    if not sizes:
        raise conditioning_error(robot)
    return sizes

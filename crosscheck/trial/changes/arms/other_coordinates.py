"""Equations of an arm that are right in other coordinates than those that they state."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from crosscheck.checks.robot_states import RandomStates
from crosscheck.models.arm.arm import Planetary
from crosscheck.models.robot.planar import build_level_robots
from crosscheck.models.robot.robot import Level, Robot
from crosscheck.trial.arms.questions import VerificationProblem
from crosscheck.trial.coordinates.readings import (
    Reading,
    linear_reading,
    list_readings,
    select_first_kind,
)

if TYPE_CHECKING:
    from crosscheck.trial.robots.judge import RobotProblem

STATES = 8  # number of states at which models are evaluated in other coordinates


def find_readings(
    problem: VerificationProblem, user_values: Mapping[str, np.ndarray]
) -> tuple[str, list[Reading]]:
    """The level and the readings in which all parts agree, the simplest ones alone; "" for none.

    user_values: of mass_matrix, bias, gravity, force and acceleration, those that answer.
    """
    arm, matrix = problem.case.arm, problem.frame.matrix
    if problem.gearing != "rigid" or matrix is None or not user_values:
        return "", []
    # A tenth of a second, for equations that are wrong.
    from crosscheck.trial.robots.readings import describe_coordinates, select_readings

    robots = build_level_robots(arm)

    def select(robot: Robot, level: Level, readings: Sequence[Reading]) -> list[Reading]:
        robot_problem = _build_robot_problem(problem, user_values, robot, level)
        return select_readings(robot_problem, level, readings)

    size = len(arm.joints)
    ratios = [
        1 + joint.ring_teeth / joint.sun_teeth if isinstance(joint, Planetary) else 1.0
        for joint in arm.joints
    ]
    joints = describe_coordinates(robots["links"][0])
    names = [f"theta_{number + 1}" for number in range(size)]
    joints = replace(joints, names=names, ratios=np.array(ratios))
    relative = linear_reading("relative", "relative angles", np.eye(size))
    simple = [relative, *list_readings(joints)]
    stated, others = list[Reading](), list[Reading]()
    for each in simple:
        is_stated = not each.offset.any() and np.array_equal(each.position, matrix)
        (stated if is_stated else others).append(each)
    for name in problem.levels:
        robot, level = robots[name]
        for signs in ((1, 1, 1), (-1, -1, 1), (-1, 1, 1), (1, -1, 1)):
            if select(replace(robot, gravity=robot.gravity * signs), level, stated):
                # The residual is within tolerance, or gravity's sign is wrong: a commoner error
                # than all senses reversed, which forces alone cannot distinguish from it.
                return "", []
    for name in problem.levels:
        if readings := select(*robots[name], others):
            return name, select_first_kind(readings)
    return "", []


def is_nearer_absolute(
    problem: VerificationProblem, user_values: Mapping[str, np.ndarray], level: str
) -> bool:
    """Whether far fewer entries are wrong if the joint angles of a rigid arm are absolute."""
    from crosscheck.trial.robots import readings

    robot, robot_level = build_level_robots(problem.case.arm)[level]
    robot_problem = _build_robot_problem(problem, user_values, robot, robot_level)
    return readings.is_nearer_absolute(robot_problem, robot_level)


def _build_robot_problem(
    problem: VerificationProblem, user_values: Mapping[str, np.ndarray], robot: Robot, level: Level
) -> RobotProblem:
    """The equations as those of a robot, at coordinates whose meaning is open."""
    from crosscheck.trial.robots.answers import RobotAnswers
    from crosscheck.trial.robots.judge import RobotProblem

    states = problem.states[:STATES]
    x, u, torques = (np.array([s[place] for s in states]) for place in (1, 2, 5))
    few = {part: values[:STATES] for part, values in user_values.items()}
    answers = RobotAnswers(few, {}, {}, None, {}, weightless=False, driven=problem.has_gravity)
    asked = RandomStates(x, u, 0 * x, torques)
    return RobotProblem(problem.name, robot, asked, {}, answers, level)

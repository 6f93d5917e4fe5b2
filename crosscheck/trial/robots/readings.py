"""Equations of a robot that are right in other coordinates than its own: which ones, in seconds."""

from __future__ import annotations

import numpy as np

from crosscheck.analytic.robot.model import AnalyticRobot
from crosscheck.models.robot.robot import BASE, Level, Robot
from crosscheck.trial.coordinates.readings import (
    JointCoordinates,
    Reading,
    has_same_values,
    list_pairs,
    list_readings,
    select_first_kind,
)
from crosscheck.trial.robots.judge import RobotProblem


def find_readings(problem: RobotProblem) -> tuple[Level | None, list[Reading]]:
    """The readings in which all parts agree with a level, the simplest ones alone."""
    joints = describe_coordinates(problem.robot)
    levels = [each for each in problem.sizes if each == problem.stated or not problem.stated]
    levels = [each for each in levels if problem.entries(each)]  # else nothing is misread
    for group in (list_readings(joints), list_pairs(joints)):
        for level in levels:
            model = AnalyticRobot(problem.robot, level)
            if readings := [each for each in group if _agrees(each, model, problem)]:
                return level, select_first_kind(readings)
    return None, []


def describe_coordinates(robot: Robot) -> JointCoordinates:
    """A robot's coordinates: which are angles, on which of these each depends, their ratios."""
    places = {number: place for place, number in enumerate(robot.coordinates)}
    kinds = [robot.joints[number].kind for number in robot.coordinates]
    turning = [place for place, kind in enumerate(kinds) if kind == "revolute"]
    before: dict[int, set[int]] = {place: set() for place in turning}
    for place in turning:
        body = robot.joints[robot.coordinates[place]].parent
        while body != BASE:
            joint = robot.joints[body]
            before[place].add(places[body if joint.mimic is None else joint.mimic.joint])
            body = joint.parent
    ratios = np.ones(len(places))
    for rotor in robot.rotors:
        if rotor.joint in places:
            ratios[places[rotor.joint]] = rotor.ratio
    angles = {place: sorted(others & set(turning)) for place, others in before.items()}
    return JointCoordinates(robot.coordinate_names, turning, angles, ratios)


def _agrees(reading: Reading, model: AnalyticRobot, problem: RobotProblem) -> bool:
    user_values = problem.answers.values
    if "mass_matrix" in user_values:  # which most readings do not have
        mass = model.mass_matrix(problem.states.q @ reading.position.T + reading.offset)
        mass = reading.rows.T @ mass @ reading.rates
        if not has_same_values(user_values, {"mass_matrix": mass}):
            return False
    is_driven = bool({"force", "acceleration"} & set(problem.parts))
    return any(
        has_same_values(user_values, _evaluate(reading, model, problem, by_rows=by_rows))
        for by_rows in ((False, True) if is_driven else (False,))
    )


def _evaluate(
    reading: Reading, model: AnalyticRobot, problem: RobotProblem, *, by_rows: bool
) -> dict[str, np.ndarray]:
    """What the equations would say of each part at the states if x were other coordinates.

    by_rows: whether torques are those of the robot's joints, not of x.
    """
    states = problem.states
    q, v = states.q @ reading.position.T + reading.offset, states.v @ reading.rates.T
    mass, bias, gravity = model.terms(q, v)
    mass = reading.rows.T @ mass @ reading.rates
    bias, gravity = bias @ reading.rows, gravity @ reading.rows
    torques = states.torques @ reading.rows if by_rows else states.torques
    whole = np.einsum("sij,sj->si", mass, states.a) + bias
    friction_in_bias = problem.loads_in_force - states.torques
    values = {
        "mass_matrix": mass,
        "bias": bias,
        "gravity": gravity,
        "inverse_dynamics": whole + (0 if problem.answers.weightless else gravity),
        "force": torques + friction_in_bias - problem.weights_in_force(gravity),
    }
    if "acceleration" in problem.parts:
        pushed = torques - bias - gravity
        values["acceleration"] = np.linalg.solve(mass, pushed[..., None])[..., 0]
    return {part: values[part] for part in problem.parts}

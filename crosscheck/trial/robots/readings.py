"""Equations of a robot that are right in other coordinates than its own: which ones, in seconds."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from crosscheck.analytic.robot.model import AnalyticRobot
from crosscheck.checks.robot_states import RandomStates
from crosscheck.models.robot.robot import BASE, Level, Robot
from crosscheck.trial.coordinates.readings import (
    FITS,
    JointCoordinates,
    Reading,
    linear_reading,
    list_readings,
    select_first_kind,
)
from crosscheck.trial.robots.judge import RobotProblem

MASS = "M"  # the key of M, whose diagonal says how large the entries of a row are


def find_readings(problem: RobotProblem) -> tuple[Level | None, list[Reading]]:
    """The readings in which all parts agree with a level, the simplest ones alone."""
    joints = describe_coordinates(problem.robot)
    levels = [each for each in problem.sizes if each == problem.stated or not problem.stated]
    levels = [each for each in levels if problem.entries(each)]  # else nothing is misread
    for level in levels:
        if readings := select_readings(problem, level, list_readings(joints)):
            return level, select_first_kind(readings)
    return None, []


def describe_coordinates(robot: Robot) -> JointCoordinates:
    """Describe a robot's coordinates: which are angles, which depend on others, and the ratios."""
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


def select_readings(
    problem: RobotProblem, level: Level, readings: Sequence[Reading]
) -> list[Reading]:
    """The readings in which all parts agree with a level."""
    model = AnalyticRobot(problem.robot, level)
    likely = _screen(readings, model, problem) if readings else []
    return [each for each in likely if not _count_wrong(each, model, problem)]


def is_nearer_absolute(problem: RobotProblem, level: Level) -> bool:
    """Whether at most half as many entries are wrong if the coordinates are absolute angles."""
    model, joints = AnalyticRobot(problem.robot, level), describe_coordinates(problem.robot)
    relative = linear_reading("relative", "relative angles", np.eye(joints.size))
    absolute = [each for each in list_readings(joints) if each.kind == "absolute"]
    counts = [_count_wrong(each, model, problem) for each in (relative, *absolute)]
    return len(counts) > 1 and 2 * counts[1] <= counts[0] > 0


def _count_wrong(reading: Reading, model: AnalyticRobot, problem: RobotProblem) -> int:
    """Number of entries that differ by more than a tolerance, relative to the reading's M.

    The tolerance is the level's, or one of readings for a robot in the place of an arm.
    """
    user_values, counts = problem.answers.values, list[int]()
    sizes = problem.sizes.get(model.level)
    for values in _generate_values([reading], model, problem.states, problem):
        mass = values.pop(MASS)[0]
        root, count = np.sqrt(np.abs(np.einsum("sii->si", mass))), 0
        for part, each in values.items():
            scale = root[..., None] * root[:, None] if part == "mass_matrix" else root
            scale = 1 / scale if part == "acceleration" else scale
            right, wrong = each[0] / scale, (user_values[part] - each[0]) / scale
            largest = np.abs(right).max() if part != "mass_matrix" else 1.0
            tolerance = sizes.tolerance(part) if sizes else FITS
            beyond = (np.abs(wrong) > tolerance * largest).any(axis=0)
            # What is wrong on both sides of M's diagonal is one error.
            count += int(np.count_nonzero(np.triu(beyond) if part == "mass_matrix" else beyond))
        counts.append(count)
    return min(counts)


def _screen(
    readings: Sequence[Reading], model: AnalyticRobot, problem: RobotProblem
) -> list[Reading]:
    """The readings that agree at the first state, which most do not: all at once.

    What is right at all states is as large as the answers there, but for what readings may leave.
    """
    user_values, first = problem.answers.values, problem.states.first(1)
    agree = np.zeros(len(readings), dtype=bool)
    for values in _generate_values(readings, model, first, problem):
        del values[MASS]
        fits = np.ones(len(readings), dtype=bool)
        for part, right in values.items():
            off = np.abs(right - user_values[part][:1]).reshape(len(readings), -1).max(axis=1)
            fits &= off <= 2 * FITS * np.abs(user_values[part]).max()
        agree |= fits
    return [each for each, fits in zip(readings, agree, strict=True) if fits]


def _generate_values(
    readings: Sequence[Reading], model: AnalyticRobot, states: RandomStates, problem: RobotProblem
) -> Iterator[dict[str, np.ndarray]]:
    """Values of each part (readings, states, ...) if x had these meanings, and M.

    Where a part takes torques, then as if these were those of the robot's joints, not of x.
    """
    position, rates, rows, offset = (
        np.array([getattr(each, name) for each in readings])
        for name in ("position", "rates", "rows", "offset")
    )
    q = states.q @ position.swapaxes(1, 2) + offset[:, None]
    v = states.v @ rates.swapaxes(1, 2)
    shape = q.shape
    terms = model.terms(q.reshape(-1, shape[2]), v.reshape(-1, shape[2]))
    mass, bias, gravity = (each.reshape(*shape[:2], *each.shape[1:]) for each in terms)
    mass = rows.swapaxes(1, 2)[:, None] @ mass @ rates[:, None]
    bias, gravity = bias @ rows, gravity @ rows
    whole = np.einsum("rsij,sj->rsi", mass, states.a) + bias
    held = problem.loads_in_force[: shape[1]] - problem.states.torques[: shape[1]]  # by friction
    values = {
        "mass_matrix": mass,
        "bias": bias,
        "gravity": gravity,
        "inverse_dynamics": whole + (0 if problem.answers.weightless else gravity),
    }
    is_driven = bool({"force", "acceleration"} & set(problem.parts))
    damping = (v * problem.robot.friction) @ rows
    for torques in (states.torques, states.torques @ rows) if is_driven else (states.torques,):
        values["force"] = torques + held - damping - problem.weights_in_force(gravity)
        if "acceleration" in problem.parts:
            pushed = torques - damping - bias - gravity
            values["acceleration"] = np.linalg.solve(mass, pushed[..., None])[..., 0]
        yield {MASS: mass, **{part: values[part] for part in problem.parts}}

"""Self-consistency of a robot's equations: the bias follows from M, gravity from a potential."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from crosscheck.checks.first_principles.slopes import christoffel_force
from crosscheck.checks.robot_states import RandomStates
from crosscheck.models.robot.robot import Robot
from crosscheck.runner.outcomes import Failure
from crosscheck.trial.coordinates.differences import CENTRAL, TURN_RAD

FEW_STATES = 4  # number of states, the first ones
# Step of a sliding joint [m]; M and gravity are quadratic in it, so differences are exact.
SHIFT_M = 0.01
REACH = 4  # steps to either side of a state, of differences of order 8
# Truncation error of order 8, as a share of its distance from the differences of order 6.
TRUNCATED = 0.1
# Two sides that are equal, one by slopes of answers, and the doubt of these (states, ...).
SlopeSides = tuple[np.ndarray, np.ndarray, np.ndarray]
SOURCES = ("mass_matrix", "gravity")  # parts whose slopes are taken


def make_slope_states(robot: Robot, states: RandomStates) -> list[RandomStates]:
    """The first states, changed along each coordinate by -4 to 4 steps; itself is left out."""
    few = RandomStates(*(each[:FEW_STATES] for each in states))
    moved = []
    for number, step in enumerate(_steps(robot)):
        for far in range(-REACH, REACH + 1):
            if far:
                q = few.q.copy()
                q[:, number] += far * step
                moved.append(few._replace(q=q))
    return moved


def _steps(robot: Robot) -> np.ndarray:
    """By which each coordinate changes: no joint that follows it turns further than TURN_RAD."""
    factors = np.abs(robot.joint_map[0])
    slides = np.isin(np.arange(factors.shape[1]) + 1, robot.slides)
    is_alone = np.count_nonzero(factors, axis=0) == 1
    return np.where(slides & is_alone, SHIFT_M, TURN_RAD) / factors.sum(axis=0)


def compare_with_itself(
    robot: Robot,
    states: RandomStates,
    values: Mapping[str, np.ndarray],
    answers: Mapping[str, np.ndarray | Failure],
) -> dict[str, SlopeSides]:
    """Bias and what M demands, gravity's slopes and their mirror images, of what is there.

    values: answers at the states; answers: of mass_matrix and gravity at make_slope_states.
    """
    slopes = {
        part: _slopes(robot, answer)
        for part, answer in answers.items()
        if part in SOURCES and isinstance(answer, np.ndarray)
    }
    differences = dict[str, SlopeSides]()
    if "mass_matrix" in slopes and "bias" in values:
        v, (slope, uncertain) = states.v[:FEW_STATES], slopes["mass_matrix"]
        fast, expected = np.abs(v), christoffel_force(slope, v)
        doubt = christoffel_force(uncertain, fast)  # whose terms all count with one sign
        doubt += np.einsum("isjk,sj,sk->si", uncertain, fast, fast)
        differences["bias"] = values["bias"][:FEW_STATES], expected, TRUNCATED * doubt
    if "gravity" in slopes:
        slope, uncertain = (each.swapaxes(0, 1) for each in slopes["gravity"])
        doubt = uncertain + uncertain.swapaxes(1, 2)
        differences["gravity"] = slope, slope.swapaxes(1, 2), TRUNCATED * doubt
    return differences


def _slopes(robot: Robot, answer: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Slopes (n, states, ...) along each coordinate, and how far two methods are apart."""
    steps = _steps(robot)
    moved = answer.reshape(len(steps), 2 * REACH, -1, *answer.shape[1:])
    high, low = (
        np.tensordot(np.delete(weights, REACH), moved, axes=(0, 1)) for weights in CENTRAL[1]
    )
    by_step = steps.reshape(-1, *[1] * (high.ndim - 1))
    return high / by_step, np.abs(high - low) / by_step

"""Terms of one part alone that are wrong in a way that people derive them: each is named."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from crosscheck.analytic.robot.model import AnalyticRobot
from crosscheck.models.robot.robot import Robot
from crosscheck.trial.input.equations import Equations
from crosscheck.trial.result import TrialDiagnosis
from tests.robots.test_trial_links import tree
from tests.robots.trials import robot_equations, run_robot_trial

STEP = 1e-5
ROBOT = tree("trunk")
MODEL = AnalyticRobot(ROBOT, "links")
Vector = np.ndarray


RIGHT = robot_equations(ROBOT, "links")
mass, bias, gravity = RIGHT.mass_matrix, RIGHT.bias, RIGHT.gravity


def change_of_mass(q: Vector, v: Vector) -> Vector:
    """M' v, by differences."""
    return (mass(q + STEP * v) - mass(q - STEP * v)) @ v / (2 * STEP)


def of_links(robot: Robot, numbers: tuple[int, ...]) -> AnalyticRobot:
    """The robot of which only these bodies have mass."""
    bodies = [
        body if number in numbers else replace(body, mass=0.0, inertia=0 * body.inertia)
        for number, body in enumerate(robot.bodies)
    ]
    return AnalyticRobot(replace(robot, bodies=tuple(bodies)), "links")


def without_arms_in_the_first_entry(q: Vector) -> Vector:
    arms = of_links(ROBOT, (1, 2)).mass_matrix(q[None])[0]
    return mass(q) - arms * np.diag([1.0, 0, 0])


def without_own_columns(q: Vector) -> Vector:
    """M in which the angular velocity of a link is without its own joint's."""
    total = mass(q)
    for number, pose in enumerate(MODEL.frames(q[None], np.zeros((1, 3)))[0]):
        R, turning = pose.rotation[0], pose.angular_partials[0]
        less = turning * (np.arange(3) != number)
        inertia = R @ ROBOT.bodies[number].inertia @ R.T
        total = total + less.T @ inertia @ less - turning.T @ inertia @ turning
    return total


def diagnosis(**parts: Callable) -> TrialDiagnosis:
    return run_robot_trial(replace(RIGHT, **parts), ROBOT).diagnosis


@pytest.mark.parametrize(
    ("parts", "words"),
    [
        (
            {"bias": change_of_mass},
            "in bias alone, as with every joint: M' v alone, without -1/2 d(v' M v)/dq",
        ),
        (
            {"mass_matrix": without_arms_in_the_first_entry},
            "in M[turn, turn] alone, as with left and right: left out",
        ),
        (
            {"mass_matrix": without_own_columns},
            "in mass_matrix alone, as with every link: its Jacobian's column of its own joint,"
            " left out of w",
        ),
        (
            {"bias": lambda q, v: change_of_mass(q, v) - bias(q, v)},
            "in bias alone, as with every joint: +1/2 d(v' M v)/dq alone, as of Christoffel's C"
            " transposed",
        ),
    ],
    ids=["M' v", "branch", "columns", "C transposed"],
)
def test_a_wrong_term_of_one_part_is_named(parts, words):
    assert words in diagnosis(**parts).notes


def test_one_product_of_rates_comes_before_an_unusual_factor():
    def own(q: Vector, v: Vector) -> Vector:
        mixed = bias(q, v) - bias(q, v * [1, -1, 1])  # products of the first two rates, twice
        return bias(q, v) - mixed * [1, 0, 0]

    notes = diagnosis(bias=own).notes
    assert "bias[turn] of turn' l': with the opposite sign" in notes


def test_friction_of_the_other_sign_in_a_force_is_named():
    damping = np.array([0.3, 0.0, 0.2])
    own = Equations(
        force=lambda t, q, v, torque: torque - gravity(q) - damping * v * [1, 1, -1],
        viscous_friction=damping,
    )
    notes = run_robot_trial(own, ROBOT).diagnosis.notes
    assert "force[r], the friction of r: with the opposite sign" in notes


def test_gyroscopic_torques_missing_in_accelerations_are_named():
    def own(q: Vector, v: Vector, torque: Vector) -> Vector:
        pose, rate = MODEL.frames(q[None], v[None])
        gyroscopic = np.zeros(3)
        for number, body in enumerate(ROBOT.bodies):
            R, w = pose[number].rotation[0], rate[number].angular[0]
            moment = np.cross(w, R @ body.inertia @ R.T @ w)
            gyroscopic += pose[number].angular_partials[0].T @ moment
        return np.linalg.solve(mass(q), torque - bias(q, v) + gyroscopic - gravity(q))

    words = run_robot_trial(Equations(acceleration=own), ROBOT).diagnosis.explanations
    assert words[0] == "every link: its gyroscopic torque w x I w missing"

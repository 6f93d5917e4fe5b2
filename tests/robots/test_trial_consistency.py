"""What a robot's equations owe to themselves, in words; forms in which weights may be written."""

from dataclasses import replace

import numpy as np
import pytest

from crosscheck.checks.robot_states import sample_states
from crosscheck.models.robot.file import load_robot
from crosscheck.trial.input.equations import Equations
from crosscheck.trial.judge.checks import Identity, PartSize
from crosscheck.trial.result import Trial
from crosscheck.trial.robots.consistency import compare_with_itself, make_slope_states
from tests.robots import chains, two_link
from tests.robots.trials import robot_equations, run_robot_trial

TWO_LINK = two_link.robot()


def trial_of(own: Equations) -> Trial:
    return run_robot_trial(own, TWO_LINK)


def nonlinear_effects(q: np.ndarray, v: np.ndarray) -> np.ndarray:
    return two_link.bias(q, v) + two_link.gravity(q)


def test_an_entry_that_breaks_a_law_at_a_single_state_is_named():
    """Allowed are 0.5, and 0.4 of a size 1."""
    off = np.array([[0.0, 0.89], [-0.91, 0.89], [0.0, -0.89]])
    size = PartSize(np.ones((3, 2)), 0.4, "")
    assert Identity("", "bias", size, off, 0 * off, np.full((3, 2), 0.5)).places == [(0,)]


def test_what_two_slopes_may_differ_by_is_the_doubt_of_both():
    """Answers of noise have slopes that no step confirms: of gravity, and of M as the bias has."""
    states = sample_states(TWO_LINK, 5, 0)
    count, noise = sum(len(each.q) for each in make_slope_states(TWO_LINK, states)), np.random
    answers = {
        part: noise.default_rng(1).normal(size=(count, *shape))
        for part, shape in (("gravity", (2,)), ("mass_matrix", (2, 2)))
    }
    found = compare_with_itself(TWO_LINK, states, {"bias": np.zeros((5, 2))}, answers)
    gravity, bias = found["gravity"], found["bias"]
    left, right, doubt = gravity
    assert np.array_equal(left, right.swapaxes(1, 2))
    assert np.array_equal(doubt, doubt.swapaxes(1, 2))
    assert min(doubt.min(), bias[2].min()) > 0


def following(multiplier: float) -> str:
    """A URDF of two joints, the second of which follows the first."""
    return chains.urdf(
        chains.link("base"),
        chains.link("a", chains.Solid(1.0, (0.2, 0.1, 0))),
        chains.link("b", chains.Solid(0.7, (0.3, 0, 0.1))),
        chains.joint("turn", "base", "a"),
        chains.joint(
            "follow",
            "a",
            "b",
            at=(0.4, 0, 0),
            more=chains.LIMIT + f'<mimic joint="turn" multiplier="{multiplier}"/>',
        ),
    )


@pytest.mark.parametrize("multiplier", [-3.0, 0.01])
def test_differences_turn_a_joint_and_all_that_follow_it_no_further_than_one(multiplier):
    robot = chains.robot(following(multiplier))
    states = sample_states(robot, 4, 0)
    moved = [each.q - states.q for each in make_slope_states(robot, states)]
    widest = np.abs(moved).max() / 4  # of four steps to either side
    assert widest * (1 + abs(multiplier)) == pytest.approx(0.03, rel=1e-12)  # [rad]


def test_right_equations_keep_what_they_owe():
    """Slopes by differences are right to what they are judged by, mimics and sliders included."""
    for robot in (chains.robot(following(-3)), load_robot("sliding")):
        trial = run_robot_trial(robot_equations(robot, "links"), robot)
        measured = {f.quantity: f.measured for f in trial.agreement.findings}
        assert trial.agrees
        assert measured["bias-from-inertia"] < 1e-11
        assert measured["gravity-is-a-gradient"] < 1e-11


def test_nonlinear_effects_are_bias_and_gravity():
    own = Equations(two_link.mass_matrix, nonlinear_effects, force=lambda torque: torque)
    trial = trial_of(own)
    assert trial.agrees
    assert set(trial.relative_errors) == {"mass_matrix", "bias", "gravity", "force"}
    _, bias, force = trial.scope[:3]
    assert "bias is not 0 at rest: read as nonlinear effects" in bias
    assert "force has no weights" in force
    beside = trial_of(replace(own, bias=two_link.bias, gravity=two_link.gravity))
    assert beside.agrees
    assert len(beside.scope) == 1


def test_a_single_row_that_is_right_is_one():
    robot = load_robot("sliding")
    right, skew = robot_equations(robot, "links"), np.zeros((3, 3))
    skew[:2, 2] = 1.0
    mass_matrix = right.mass_matrix
    assert mass_matrix is not None
    trial = run_robot_trial(replace(right, mass_matrix=lambda q: mass_matrix(q) + skew), robot)
    assert "row 3 is right, rows 1 and 2 are wrong" in repr(trial)

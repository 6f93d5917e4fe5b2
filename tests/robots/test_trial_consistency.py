"""What a robot's equations owe to themselves, in words; forms in which weights may be written."""

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


def differing(trial: Trial) -> set[str]:
    own = [f for f in trial.agreement.disagreeing if f.about.key.family == "trial-own"]
    return {finding.quantity for finding in own}


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


def asymmetric(q: np.ndarray) -> np.ndarray:
    return two_link.mass_matrix(q) * np.array([[1, 0.9], [1, 1]])


def indefinite(q: np.ndarray) -> np.ndarray:
    return two_link.mass_matrix(q) - np.diag([20.0, 0.0])


def other_mass(q: np.ndarray) -> np.ndarray:
    return two_link.mass_matrix(q) + np.cos(q[1]) * np.array([[1, 0.5], [0.5, 0]])


def other_bias(q: np.ndarray, v: np.ndarray) -> np.ndarray:
    return (1 + 0.5 / two_link.COUPLED) * two_link.bias(q, v)


WRONG: dict[str, tuple[Equations, set[str], str]] = {
    "not symmetric": (
        two_link.right(mass_matrix=asymmetric),
        {"symmetric", "bias-from-inertia"},
        "mass_matrix is not symmetric: M[j1, j2] differs from M[j2, j1]; M[j2, j1] is right",
    ),
    "not positive definite": (
        two_link.right(mass_matrix=indefinite),
        {"positive-definite"},
        "M is not positive definite (at 12 of 12 states: some motion would have no kinetic energy,"
        " or less)",
    ),
    "bias with another sign": (
        two_link.right(bias=lambda q, v: two_link.bias(q, v) * np.array([1, -1])),
        {"bias-from-inertia"},
        "bias does not follow from mass_matrix, which is right: bias[j2]",
    ),
    "both by one cause": (
        two_link.right(mass_matrix=other_mass, bias=other_bias),
        set(),
        "bias follows from mass_matrix: they are wrong together, by one cause",
    ),
    "no gradient": (
        two_link.right(gravity=lambda q: two_link.gravity(q) * np.array([1, 0.8])),
        {"gravity-is-a-gradient"},
        "no potential energy gives this gravity vector: d gravity[j1]/d j2 differs from"
        " d gravity[j2]/d j1",
    ),
    "weights twice": (
        two_link.right(bias=nonlinear_effects),
        {"bias-quadratic"},
        "bias at rest is not 0: beside gravity it is Coriolis and centrifugal torques alone",
    ),
}


@pytest.mark.parametrize("case", WRONG)
def test_what_is_not_kept_is_said_in_words(case):
    own, checks, words = WRONG[case]
    trial = trial_of(own)
    assert differing(trial) == checks
    assert words in trial.causes[:3]


@pytest.mark.parametrize(("half", "empty"), [(np.triu, "below"), (np.tril, "above")])
def test_a_mass_matrix_of_one_triangle_is_named_by_the_empty_one(half, empty):
    notes = trial_of(two_link.right(mass_matrix=lambda q: half(two_link.mass_matrix(q))))
    assert notes.diagnosis.notes[0].startswith(f"mass_matrix is 0 {empty} the diagonal, and right")


def test_a_diagonal_alone_is_no_triangle():
    own = two_link.right(mass_matrix=lambda q: np.diag(np.diag(two_link.mass_matrix(q))))
    assert not any("triangles alone" in each for each in trial_of(own).diagnosis.notes)


def test_weights_in_the_force_of_one_joint_are_missing_in_the_others():
    """Only a force that is the torques in every joint has its weights on the left."""
    own = two_link.right(force=lambda q, torque: torque - two_link.gravity(q) * [1, 0])
    assert [entry.name for entry in trial_of(own).diagnosis.entries] == ["force[j2]"]


def test_a_ratio_in_one_acceleration_alone_counts_by_its_square():
    ratio = 12.0
    more = np.diag([0.0, (ratio**2 - two_link.N**2) * two_link.ROTOR])

    def own(q: np.ndarray, v: np.ndarray, torque: np.ndarray) -> np.ndarray:
        load = torque - two_link.bias(q, v) - two_link.gravity(q)
        first = np.linalg.solve(two_link.mass_matrix(q), load)[0]
        return np.array([first, np.linalg.solve(two_link.mass_matrix(q) + more, load)[1]])

    diagnosis = trial_of(Equations(acceleration=own)).diagnosis
    assert any(
        "ratio = 12 (file: 10)" in each for each in (*diagnosis.notes, *diagnosis.explanations)
    ), diagnosis


def test_no_cause_that_no_body_can_have():
    assert trial_of(two_link.right(mass_matrix=indefinite)).diagnosis.explanations == ()


def test_nonlinear_effects_are_bias_and_gravity():
    own = Equations(two_link.mass_matrix, nonlinear_effects, force=lambda torque: torque)
    trial = trial_of(own)
    assert trial.agrees
    assert set(trial.relative_errors) == {"mass_matrix", "bias", "gravity", "force"}
    bias, force = trial.scope[:2]
    assert "bias is not 0 at rest: read as nonlinear effects" in bias
    assert "force is the motors' torques alone" in force


def test_wrong_weights_in_nonlinear_effects_are_gravity_s():
    trial = trial_of(
        Equations(two_link.mass_matrix, lambda q, v: two_link.bias(q, v) - two_link.gravity(q))
    )
    assert {entry.name for entry in trial.diagnosis.entries} == {"gravity[j1]", "gravity[j2]"}
    assert all("with the opposite sign" in entry.remark for entry in trial.diagnosis.entries)

"""Terms of one part alone that are wrong in a way that people derive them: each is named."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from crosscheck.analytic.robot.model import AnalyticRobot
from crosscheck.checks.robot_states import sample_states
from crosscheck.models.robot.robot import Robot
from crosscheck.trial.input.equations import Equations
from crosscheck.trial.result import TrialDiagnosis
from crosscheck.trial.robots.rates import sample_bias_terms
from tests.loops import require_items
from tests.robots import chains
from tests.robots.test_trial_links import tree
from tests.robots.trials import run_robot_trial

STEP = 1e-5
ROBOT = tree("trunk")
MODEL = AnalyticRobot(ROBOT, "links")
Vector = np.ndarray


def mass(q: Vector) -> Vector:
    return MODEL.mass_matrix(q[None])[0]


def bias(q: Vector, v: Vector) -> Vector:
    return MODEL.bias(q[None], v[None])[0]


def gravity(q: Vector) -> Vector:
    return MODEL.gravity(q[None])[0]


def change_of_mass(q: Vector, v: Vector) -> Vector:
    """M' v, by differences."""
    return (mass(q + STEP * v) - mass(q - STEP * v)) @ v / (2 * STEP)


def test_terms_of_any_bias_come_back():
    """What stands alone, with a rate and with two, each pair of rates once."""
    draw, states = np.random.default_rng(2), sample_states(ROBOT, 3, 0)
    n = states.q.shape[1]
    rest, linear = draw.normal(size=n), draw.normal(size=(n, n))
    products = np.array([np.triu(each) for each in draw.normal(size=(n, n, n))])
    found = sample_bias_terms(
        lambda q, v: rest + v @ linear.T + np.array([x @ products @ x for x in v]), states
    )
    for terms, right in require_items(
        zip(vars(found).values(), (rest, linear, products), strict=True)
    ):
        assert terms == pytest.approx(np.broadcast_to(right, terms.shape), abs=1e-12)


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


def with_one_weight_not_turned(q: Vector) -> Vector:
    """The weight of `left` by a gravity that is turned as the link is."""
    turn = MODEL.frames(q[None], np.zeros((1, 3)))[0][1].rotation[0]
    pulled = replace(ROBOT, gravity=turn @ ROBOT.gravity)
    own, other = (of_links(robot, (1,)).gravity(q[None])[0] for robot in (ROBOT, pulled))
    return gravity(q) - own + other


def without_own_columns(q: Vector) -> Vector:
    """M in which the angular velocity of a link is without its own joint's."""
    total = mass(q)
    for number, pose in enumerate(MODEL.frames(q[None], np.zeros((1, 3)))[0]):
        R, turning = pose.rotation[0], pose.angular_partials[0]
        less = turning * (np.arange(3) != number)
        inertia = R @ ROBOT.bodies[number].inertia @ R.T
        total = total + less.T @ inertia @ less - turning.T @ inertia @ turning
    return total


def on_a_tilted_base(q: Vector) -> Vector:
    pulled = replace(ROBOT, gravity=np.array([0.0, 3.0, -4.0]) * np.linalg.norm(ROBOT.gravity) / 5)
    return AnalyticRobot(pulled, "links").gravity(q[None])[0]


def diagnosis(**parts: Callable) -> TrialDiagnosis:
    right = {"mass_matrix": mass, "bias": bias, "gravity": gravity}
    return run_robot_trial(Equations(**(right | parts)), ROBOT).diagnosis


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
            {"gravity": with_one_weight_not_turned},
            "in gravity alone, as with left: gravity's direction in the link's own axes,"
            " not turned",
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
        (
            {"mass_matrix": lambda q: mass(q + np.array([0, np.pi / 2, 0]))},
            "mass_matrix: l is a quarter turn more in it",
        ),
    ],
    ids=["M' v", "branch", "weight", "columns", "C transposed", "quarter"],
)
def test_a_wrong_term_of_one_part_is_named(parts, words):
    assert words in diagnosis(**parts).notes


def test_gravity_of_a_tilted_base_is_named():
    size = np.linalg.norm(ROBOT.gravity)
    words = diagnosis(gravity=on_a_tilted_base).explanations[0]
    assert words.endswith("of the right size: a tilted base?")
    assert f", {0.6 * size:.6g}, {-0.8 * size:.6g})" in words


@pytest.mark.parametrize(
    ("part", "words"),
    [
        (lambda M: np.diag(np.diag(M)), "by M's diagonal alone, without coupling"),
        (np.tril, "with M's lower triangle alone"),
        (np.triu, "with M's upper triangle alone"),
    ],
)
def test_accelerations_by_a_part_of_the_mass_matrix_are_named(part, words):
    def own(q: Vector, v: Vector, torque: Vector) -> Vector:
        return np.linalg.solve(part(mass(q)), torque - bias(q, v) - gravity(q))

    notes = run_robot_trial(Equations(acceleration=own), ROBOT).diagnosis.notes
    assert any(each.endswith(words) for each in notes)


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


def test_products_of_inertia_are_exchanged_as_the_file_has_them():
    """In the axes of the inertial frame, which rpy turns against the link's."""
    solid = chains.Solid(2.0, (0.1, 0.02, 0.03), (0.02, 0.003, 0.001, 0.03, -0.002, 0.025))

    def robot(order: tuple[int, ...]) -> Robot:
        parts = [chains.link("base"), chains.link("trunk", chains.Solid())]
        inertia = tuple(solid.inertia[k] for k in order)
        parts.append(chains.link("arm", solid._replace(inertia=inertia, rpy=(0.3, -0.2, 0.5))))
        parts.append(chains.joint("a", "base", "trunk"))
        parts.append(chains.joint("b", "trunk", "arm", axis=(0, 1, 0), at=(0, 0.1, 0.2)))
        return chains.robot(chains.urdf(*parts), {}, gravity_m_per_s2=[0.0, 0.0, -9.81])

    right, used = robot((0, 1, 2, 3, 4, 5)), AnalyticRobot(robot((0, 4, 2, 3, 1, 5)), "links")
    own = Equations(mass_matrix=lambda q: used.mass_matrix(q[None])[0])
    assert "arm: Ixy and Iyz exchanged" in run_robot_trial(own, right).diagnosis.explanations


def test_an_extra_product_of_a_slide_is_named_with_its_cause():
    """The slide's rate turns what it carries in w' alone: of its own force one product more."""
    solid = chains.Solid(3.0, (0.2, 0.0, 0.1), (0.05, 0.0, 0.0, 0.2, 0.0, 0.18))
    robot = chains.robot(
        chains.urdf(
            chains.link("base"),
            chains.link("turret", chains.Solid(4.0, (0.05, 0.02, 0.3))),
            chains.link("boom", solid),
            chains.joint("turn", "base", "turret"),
            chains.joint("reach", "turret", "boom", "prismatic", (1, 0, 0)),
        )
    )
    model = AnalyticRobot(robot, "links")

    def bias(q: np.ndarray, v: np.ndarray) -> np.ndarray:
        return model.bias(q[None], v[None])[0] + [0.0, 3.0 * 0.1 * v[0] * v[1]]

    own = Equations(
        lambda q: model.mass_matrix(q[None])[0], bias, gravity=lambda q: model.gravity(q[None])[0]
    )
    notes = run_robot_trial(own, robot).diagnosis.notes
    assert any(each.startswith("bias[reach] of turn' reach': right is 0") for each in notes)
    cause = "joint reach: its w x z q' added to w'"
    assert any(cause in each for each in notes)

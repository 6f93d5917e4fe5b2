"""The gear tree against the rigid arm, Newton's third law and closed forms."""

from math import cos, radians, sin

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from crosscheck.models.arm.arm import Arm
from crosscheck.models.loading import Case, load_case
from crosscheck.models.pinocchio.arm import PinocchioCoupled, PinocchioGears
from tests.arms import paper_arms
from tests.engines.bodies_checks import contact_wrenches
from tests.one_stage import SPRINGS_ONLY

EPS = np.finfo(float).eps
COSINE = cos(radians(24.6))
R_S, R_P, R_R = 0.0405 * COSINE, 0.054 * COSINE, 0.1485 * COSINE
STIFFNESS, BACKLASH = 1e8, 50e-6
angles = st.floats(-3, 3, allow_subnormal=False)
displacements = st.floats(-2e-4, 2e-4, allow_subnormal=False)


def paper_case(*settings: str, **chosen: str) -> Case:
    return load_case("paper-labelled", "constant-torque", chosen, settings)


def dead_zone(x: float) -> float:
    return max(x - BACKLASH, 0.0) + min(x + BACKLASH, 0.0)


@st.composite
def arms_in_motion(draw: st.DrawFn) -> tuple[Arm, np.ndarray, np.ndarray]:
    """An arm, its coordinates and their rates."""
    arm = draw(paper_arms())
    joint = st.tuples(displacements, displacements, angles)
    many = st.lists(joint, min_size=len(arm.joints), max_size=len(arm.joints))
    q, v = (np.array(draw(many)).ravel() for _ in range(2))
    return arm, q, v


def gears(arm: Arm) -> PinocchioGears:
    return PinocchioGears(arm, load_case("paper-labelled", "pd").scenario)


@settings(max_examples=40)
@given(arms_in_motion())
def test_without_mesh_motion_it_is_the_rigid_arm_on_rolling_gears(moving):
    """M and bias along x = 0 against mimic joints; unequal stages, 1 to 4 joints."""
    arm, q, v = moving
    geared, rigid = gears(arm), PinocchioCoupled(arm, load_case("paper-labelled", "pd").scenario)
    along = np.kron(np.eye(len(arm.joints)), np.array([[0.0], [0.0], [1.0]]))
    theta, theta_dot = q[2::3], v[2::3]
    mass = rigid.mass_matrix(theta)
    # Sums of some hundred products in another order.
    close = {"rtol": 0, "atol": 100 * EPS * np.abs(mass).max()}
    np.testing.assert_allclose(along.T @ geared.mass_matrix(q) @ along, mass, **close)
    close["atol"] *= 1 + theta_dot @ theta_dot
    bias = rigid.bias(theta, theta_dot)
    np.testing.assert_allclose(along.T @ geared.bias(q, along @ theta_dot), bias, **close)


@settings(max_examples=40)
@given(arms_in_motion())
def test_mass_matrix_is_positive_definite_and_its_change_is_the_bias(moving):
    """v . bias = v M' v / 2: velocities do no work but through M(q)."""
    arm, q, v = moving
    model, h = gears(arm), 1e-3
    assert np.linalg.eigvalsh(model.mass_matrix(q))[0] > 0
    near, far = (
        (model.mass_matrix(q + k * h * v) - model.mass_matrix(q - k * h * v)) / (2 * k * h)
        for k in (1, 2)
    )
    change = v @ (4 * near - far) / 3 @ v / 2
    size = np.linalg.norm(model.mass_matrix(q)) * (1 + v @ v) ** 1.5
    # Fourth order in h |v|, up to 4 * 3 * 1e-3 with four joints of 3 rad/s: below 1e-7.
    assert v @ model.bias(q, v) == pytest.approx(change, abs=1e-7 * size)


@settings(max_examples=40)
@given(arms_in_motion())
def test_forward_dynamics_solve_the_equation_of_motion(moving):
    """The articulated body algorithm on all bodies against M a + bias = f."""
    arm, q, v = moving
    model = gears(arm)
    mass, force = model.mass_matrix(q), model.generalized_force(0.2, q, v)
    found = model.acceleration(0.2, q, v)
    expected = np.linalg.solve(mass, force - model.bias(q, v))
    # Forces round to EPS of theirs on the way to either side; M magnifies as in its condition.
    lightest = np.linalg.eigvalsh(mass)[0]
    size = np.abs(force).max() + np.abs(model.bias(q, v)).max()
    np.testing.assert_allclose(found, expected, rtol=0, atol=1000 * EPS * size / lightest)


@settings(max_examples=30)
@given(arms_in_motion())
def test_contact_forces_obey_newtons_third_law(moving):
    """Over all bodies, base included, they sum to no force and, about the shoulder, no moment."""
    arm, q, v = moving
    wrenches = contact_wrenches(gears(arm), 0.2, q, v)
    # Sums of some fifty forces, on arms of up to 8 m.
    size = 8 * 50 * EPS * (1 + np.abs(wrenches).max())
    np.testing.assert_allclose(wrenches.sum(axis=0), 0, atol=size)


@pytest.mark.parametrize("x", [1.5e-4, -1.5e-4])
def test_a_contact_force_acts_along_the_line_of_action(x):
    """Tangent to both base circles, and pushing the gears apart on either flank."""
    model = PinocchioGears(*paper_case(*SPRINGS_ONLY))
    names = model.model.bodies
    planet = names.index("planet_1_1")  # on the x axis at theta = 0
    seat = 0.0405 + 0.054
    magnitude = STIFFNESS * dead_zone(x)
    # k x rounds as in the test of virtual work.
    close = {"rel": 1e-12, "abs": 1e-9}

    sun_mesh = contact_wrenches(model, 0.0, np.array([x, 0, 0, 0, 0, 0]), np.zeros(6))
    push_x, push_y, moment = sun_mesh[planet]
    assert moment - seat * push_y == pytest.approx(-R_P * magnitude, **close)
    assert push_y == pytest.approx(magnitude * COSINE, **close)
    assert push_x == pytest.approx(abs(magnitude) * sin(radians(24.6)), **close)
    # Three planets around the sun: only a moment is left.
    left = [0, 0, -3 * R_S * magnitude]
    np.testing.assert_allclose(sun_mesh[names.index("sun_1")], left, rtol=1e-12, atol=1e-9)

    ring_mesh = contact_wrenches(model, 0.0, np.array([0, x, 0, 0, 0, 0]), np.zeros(6))
    push_x, push_y, moment = ring_mesh[planet]
    assert moment - seat * push_y == pytest.approx(R_P * magnitude, **close)
    assert push_y == pytest.approx(magnitude * COSINE, **close)
    assert push_x == pytest.approx(-abs(magnitude) * sin(radians(24.6)), **close)
    left = [0, 0, -3 * R_R * magnitude]
    np.testing.assert_allclose(ring_mesh[0], left, rtol=1e-12, atol=1e-9)

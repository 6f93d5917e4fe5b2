"""Both of Exudyn's tiers in closed form: gravity, friction, direct joints, a pendulum."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.special import ellipj

from crosscheck.models.exudyn.bodies.bodies import ExudynBodies
from crosscheck.models.exudyn.tree.tree import ExudynTree
from tests.mixed_arms import (
    GRAVITY,
    PAYLOAD,
    ROD_MASS,
    Data,
    arm_of,
    direct,
    geared,
    random_states,
    scenario,
)

Tier = type[ExudynTree] | type[ExudynBodies]
both_tiers = pytest.mark.parametrize("tier", [ExudynTree, ExudynBodies], ids=lambda t: t.name)


def turning(mass_place: float, angle: float) -> float:
    """Gravity's torque [N m] about an axis of mass times distance [kg m] along an angle."""
    return mass_place * (GRAVITY[1] * np.cos(angle) - GRAVITY[0] * np.sin(angle))


@both_tiers
@pytest.mark.parametrize("joint", [geared(), direct()], ids=["geared", "direct"])
def test_gravity_turns_a_single_link(tier: Tier, joint: Data):
    model = tier(arm_of(joint), scenario())
    q = np.zeros(len(model.layout))
    q[-1] = 0.8
    force = model.generalized_force(0.0, q, 0 * q)
    # Weights of 90 N on levers of 1 m, rounded; the planets' cancel.
    assert force[-1] == pytest.approx(turning(ROD_MASS * 0.4 + PAYLOAD * 0.9, 0.8), rel=1e-13)
    np.testing.assert_allclose(force[:-1], 0, atol=1e-12)


@both_tiers
def test_gravity_turns_a_bent_arm(tier: Tier):
    for joints, at_elbow in (
        ((geared(), geared()), 0.36 + 4 * 0.52 + 5.5 + 8.0),
        ((direct(), direct()), 2.5),
        ((geared(), direct()), 2.5),
    ):
        model = tier(arm_of(*joints), scenario())
        q = np.zeros(len(model.layout))
        q[model.layout.theta] = 0.8, -1.7
        outer = turning(6.0 * 0.25 + PAYLOAD * 0.7, 0.8 - 1.7)
        inner = turning(ROD_MASS * 0.4 + (at_elbow + 6.0 + PAYLOAD) * 0.9, 0.8)
        force = model.generalized_force(0.0, q, 0 * q)
        expected = np.zeros(len(q))
        expected[model.layout.theta] = inner + outer, outer
        # Weights of 300 N on levers of 1 m, rounded.
        np.testing.assert_allclose(force, expected, rtol=1e-12, atol=1e-11)


@both_tiers
def test_gravity_is_no_part_of_the_bias(tier: Tier):
    still, falling = (
        tier(arm_of(geared(), direct(), gravity=gravity), scenario())
        for gravity in ((0.0, 0.0), GRAVITY)
    )
    for q, v in random_states(still.layout, 3):
        np.testing.assert_array_equal(falling.bias(q, v), still.bias(q, v))


@both_tiers
def test_friction_brakes_link_against_previous_link(tier: Tier):
    rough = [kind(friction_N_m_s_per_rad=c) for kind, c in ((geared, 7.0), (direct, 11.0))]
    with_friction, without = (
        tier(arm_of(*joints), scenario()) for joints in (rough, (geared(), direct()))
    )
    for q, v in random_states(without.layout, 3):
        dragged = with_friction.generalized_force(0.0, q, v)
        expected = np.zeros(len(q))
        expected[without.layout.theta] = -np.array([7.0, 11.0]) * v[without.layout.theta]
        # Contact forces up to 1e4 N on levers of 1 m stand beside the friction.
        np.testing.assert_allclose(
            dragged - without.generalized_force(0.0, q, v), expected, rtol=0, atol=1e-10
        )


@both_tiers
def test_direct_joints_make_the_two_link_arm_of_the_textbooks(tier: Tier):
    model = tier(arm_of(direct(), direct(), gravity=(0.0, 0.0)), scenario([40.0, -15.0]))
    q, v = np.array([0.3, 0.9]), np.array([1.1, -2.0])
    outer = 0.07 + 0.5 + 6.0 * 0.25**2 + PAYLOAD * 0.7**2
    lever = (6.0 * 0.25 + PAYLOAD * 0.7) * 0.9
    inner = 0.07 + ROD_MASS * (0.9**2 / 12 + 0.4**2) + (2.5 + 6.0 + PAYLOAD) * 0.9**2
    c, s = np.cos(q[1]), np.sin(q[1])
    mass = [[inner + outer + 2 * lever * c, outer + lever * c], [outer + lever * c, outer]]
    bias = [-lever * s * (2 * v[0] + v[1]) * v[1], lever * s * v[0] ** 2]
    # A few sums of numbers near 10.
    np.testing.assert_allclose(model.mass_matrix(q), mass, rtol=1e-13)
    np.testing.assert_allclose(model.bias(q, v), bias, rtol=1e-12)
    np.testing.assert_allclose(model.generalized_force(0.0, q, v), [40.0, -15.0], rtol=1e-13)
    acceleration = np.linalg.solve(mass, np.subtract([40.0, -15.0], bias))
    np.testing.assert_allclose(model.acceleration(0.0, q, v), acceleration, rtol=1e-12)


def test_a_pendulum_swings_as_the_elliptic_functions_say():
    start = {"theta_rad": 2.0}
    run = scenario(duration_s=3.0, step_s=1e-3, record_every=50, start=start)
    motion = ExudynTree(arm_of(direct(), gravity=(9.81, 0.0)), run).simulate()
    inertia = 0.07 + ROD_MASS * (0.9**2 / 12 + 0.4**2) + PAYLOAD * 0.9**2
    rate = np.sqrt(9.81 * (ROD_MASS * 0.4 + PAYLOAD * 0.9) / inertia)
    k = np.sin(1.0)
    _, cn, dn, _ = ellipj(rate * motion.time.values, k**2)
    expected = 2 * np.arcsin(k * cn / dn)
    # RK4 at 1 ms: (h omega)^4 / 120 per radian of omega t, 12 of them.
    np.testing.assert_allclose(motion.theta.values[:, 0], expected, rtol=0, atol=1e-10)
    drop = 9.81 * (ROD_MASS * 0.4 + PAYLOAD * 0.9) * (np.cos(motion.theta.values[:, 0]) - np.cos(2))
    np.testing.assert_allclose(motion.kinetic_energy, drop, rtol=0, atol=1e-8)

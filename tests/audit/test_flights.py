"""The free-flying base keeps its momenta and tends to the fixed one."""

import numpy as np
import pytest

from crosscheck.audit.statics import statics as flights
from crosscheck.models.loading import Case, load_case
from crosscheck.models.pinocchio.floating import FloatingBase, PinocchioFloating
from crosscheck.registry import build


def _case(scenario: str, duration_s: float = 0.5) -> Case:
    settings = [flights.EVERY, f"scenario.duration_s={duration_s}"]
    return load_case("paper-labelled", scenario, None, settings)


def _model(case: Case, mass: float, side: float = 2.0) -> PinocchioFloating:
    return PinocchioFloating(case.arm, case.scenario, FloatingBase(mass, side))


@pytest.mark.parametrize("scenario", ["constant-torque", "pd"])
def test_momenta_stay_zero(scenario):
    run = _model(_case(scenario), 500.0).simulate()
    assert np.abs(run["base"]).max() > 1e-3  # it does move
    assert np.abs(run["momentum"]).max() < 1e-6  # integration at rtol 1e-9, of order 100


def test_momentum_is_that_of_the_bodies():
    """Of the cube alone, moving by itself: m v at its centre, and about the origin."""
    case = _case("pd")
    q, v = np.zeros(5), np.array([0.0, 1.0, 2.0, 0.0, 0.0])
    heavy, light = (_model(case, mass).momentum(q, v) for mass in (1001.0, 1.0))
    centre = -1.0  # half a side behind the shoulder
    speed = 1.0 + 2.0 * centre
    expected = [0.0, 1000 * speed, 1000 * (centre * speed + 2.0 * 4 / 6)]
    np.testing.assert_allclose(heavy - light, expected, atol=1e-9)


@pytest.mark.parametrize("scenario", ["constant-torque", "pd"])
def test_a_base_without_end_stands_still(scenario):
    case = _case(scenario)
    fixed = build("pinocchio:coupled", *case).simulate()
    free = _model(case, 1e13).simulate()
    # 1e-8: rtol 1e-9 of the free run; the mass ratio of 1e11 leaves 1e-11.
    np.testing.assert_allclose(free["theta"], fixed["theta"], atol=1e-8)
    assert flights.tip_error(free, fixed, case).max() < 1e-8


def test_mass_matrix_of_the_joints_is_the_fixed_arms():
    case = _case("pd")
    angles = np.array([0.4, -1.1])
    free = _model(case, 500.0).mass_matrix(np.array([0.1, 0.2, 0.3, *angles]))
    fixed = build("pinocchio:coupled", *case).mass_matrix(angles)
    np.testing.assert_allclose(free[3:, 3:], fixed, rtol=1e-12)


def test_all_that_the_base_carries(labelled):
    joints = sum(
        j.sun_mass_kg + 3 * j.planet_mass_kg + j.carrier_mass_kg + j.ring_mass_kg
        for j in labelled.joints
    )
    assert flights.arm_mass(_case("pd")) == pytest.approx(27 + 18.9 + 10 + joints)


def test_tip_error_of_a_turned_base():
    case = _case("pd", 0.02)
    fixed = build("pinocchio:coupled", *case).simulate()
    times = fixed["time"].size
    turned = fixed.assign(base=(("time", "coordinate"), np.tile([0.0, 0.0, 0.1], (times, 1))))
    chord = 2 * 1.7 * np.sin(0.05)
    assert flights.tip_error(turned, fixed, case)[0] == pytest.approx(chord)

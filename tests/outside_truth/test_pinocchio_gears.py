"""The gear tree against the rigid arm, Newton's third law and closed forms."""

from math import cos, radians, sin

import numpy as np
import pytest

from crosscheck.models.loading import Case, load_case
from crosscheck.models.pinocchio.arm import PinocchioGears
from tests.engines.bodies_checks import contact_wrenches
from tests.one_stage import SPRINGS_ONLY

COSINE = cos(radians(24.6))
R_S, R_P, R_R = 0.0405 * COSINE, 0.054 * COSINE, 0.1485 * COSINE
STIFFNESS, BACKLASH = 1e8, 50e-6


def paper_case(*settings: str, **chosen: str) -> Case:
    return load_case("paper-labelled", "constant-torque", chosen, settings)


def dead_zone(x: float) -> float:
    return max(x - BACKLASH, 0.0) + min(x + BACKLASH, 0.0)


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

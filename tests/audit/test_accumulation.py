"""Fig. 15: growth and prediction on signals whose answers are known."""

import numpy as np
import pytest

from crosscheck.audit.findings import shaking
from crosscheck.audit.findings.shaking import ShakingQuestion

TIME = np.linspace(0, 2, 2001)


def test_growth_rate_of_an_exponential():
    values = np.exp(6 * TIME) * np.cos(100 * TIME)
    assert shaking.growth_rate(TIME, values) == pytest.approx(6, rel=0.05)


def test_prediction_continues_what_the_sensitivities_span():
    sensitivity = np.stack(
        [np.column_stack([TIME**k, TIME ** (k + 1) - 1]) for k in range(4)], axis=2
    )
    error = sensitivity @ np.array([1.0, -2.0, 0.5, 3.0])
    found = shaking.rigid_prediction(TIME, error, sensitivity)
    np.testing.assert_allclose(found, error, atol=1e-9)


@pytest.mark.parametrize(
    ("rate", "misfit", "own"), [(8.0, 0.05, True), (13.0, 0.05, False), (10.0, 0.11, False)]
)
def test_own_sensitivity_on_both_sides(rate, misfit, own):
    assert shaking.is_rigid_sensitivity(rate, 10.0, misfit) is own


def test_starts_of_a_damped_arm_agree():
    """At zeta 0.05 nothing hangs on the start: 1e-12 m grow a thousandfold at most in 0.7 s."""
    found = ShakingQuestion("time", 0.05, (1, 2, 3), 0.7).answer()
    largest = np.array([start.largest_rad for start in found.starts])
    assert np.ptp(largest) < 1e-3 * largest.min()


def test_a_run_that_ends_early_decides_nothing():
    found = ShakingQuestion("sqrt_time", 0.05, (1, 2), 0.02).answer()
    assert found.own is None

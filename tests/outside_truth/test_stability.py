"""The largest step of RK4 against its stability limits in closed form."""

import numpy as np
import pytest

from crosscheck.analytic.stability import runge_kutta_limit

IMAGINARY, REAL = 2 * np.sqrt(2), 2.785293563  # Hairer and Wanner, Solving ODEs II, IV.2


@pytest.mark.parametrize("growth", [0.0, -1e-12, 1e-12])
def test_an_undamped_mode_counts_on_whichever_side_of_the_axis_rounding_puts_it(growth):
    fast, slow = 1e6 * (growth + 1j), 3.0 * (-0.1 + 1j)
    poles = np.array([fast, fast.conjugate(), slow, slow.conjugate()])
    assert runge_kutta_limit(poles) == pytest.approx(IMAGINARY / 1e6, rel=2e-3)


def test_an_overdamped_mode_is_limited_on_the_real_axis():
    assert runge_kutta_limit(np.array([-2e4, -1.0])) == pytest.approx(REAL / 2e4, rel=2e-3)


@pytest.mark.parametrize("growth", [1e-8, 1e-5, 1e-2])
def test_a_fast_mode_that_grows_slowly_is_followed(growth):
    fast = 1e5 * (growth + 1j)
    poles = np.array([fast, fast.conjugate(), -10.0])
    limit = runge_kutta_limit(poles)
    assert limit == pytest.approx(IMAGINARY / 1e5, rel=2e-3)
    z = 0.9 * limit * fast
    grown = abs(1 + z + z**2 / 2 + z**3 / 6 + z**4 / 24)
    assert grown <= abs(np.exp(z)) * (1 + 5 * growth)


def test_a_mode_that_grows_without_turning_limits_no_step():
    assert runge_kutta_limit(np.array([50.0, -10.0])) == pytest.approx(REAL / 10, rel=2e-3)

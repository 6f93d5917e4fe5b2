"""Estimates from rows of torques: intervals, and bands, by closed forms."""

import numpy as np
import pytest
from scipy.stats import t

from crosscheck.identification.bandwidth import choose_bandwidth
from crosscheck.identification.estimation import LinearFit, fit_linear

ROWS = 600


def fit_constant(seed: int = 0) -> LinearFit:
    """A constant torque in noise, of which every row is worth as much."""
    torque = 3.0 + np.random.default_rng(seed).standard_normal((ROWS, 1))
    shown = np.ones((ROWS, 1), dtype=bool)
    return fit_linear(np.ones((ROWS, 1, 1)), torque, shown, (0, ROWS))


def test_an_interval_is_of_students_distribution():
    """One block less than there are is what its degrees of freedom are."""
    fit = fit_constant()
    expected = t.ppf(0.975, len(fit.edges) - 2) * fit.errors
    assert fit.half_widths == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize(("growth", "chosen"), [(1.15, 4.0), (1.25, 2.0)])
def test_a_band_ends_before_the_residual_grows_by_a_fifth(growth, chosen):
    found = choose_bandwidth(lambda bandwidth: growth if bandwidth > 2.5 else 1.0, 1.0, 4.1)
    assert found == pytest.approx(chosen)

"""The kernels' sines and hyperbolic tangent against mpmath's, in fifty digits."""

import math
from fractions import Fraction
from typing import Any

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from crosscheck.analytic.kernel.text import functions
from tests.interpreted import power_of_two

DIGITS = 50
turns = st.floats(allow_nan=False, allow_infinity=False)
near = st.floats(-1e4, 1e4)


def run(lines: list[str], value: float) -> float:
    """What lines make of ``c``."""
    names: dict[str, Any] = {"c": value, "power_of_two": power_of_two, "rint": np.rint}
    exec("\n".join(lines), names)
    return names["found"]


def tanh(value: float) -> float:
    return run(functions.hyperbolic_tangent("found", "c"), value)


def interpolated() -> list[float]:
    """sin(2 pi r) / r of u = r^2 at the Chebyshev nodes of 0 to 1/16: coefficients in doubles."""
    count = len(functions.SINE_OF_TURNS)
    with mpmath.workdps(DIGITS):
        nodes = [(1 + mpmath.cos(mpmath.pi * (2 * k + 1) / (2 * count))) / 32 for k in range(count)]
        powers = mpmath.matrix([[node**power for power in range(count)] for node in nodes])
        roots = [mpmath.sqrt(node) for node in nodes]
        values = mpmath.matrix([mpmath.sin(2 * mpmath.pi * r) / r for r in roots])
        return [float(value) for value in mpmath.lu_solve(powers, values)]


def test_the_polynomial_interpolates_at_chebyshev_nodes():
    assert tuple(interpolated()) == functions.SINE_OF_TURNS


def test_the_polynomial_errs_by_less_than_it_says():
    with mpmath.workdps(DIGITS):
        coefficients = [mpmath.mpf(value) for value in reversed(functions.SINE_OF_TURNS)]
        worst = 0.0
        for k in range(1, 2001):
            r = mpmath.mpf(k) / 8000
            polynomial = r * mpmath.polyval(coefficients, r * r)
            worst = max(worst, float(abs(polynomial - mpmath.sin(2 * mpmath.pi * r))))
    assert 1e-18 < worst < 4e-17


@given(turns)
def test_whole_turns_are_taken_away_exactly(value):
    left = Fraction(run(functions.reduce_turns("found", "c"), value))
    assert abs(left) <= Fraction(1, 2)
    assert (Fraction(value) - left).denominator == 1


@pytest.mark.parametrize("wave", ["cosine", "sine"])
@given(value=near)
def test_sine_and_cosine_are_right_to_rounding(wave, value):
    text, exact = {"cosine": (functions.cosine, mpmath.cos), "sine": (functions.sine, mpmath.sin)}[
        wave
    ]
    with mpmath.workdps(DIGITS):
        right = float(exact(2 * mpmath.pi * mpmath.mpf(value)))
    # The polynomial's value and r round by an eps each; a quarter taken away from the phase
    # rounds by half of the phase's last digit, and 2 pi of that reach the sine.
    moved = math.pi * math.ulp(abs(value) + 0.25) if wave == "sine" else 0.0
    assert abs(run(text("found", "c"), value) - right) <= 2 * np.finfo(float).eps + moved


@given(st.floats(-25, 25) | st.floats(-1e-3, 1e-3))
def test_hyperbolic_tangent(value):
    with mpmath.workdps(DIGITS):
        right = float(mpmath.tanh(mpmath.mpf(value)))
    assert abs(tanh(value) - right) <= 4e-16  # 1, 2 / (exp + 1) and the power round once each


@pytest.mark.parametrize("value", [functions.LARGEST, 1e3, 1e300, math.inf])
def test_hyperbolic_tangent_of_large_numbers(value):
    assert (tanh(value), tanh(-value)) == pytest.approx((1.0, -1.0), abs=np.finfo(float).eps)


def test_hyperbolic_tangent_of_no_number():
    assert math.isnan(tanh(math.nan))

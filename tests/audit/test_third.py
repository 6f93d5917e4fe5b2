"""The third fluctuation over many starts."""

import numpy as np
import pytest
from scipy.stats import beta

from crosscheck.audit.judging.rule import State
from crosscheck.audit.judging.sample import Sample
from crosscheck.audit.judging.shares import Share
from crosscheck.audit.measures.third_fluctuation import NONE, ThirdFluctuation, quantiles
from crosscheck.audit.measures.thresholds import SEVERE
from tests.audit.planted_runs import third

ABOVE, BELOW = 1.01, 0.99
LOUD, QUIET = ABOVE * SEVERE, BELOW * SEVERE


def test_a_share_has_clopper_and_pearsons_interval():
    low, high = Share(3, 10).interval
    assert low == pytest.approx(beta.ppf(0.025, 3, 8))
    assert high == pytest.approx(beta.ppf(0.975, 4, 7))
    assert (Share(0, 8).interval[0], Share(8, 8).interval[1]) == (0.0, 1.0)
    assert Share(32, 32).interval[0] == pytest.approx(0.025 ** (1 / 32), rel=1e-9)  # closed form


def test_severe_has_two_sides():
    assert third(*[LOUD] * 10).state == State.YES
    assert third(*[QUIET] * 10).state == State.NO


def test_samples_join_and_diverged_starts_have_no_numbers():
    one = Sample({"third": np.array([1.0, np.nan])}, np.array([False, True]))
    joined = ThirdFluctuation.from_samples(one, one)
    assert (joined.size.size, joined.sizes.size) == (4, 2)
    assert quantiles(np.array([np.nan])) == NONE


def test_starts_that_others_stand_for_are_not_counted():
    alike = Sample({"third": np.full(32, LOUD)}, np.zeros(32, bool), not_run=24)
    assert ThirdFluctuation.from_samples(alike).share == Share(8, 8)

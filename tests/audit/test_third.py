"""The third fluctuation over many starts, and two samples of it."""

import numpy as np
import pytest
from scipy.stats import beta

from crosscheck.audit.claims.model_judgement import model_of
from crosscheck.audit.experiments.paper_conditions import (
    AS_MODELLED,
    CONSERVATIVE,
    INTEGRAL,
    PRINTED,
    Condition,
)
from crosscheck.audit.findings import presence
from crosscheck.audit.judging.rule import State
from crosscheck.audit.judging.sample import Sample
from crosscheck.audit.judging.shares import Share
from crosscheck.audit.measures.third_fluctuation import NONE, VISIBLE, ThirdFluctuation, quantiles
from crosscheck.audit.measures.thresholds import EVIDENT, SEVERE
from tests.audit.planted_runs import third
from tests.audit.stated import of_third

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
    loud, calm = ThirdFluctuation.from_samples(alike), third(*[QUIET] * 32)
    assert loud.share == Share(8, 8)
    made = presence.compute_error_effect(loud, calm)
    assert made.share == Share(32, 32)  # 32 starts without the error were run beside the eight
    assert made.p == presence.shares_p(Share(8, 8), Share(0, 32))


def test_the_tooth_error_makes_what_is_not_there_without_it():
    calm = third(*[QUIET] * 10)
    assert presence.compute_error_effect(third(*[LOUD] * 9, QUIET), calm).share == Share(9, 10)
    assert presence.compute_error_effect(calm, calm).share == Share(0, 10)
    shaken = third(*[LOUD] * 2, *[QUIET] * 8)
    assert presence.compute_error_effect(third(*[LOUD] * 10), shaken).share is None
    one_loud = third(LOUD, *[QUIET] * 9)
    assert presence.compute_error_effect(third(*[LOUD] * 10), one_loud).share == Share(9, 9)
    assert presence.compute_error_effect(third(*[np.nan] * 10), calm).state == State.UNDEFINED
    visible = third(*[ABOVE * EVIDENT] * 10)
    quiet = third(*[BELOW * EVIDENT] * 10)
    assert presence.compute_error_effect(visible, quiet, VISIBLE).state == State.YES
    assert presence.compute_error_effect(visible, visible, VISIBLE).share is None


def test_what_few_starts_do_is_made_only_if_it_is_no_chance():
    """8 of 32 are more than one in ten and no chance beside none, but may be beside four."""
    loud = third(*[LOUD] * 8, *[QUIET] * 24)
    assert presence.compute_error_effect(loud, third(*[QUIET] * 32)).state == State.BISTABLE
    assert presence.compute_error_effect(loud, third(*[LOUD] * 3, *[QUIET] * 29)).state == State.NO


def test_what_the_claims_ask_is_said_and_nothing_else():
    as_modelled = Condition(PRINTED, 0.01, planets="lumped", equations="printed")
    (stated,) = of_third("here", [(Condition(PRINTED, 0.01), third(*[LOUD] * 10))])
    assert (stated.quantity, stated.state) == ("pd: third", State.YES)
    (lumped,) = of_third("here", [(as_modelled, third(LOUD))])
    assert model_of(lumped.place) == AS_MODELLED
    assert not of_third("here", [(Condition(PRINTED, 0.01, planets="lumped"), third(LOUD))])
    assert not of_third("here", [(Condition(INTEGRAL, 0.01, planets="lumped"), third(LOUD))])
    assert not of_third("here", [(Condition(CONSERVATIVE, 0.01), third(LOUD))])


def test_two_samples_are_told_apart_or_not():
    """Fisher's by hand: 5 of 5 against 0 of 5 is one table of 252, either way."""
    assert presence.shares_p(Share(5, 5), Share(0, 5)) == pytest.approx(2 / 252)
    assert presence.shares_p(Share(5, 5), Share(5, 5)) == pytest.approx(1.0)

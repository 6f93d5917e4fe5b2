"""The third fluctuation over many starts, and two samples of it."""

import numpy as np
import pytest
from scipy.stats import beta

from crosscheck.audit.claims.rule import State, state
from crosscheck.audit.experiments.paper_conditions import (
    AS_MODELLED,
    CONSERVATIVE,
    INTEGRAL,
    PRINTED,
    Condition,
)
from crosscheck.audit.experiments.samples import Sample
from crosscheck.audit.measures import twosamples
from crosscheck.audit.measures.shares import Share
from crosscheck.audit.measures.third_fluctuation import NONE, VISIBLE, ThirdFluctuation, quantiles
from crosscheck.audit.measures.thresholds import EVIDENT, SEVERE
from tests.audit.stated import of_third

ABOVE, BELOW = 1.01, 0.99
LOUD, QUIET = ABOVE * SEVERE, BELOW * SEVERE


def third(*sizes: float) -> ThirdFluctuation:
    """Starts of these sizes."""
    found = np.array(sizes)
    return ThirdFluctuation(found, found / 1000, 10 * found, 1e-8 * found, 0)


def test_a_share_has_clopper_and_pearsons_interval():
    low, high = Share(3, 10).interval
    assert low == pytest.approx(beta.ppf(0.025, 3, 8))
    assert high == pytest.approx(beta.ppf(0.975, 4, 7))
    assert (Share(0, 8).interval[0], Share(8, 8).interval[1]) == (0.0, 1.0)


def test_branches_are_never_averaged_with_each_other():
    found = third(20.0, 22.0, 24.0, 400.0, 420.0, np.nan)  # 2 of 5 exclude neither end
    small, severe = found.branch(severe=False), found.branch(severe=True)
    assert (small.starts, small.size, small.frequency_Hz) == (3, 22.0, 220.0)
    assert (severe.starts, severe.size) == (2, 400.0)
    assert (found.share, found.state) == (Share(2, 5), state(Share(2, 5)))


def test_severe_has_two_sides():
    assert third(*[LOUD] * 10).state == State.YES
    assert third(*[QUIET] * 10).state == State.NO


def test_samples_join_and_diverged_starts_have_no_numbers():
    names = ("third", "third_onset_s", "frequency_Hz", "planets_apart_m")
    one = Sample({name: np.array([1.0, np.nan]) for name in names}, np.array([False, True]))
    joined = ThirdFluctuation.from_samples(one, one)
    assert (joined.size.size, joined.sizes.size, joined.diverged) == (4, 2, 2)
    assert quantiles(np.array([np.nan])) == NONE


def test_starts_that_others_stand_for_are_not_counted():
    names = ("third", "third_onset_s", "frequency_Hz", "planets_apart_m")
    alike = Sample({name: np.full(32, LOUD) for name in names}, np.zeros(32, bool), not_run=24)
    loud, calm = ThirdFluctuation.from_samples(alike), third(*[QUIET] * 32)
    assert loud.share == Share(8, 8)
    made = twosamples.compute_error_effect(loud, calm)
    assert made.share == Share(32, 32)  # 32 starts without the error were run beside the eight
    assert made.p == twosamples.shares_p(Share(8, 8), Share(0, 32))


def test_the_tooth_error_makes_what_is_not_there_without_it():
    calm = third(*[QUIET] * 10)
    assert twosamples.compute_error_effect(third(*[LOUD] * 9, QUIET), calm).share == Share(9, 10)
    assert twosamples.compute_error_effect(calm, calm).share == Share(0, 10)
    shaken = third(*[LOUD] * 2, *[QUIET] * 8)
    assert twosamples.compute_error_effect(third(*[LOUD] * 10), shaken).share is None
    one_loud = third(LOUD, *[QUIET] * 9)
    assert twosamples.compute_error_effect(third(*[LOUD] * 10), one_loud).share == Share(9, 9)
    assert twosamples.compute_error_effect(third(*[np.nan] * 10), calm).state == State.UNDEFINED
    visible = third(*[ABOVE * EVIDENT] * 10)
    quiet = third(*[BELOW * EVIDENT] * 10)
    assert twosamples.compute_error_effect(visible, quiet, VISIBLE).state == State.YES
    assert twosamples.compute_error_effect(visible, visible, VISIBLE).share is None


def test_what_few_starts_do_is_made_only_if_it_is_no_chance():
    """8 of 32 are more than one in ten and no chance beside none, but may be beside four."""
    loud = third(*[LOUD] * 8, *[QUIET] * 24)
    assert twosamples.compute_error_effect(loud, third(*[QUIET] * 32)).state == State.BISTABLE
    assert (
        twosamples.compute_error_effect(loud, third(*[LOUD] * 3, *[QUIET] * 29)).state == State.NO
    )


def test_what_the_claims_ask_is_said_and_nothing_else():
    as_modelled = Condition(PRINTED, 0.01, planets="lumped", equations="printed")
    (stated,) = of_third("here", [(Condition(PRINTED, 0.01), third(*[LOUD] * 10))])
    assert (stated.quantity, stated.state) == ("pd: third", State.YES)
    (lumped,) = of_third("here", [(as_modelled, third(LOUD))])
    assert lumped.place.model == AS_MODELLED
    assert not of_third("here", [(Condition(PRINTED, 0.01, planets="lumped"), third(LOUD))])
    assert not of_third("here", [(Condition(INTEGRAL, 0.01, planets="lumped"), third(LOUD))])
    assert not of_third("here", [(Condition(CONSERVATIVE, 0.01), third(LOUD))])


def test_two_samples_are_told_apart_or_not():
    """Fisher's by hand: 5 of 5 against 0 of 5 is one table of 252, either way; ranks alike."""
    assert twosamples.shares_p(Share(5, 5), Share(0, 5)) == pytest.approx(2 / 252)
    assert twosamples.shares_p(Share(5, 5), Share(5, 5)) == pytest.approx(1.0)
    assert twosamples.sizes_p([1, 2, 3, 4, 5], [6, 7, 8, 9, 10]) == pytest.approx(2 / 252)
    assert twosamples.sizes_p([1, 3, 5, 7], [2, 4, 6, 8]) > 0.5
    both = twosamples.compare_samples(third(*range(1, 6)), third(*range(6, 11)))
    assert both.by_size == pytest.approx(2 / 252)
    assert twosamples.compare_samples(third(np.nan), third(1.0)) == (None, None)


def test_significance_has_two_sides():
    assert twosamples.is_significant(BELOW * twosamples.SIGNIFICANT)
    assert not twosamples.is_significant(ABOVE * twosamples.SIGNIFICANT)


def test_a_family_is_adjusted_as_holm_says():
    """By hand: the smallest times three, the next times two, never below one before it."""
    assert twosamples.adjust_by_holm([0.03, 0.01, 0.02]) == pytest.approx([0.04, 0.03, 0.04])
    assert twosamples.adjust_by_holm([0.9, 0.8]) == [1.0, 1.0]
    assert twosamples.adjust_by_holm([]) == []
    pairs = [twosamples.PValues(0.01, None), twosamples.PValues(0.02, 0.5)]
    assert twosamples.adjust_pairs(pairs) == [(pytest.approx(0.03), None), (0.04, 0.5)]


@pytest.mark.parametrize(("first", "second"), [(3, 3), (7, 9), (16, 32)])
def test_the_interval_of_a_ratio_inverts_mann_and_whitneys_test(first, second):
    """A factor at which the exact test says 10 % or less is outside, one at which more inside."""
    generator = np.random.default_rng(first)
    one, other = (np.exp(generator.normal(0, 0.2, size)) for size in (first, second))
    interval = twosamples.find_ratio_interval(one, 1.3 * other)
    for end, inwards in ((interval.low, 1 + 1e-9), (interval.high, 1 - 1e-9)):
        assert twosamples.sizes_p(end * inwards * one, 1.3 * other) > 0.1
        assert twosamples.sizes_p(end / inwards * one, 1.3 * other) <= 0.1 + 1e-12
    assert twosamples.find_ratio_interval(one[:2], other[:3]) is None


def test_the_interval_of_a_difference_is_newcombes():
    """His example of 56 of 70 less 48 of 80, there at 95 %: 0.0524 to 0.3339."""
    at_90 = twosamples.find_difference_interval(Share(48, 80), Share(56, 70))
    assert 0.0524 < at_90.low < 0.2 < at_90.high < 0.3339
    swapped = twosamples.find_difference_interval(Share(56, 70), Share(48, 80))
    assert swapped == pytest.approx((-at_90.high, -at_90.low))


def test_sameness_is_shown_or_not_and_so_is_a_difference():
    assert twosamples.ConfidenceInterval(-0.1, 0.1).is_within(-0.2, 0.2) is True
    assert twosamples.ConfidenceInterval(-0.1, 0.3).is_within(-0.2, 0.2) is None
    assert twosamples.ConfidenceInterval(0.25, 0.3).is_within(-0.2, 0.2) is False

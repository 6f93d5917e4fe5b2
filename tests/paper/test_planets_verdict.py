"""What decides H7: both sides of every threshold."""

from __future__ import annotations

import math

import pytest
from scipy.stats import beta

from crosscheck.paper.phase.verdict import PRESENT_RAD_PER_S2
from crosscheck.paper.planets.verdict import (
    FEW,
    LARGE_RAD_PER_S2,
    MOST,
    PREDICTED,
    SIGNIFICANT,
    WORTH,
    Effect,
    Share,
    Survival,
    effect,
    h7_verdict,
    is_changed,
    is_large,
    least_p,
    not_told_apart,
    one_distribution,
    parting_is_predicted,
    shares_p,
    sizes_p,
    survival,
    told_apart,
)

ABOVE, BELOW = 1.01, 0.99


def test_a_share_has_clopper_and_pearsons_interval() -> None:
    share = Share.counted(3, 10)
    assert share.value == 0.3
    assert share.low == pytest.approx(beta.ppf(0.025, 3, 8))
    assert share.high == pytest.approx(beta.ppf(0.975, 4, 7))
    assert (Share.counted(0, 8).low, Share.counted(8, 8).high) == (0.0, 1.0)


def test_two_samples_are_told_apart_or_not() -> None:
    """Fisher's by hand: 5 of 5 against 0 of 5 is one table of 252, either way; ranks alike."""
    all_of_them, none = Share.counted(5, 5), Share.counted(0, 5)
    assert shares_p(all_of_them, none) == pytest.approx(2 / 252)
    assert shares_p(all_of_them, all_of_them) == pytest.approx(1.0)
    assert sizes_p([1, 2, 3, 4, 5], [6, 7, 8, 9, math.inf]) == pytest.approx(2 / 252)
    assert sizes_p([1, 3, 5, 7], [2, 4, 6, 8]) > 0.5


def test_significance_has_two_sides() -> None:
    assert told_apart(BELOW * SIGNIFICANT)
    assert not told_apart(ABOVE * SIGNIFICANT)
    assert told_apart(BELOW * SIGNIFICANT / 10, 10)
    assert not told_apart(ABOVE * SIGNIFICANT / 10, 10)
    assert told_apart(math.nan) is None
    above, below = ABOVE * SIGNIFICANT, BELOW * SIGNIFICANT
    assert one_distribution(above, above) is True
    assert one_distribution(above, below) is one_distribution(below, above) is False
    assert one_distribution(above, math.nan) is None


def test_large_has_two_sides() -> None:
    assert is_large(ABOVE * LARGE_RAD_PER_S2)
    assert not is_large(BELOW * LARGE_RAD_PER_S2)
    assert is_large(None) is None


def test_the_effect_of_freeing_planets() -> None:
    large, small = [400.0] * 5, [20.0] * 5
    p, q = 0.5 * SIGNIFICANT / 48, 1.5 * SIGNIFICANT / 48
    assert effect(large, small, p, p, 48) == Effect.WEAKER
    assert effect(small, large, p, p, 48) == Effect.STRONGER
    assert effect(large, small, q, q, 48) == Effect.NONE
    assert effect(large, small, math.nan, p, 48) == Effect.UNKNOWN
    for by, expected in ((BELOW, Effect.NONE), (ABOVE, Effect.STRONGER)):
        assert effect([200.0] * 5, [200.0 * (1 + by * WORTH)] * 5, 1.0, p, 48) == expected
    for by, expected in ((BELOW, Effect.NONE), (ABOVE, Effect.WEAKER)):
        before = by * PRESENT_RAD_PER_S2
        assert effect([before] * 5, [before / 2] * 5, 1.0, p, 48) == expected
    assert effect([math.inf] * 3, [math.inf] * 3, 1.0, 0.0, 1) == Effect.UNKNOWN
    assert effect([200.0] * 3, [math.inf] * 3, 1.0, 0.0, 1) == Effect.STRONGER
    assert effect([math.inf] * 3, [200.0] * 3, 1.0, 0.0, 1) == Effect.WEAKER


def test_parting_is_predicted_within_a_tenth() -> None:
    assert parting_is_predicted(None, None)
    assert not parting_is_predicted(0.1, None)
    assert not parting_is_predicted(None, 0.1)
    assert parting_is_predicted(1 + BELOW * PREDICTED, 1.0)
    assert not parting_is_predicted(1 + ABOVE * PREDICTED, 1.0)


@pytest.mark.parametrize(
    ("lumped", "free", "expected"),
    [
        (1.0, MOST, Survival.YES),
        (1.0, BELOW * MOST, Survival.BISTABLE),
        (1.0, ABOVE * FEW, Survival.BISTABLE),
        (1.0, FEW, Survival.NO),
        (ABOVE * FEW, 0.0, Survival.NO),
        (FEW, 0.0, Survival.ABSENT),
        (FEW, 1.0, Survival.APPEARS),
        (ABOVE * FEW, 1.0, Survival.YES),
        (ABOVE * FEW, 0.5, Survival.BISTABLE_EITHER),
        (BELOW * MOST, 0.5, Survival.BISTABLE_EITHER),
        (FEW, 0.5, Survival.BISTABLE),
        (MOST, 0.5, Survival.BISTABLE),
        (None, 1.0, Survival.UNKNOWN),
        (1.0, None, Survival.UNKNOWN),
    ],
)
def test_what_survives(lumped: float | None, free: float | None, expected: Survival) -> None:
    assert survival(lumped, free) == expected


def test_a_feature_is_changed_where_its_shares_are_told_apart() -> None:
    """12 of 16 against 2 of 16 has p = 0.0011, against 3 of 16 p = 0.0038."""
    some = Share.counted(12, 16)
    assert is_changed(some, Share.counted(2, 16), 38) is True
    assert is_changed(some, Share.counted(3, 16), 38) is False
    assert is_changed(some, some, 1) is False
    all_of_them, none = Share.counted(4, 4), Share.counted(0, 4)
    assert is_changed(all_of_them, none, 1) is True
    assert is_changed(all_of_them, none, 2) is None
    assert is_changed(None, none, 1) is is_changed(none, None, 1) is None


def test_samples_may_be_too_small_to_be_told_apart() -> None:
    assert least_p(2, 2) == pytest.approx(1 / 3)
    assert least_p(3, 3) == pytest.approx(2 / 20)
    assert least_p(2, 4) > SIGNIFICANT > least_p(2, 24)
    fewest, most = not_told_apart(Share.counted(12, 24), 16)
    assert (fewest, most) == (3, 13)
    for yes in (fewest - 1, most + 1):
        assert told_apart(shares_p(Share.counted(12, 24), Share.counted(yes, 16)))


def test_verdict_of_h7() -> None:
    assert h7_verdict([Effect.NONE, Effect.WEAKER]) == "holds"
    assert h7_verdict([Effect.STRONGER, Effect.UNKNOWN]) == "holds"
    assert h7_verdict([Effect.NONE, Effect.UNKNOWN]) == "not seen"
    assert h7_verdict([Effect.UNKNOWN]) == h7_verdict([]) == "undefined"

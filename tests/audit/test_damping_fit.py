"""The damping fit: which settings are told apart from the best."""

from itertools import combinations

import numpy as np
import pytest

from crosscheck.audit.claims.catalogue import BY_ID
from crosscheck.audit.experiments.experiments import CONSTANT, PD
from crosscheck.audit.experiments.paper_conditions import INTEGRAL, PRINTED, Condition
from crosscheck.audit.findings import damping_fit
from crosscheck.audit.judging.quantities import ConditionResults
from crosscheck.audit.judging.sample import Sample


def test_chance_by_counting_every_way():
    best, other = np.array([3, 5, 5]), np.array([4, 2, 5])
    pooled = [*best, *other]
    sums = [sum(pooled[i] for i in chosen) for chosen in combinations(range(6), 3)]
    expected = np.mean([total >= best.sum() for total in sums])
    assert damping_fit.chance(best, other) == pytest.approx(
        expected, rel=1e-12
    )  # sums of few floats


def _fit(zeta: float, *explained: list[int]) -> damping_fit.DampingFit:
    yes = {f"claim {k}": np.array(row, bool) for k, row in enumerate(explained)}
    return damping_fit.DampingFit(Condition(PRINTED, zeta), yes)


STARTS = 32
ALL, NONE = [1] * STARTS, [0] * STARTS
HALF = [1, 0] * (STARTS // 2)


def test_a_setting_a_hair_behind_is_as_good_and_one_far_behind_is_not():
    hair = [1] * (STARTS - 1) + [0]
    found = [
        _fit(0.004, ALL, ALL),
        _fit(0.005, ALL, hair),
        _fit(0.006, ALL, HALF),
        _fit(0.1, ALL, NONE),
    ]
    assert damping_fit.chance(found[0].counts, found[2].counts) < damping_fit.ALPHA / 3
    assert damping_fit.select_best_fits(found) == found[:2]


def test_all_settings_alike_are_all_equally_good():
    found = [_fit(zeta, HALF) for zeta in (0.004, 0.005, 0.006)]
    assert len(damping_fit.select_best_fits(found)) == 3


def test_a_number_is_explained_where_its_claim_is_true():
    sample = {name: np.full(STARTS, 30.0) for name in ("first", "second", "third", "frequency_Hz")}
    known = ConditionResults(
        {PD: Sample(sample, np.zeros(STARTS, bool)), CONSTANT: Sample({}, np.ones(1, bool))}
    )
    claims = [BY_ID["3.2-27"], BY_ID["3.2-29"]]  # 10 to 40 rad/s^2, and 300
    fit = damping_fit.fit_condition(Condition(INTEGRAL, 0.02), known, claims)
    assert [fit.explained[claim.id].all() for claim in claims] == [True, False]
    assert fit.mean == 1

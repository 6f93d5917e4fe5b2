"""The damping fit: which settings are told apart from the best, and what is said of the claims."""

from itertools import combinations

import numpy as np
import pytest

from crosscheck.audit.claims.catalogue import BY_ID
from crosscheck.audit.claims.quantities import ConditionResults
from crosscheck.audit.claims.rule import Place, State
from crosscheck.audit.experiments.experiments import CONSTANT, PD
from crosscheck.audit.experiments.paper_conditions import INTEGRAL, PRINTED, Condition
from crosscheck.audit.experiments.samples import Sample
from crosscheck.audit.experiments.scale import Scale
from crosscheck.audit.experiments.study import Study
from crosscheck.audit.experiments.variant import Variant, simulate
from crosscheck.audit.hypotheses import damping_fit
from crosscheck.audit.page.context import AuditContext
from tests.audit.stated import of_fit

CLAIMS = [BY_ID[name] for name in damping_fit.NUMBERS]


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
    return damping_fit.DampingFit(Condition(PRINTED, zeta), yes, {})


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
    assert damping_fit.summarize_settings(damping_fit.select_best_fits(found)).zetas == (
        0.004,
        0.005,
    )


def test_all_settings_alike_are_all_equally_good():
    found = [_fit(zeta, HALF) for zeta in (0.004, 0.005, 0.006)]
    assert len(damping_fit.select_best_fits(found)) == 3


def test_what_the_set_hangs_on_shows_when_it_is_left_out():
    found = [_fit(0.004, ALL, ALL), _fit(0.1, ALL, NONE)]
    assert [one.settings for one in damping_fit.summarize_without_each(found)] == [1, 2]


@pytest.fixture(scope="module")
def material(tmp_path_factory: pytest.TempPathFactory) -> AuditContext:
    folder = tmp_path_factory.mktemp("kept")
    return AuditContext(Study(folder), Scale(quick=True, longest_s=0.01, most_starts=3))


def test_what_a_run_is_too_short_for_explains_nothing(material):
    found = damping_fit.fit_conditions(material, CLAIMS)
    assert {fit.cell.planets for fit in found} == {"free", "lumped"}
    for fit in found:
        assert not fit.explained["3.2-16"].any()  # no side changes in 10 ms
        assert fit.answers["3.2-16"].state == State.UNDEFINED
    assert "3.2-16" not in damping_fit.find_uninformative_claims(found)[State.NO]


def test_what_is_said_has_the_claims_own_limits_and_quantities():
    sample = {name: np.full(STARTS, 30.0) for name in ("first", "second", "third", "frequency_Hz")}
    cell = Condition(INTEGRAL, 0.02)
    claim = BY_ID["3.2-27"]
    known = ConditionResults(
        {PD: Sample(sample, np.zeros(STARTS, bool)), CONSTANT: Sample({}, np.zeros(1, bool))}
    )
    fit = damping_fit.fit_condition(cell, known, [claim])
    (one,) = of_fit([fit], [claim])
    assert (one.quantity, one.limits) == ("pd: first", claim.limits)
    assert one.place == Place(INTEGRAL, "paper-labelled", 0.02, "")
    assert one.state == State.YES
    assert fit.mean == 1


def test_the_first_reversals_of_a_rigid_arm_under_pd():
    """The torque begins at P pi / 6 > 0, and the arm overshoots once: from first principles > 0."""
    run = simulate(Variant(model="analytic:coupled", record_every=100))
    torque = run["torque"].values[:, 0]
    time = run["time"].values
    first, second = damping_fit.torque_reversals(run)
    assert (torque[time < first] > 0).all()
    assert (torque[(time > first) & (time < second)] < 0).all()

"""What decides H7: both sides of every threshold."""

import pytest

from crosscheck.audit.claims.rule import State
from crosscheck.audit.measures.thresholds import EVIDENT
from crosscheck.audit.measures.twosamples import SIGNIFICANT, PValues
from crosscheck.audit.planets.parting import PREDICTED, is_parting_predicted
from crosscheck.audit.planets.verdict import (
    PlanetsEffect,
    Survival,
    judge_effect,
    judge_h7,
    judge_survival,
)
from tests.audit.planted_runs import third

ABOVE, BELOW = 1.01, 0.99


def test_the_effect_of_freeing_planets():
    large, small = third(*[400.0] * 5), third(*[20.0] * 5)
    told, untold = BELOW * SIGNIFICANT, ABOVE * SIGNIFICANT
    assert judge_effect(large, small, PValues(told, 1.0)) == PlanetsEffect.WEAKER
    assert judge_effect(small, large, PValues(told, 1.0)) == PlanetsEffect.STRONGER
    assert judge_effect(large, small, PValues(untold, untold)) == PlanetsEffect.NONE
    assert judge_effect(large, small, PValues(None, told)) == PlanetsEffect.UNKNOWN
    larger = third(*[440.0] * 5)
    assert judge_effect(large, larger, PValues(1.0, told)) == PlanetsEffect.STRONGER
    assert judge_effect(larger, large, PValues(1.0, told)) == PlanetsEffect.WEAKER


def test_sizes_that_are_no_fluctuation_have_no_effect():
    p = PValues(1.0, 0.0)
    for by, expected in ((BELOW, PlanetsEffect.NONE), (ABOVE, PlanetsEffect.STRONGER)):
        assert judge_effect(third(*[1.0] * 5), third(*[by * EVIDENT] * 5), p) == expected


def test_parting_is_predicted_within_a_tenth():
    assert is_parting_predicted(None, None)
    assert not is_parting_predicted(0.1, None)
    assert not is_parting_predicted(None, 0.1)
    assert is_parting_predicted(1 + BELOW * PREDICTED, 1.0)
    assert not is_parting_predicted(1 + ABOVE * PREDICTED, 1.0)


@pytest.mark.parametrize(
    ("lumped", "free", "expected"),
    [
        (State.YES, State.YES, Survival.YES),
        (State.NO, State.NO, Survival.NO),
        (State.YES, State.NO, Survival.LOST),
        (State.NO, State.YES, Survival.APPEARS),
        (State.BISTABLE, State.YES, Survival.BISTABLE),
        (State.NO, State.BISTABLE, Survival.BISTABLE),
        (State.UNDEFINED, State.YES, Survival.UNKNOWN),
        (State.BISTABLE, State.UNDEFINED, Survival.UNKNOWN),
    ],
)
def test_what_survives(lumped, free, expected):
    assert judge_survival(lumped, free) == expected


def test_verdict_of_h7():
    assert judge_h7([PlanetsEffect.NONE, PlanetsEffect.WEAKER]) == "holds"
    assert judge_h7([PlanetsEffect.STRONGER, PlanetsEffect.UNKNOWN]) == "holds"
    assert judge_h7([PlanetsEffect.NONE, PlanetsEffect.UNKNOWN]) == "not seen"
    assert judge_h7([PlanetsEffect.UNKNOWN]) == judge_h7([]) == "undefined"

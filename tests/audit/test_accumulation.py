"""Fig. 15: what backlash adds, on numbers whose growth is known."""

import numpy as np
import pytest

from crosscheck.audit.experiments.experiments import BACK
from crosscheck.audit.experiments.paper_conditions import INTEGRAL, PRINTED, Condition
from crosscheck.audit.findings import accumulation
from crosscheck.audit.judging.quantities import ConditionResults, Sample
from crosscheck.audit.judging.rule import State

PLACE = Condition(INTEGRAL, 0.02)


def _results(rate: float, own_rate: float = 6.0, exact: float = 1e-6) -> ConditionResults:
    """Two starts; errors of exp(rate t), middles of the windows at 0.2 and 1.9 s."""
    grown, own = (np.exp(np.array([each, each]) * 1.7) for each in (rate, own_rate))
    return ConditionResults(
        {
            BACK(b): Sample(
                {
                    "error_early": np.full(2, exact + added),
                    "error_2_s": exact + added * grown,
                    "own_early": np.full(2, 1e-6),
                    "own_2_s": 1e-6 * own,
                },
                np.zeros(2, bool),
            )
            for b, added in ((0.0, 0.0), (50.0, 2e-6))
        }
    )


@pytest.mark.parametrize(
    ("rate", "own", "state"),
    [(7.4, 6.0, State.YES), (7.6, 6.0, State.NO), (4.6, 6.0, State.YES), (4.4, 6.0, State.NO),
     (1.7, -0.1, State.NO), (1.7, np.nan, State.UNDEFINED)],
)  # fmt: skip
def test_the_growth_is_the_rigid_arms_own_on_both_sides_of_a_quarter(rate, own, state):
    found = accumulation.measure_accumulation(PLACE, _results(rate, own), BACK)
    assert found.growth_per_s == pytest.approx([rate, rate])
    assert found.added_rad == pytest.approx(2e-6 * np.exp(1.7 * rate))
    assert found.state == state
    assert accumulation.judge_drive([found]) == state


def test_settings_that_differ_decide_nothing():
    one, other = (
        accumulation.measure_accumulation(PLACE, _results(rate), BACK) for rate in (6.0, 9.0)
    )
    assert accumulation.judge_drive([one, other]) is None


def test_the_settings_are_those_of_the_gears_that_were_driven():
    settings = [
        (PLACE, _results(6.0)),
        (Condition(PRINTED, 0.02), _results(9.0)),
        (Condition(INTEGRAL, 0.03), ConditionResults()),
    ]
    assert [x.condition for x in accumulation.find_accumulations(settings)["sqrt_time"]] == [PLACE]

"""Every check of a cross-check differs just above its tolerance and agrees just below."""

from collections.abc import Iterator

import pytest

from crosscheck.findings import ComparisonKey
from crosscheck.models.arm.arm import Arm
from crosscheck.models.arm.planets import usual_switches
from crosscheck.models.loading import Case, load_arm, load_scenario
from crosscheck.planning import arms, plan
from crosscheck.planning.comparison import Comparison, Results
from crosscheck.planning.preparation import Preparation, fail_preparation
from crosscheck.runner.outcomes import Failure
from tests.engines.judge_limits import GUARDS
from tests.faults.planting import faults_in

# The guard that has the limits of each family of checks. What terms a balance has is seen by the
# planted faults of tests/faults.
JUDGED = {
    **dict.fromkeys(("states", "form-symbols"), "states geared"),
    "arm-data": "data geared",
    **dict.fromkeys(("same-step", "at-2-s", "lumped-free"), "runs"),
    **dict.fromkeys(("refined", "precise", "order", "stable-step"), "runs"),
    "record": "records",
    "modes": "modes",
    **dict.fromkeys(("inertia", "bias-from-inertia", "abilities"), "self geared"),
    **dict.fromkeys(("power", "angular-momentum-rate", "constraints"), "balances"),
    **dict.fromkeys(("energy-rate", "energy"), "balances"),
}
MEASURED = {"form-states", "form", "deviation", "one-rounding", "one-rounding-per-planet"}


def planned(arm: Arm, *lost: Comparison) -> Iterator[Comparison]:
    """All comparisons of an arm, with the experiments of the paper."""
    laws, limit = usual_switches(arm), 1e-5
    first = plan.Experiment("pd", Case(arm, load_scenario("pd"), laws))
    request = plan.CrossCheckRequest(arm, quick=True)
    yield from arms.plan_comparisons(request, Preparation([first], limit, (), lost))


@pytest.mark.parametrize("name", ["paper-labelled", "probe", "direct-between"])
def test_the_guards_have_every_check_of_a_cross_check(name):
    """A new check needs a limit there."""
    keys = [each.about.key for each in planned(load_arm(name))]
    kinds = {key.quantity if key.family == "invariants" else key.family for key in keys}
    assert kinds - MEASURED <= JUDGED.keys()
    assert set(JUDGED.values()) <= GUARDS.keys()


def test_what_preparation_has_lost_is_a_failed_check_of_the_plan():
    key = ComparisonKey("preparation", "pd", "growth", "exudyn:tree")
    *_, last = planned(load_arm("direct-between"), fail_preparation(key, Failure("Odd", "why")))
    finding = last.finding(Results({}))
    assert (finding.about.key, finding.verdict) == (key, "failed")
    assert finding.note == "exudyn:tree: Odd: why"


UNPLANTED = sorted(GUARDS.keys() - {row.seen.quantity for row in faults_in("judge")})


@pytest.mark.parametrize("name", UNPLANTED)
def test_a_number_just_above_its_tolerance_differs_and_just_below_agrees(name):
    """Of guards by which no planted fault is seen: tests/faults asks the others, unharmed too."""
    assert list(GUARDS[name]()) == []

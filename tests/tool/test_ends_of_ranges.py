"""Whatever arm the schema lets through is planned, or refused in one line: never an internal error.

Each number alone at the least and the greatest that its range has, and arms of one to seven joints
whose every number is drawn.
"""

import random
from contextlib import suppress

import pytest

from crosscheck.models.arm.arm import Arm
from crosscheck.models.arm.planets import usual_switches
from crosscheck.models.errors import InputError
from crosscheck.models.experiment.scenario import Scenario
from crosscheck.models.loading import load_case
from crosscheck.planning.arms import plan_comparisons
from crosscheck.planning.plan import CrossCheckRequest, draft_experiments, set_stable_step
from crosscheck.planning.preparation import Preparation
from crosscheck.planning.sizing import compute_sizes
from crosscheck.registry import build, reference_model
from tests.draws import DRAWS, any_arm, fresh_seed
from tests.tool.test_ranges import LIMITS, SCENARIO

DECADES = 0.5, 2.0, 6.0  # about the numbers of an arm of a metre


def plan(arm: Arm) -> None:
    """Plan an arm's cross-check, as far as no run is needed. Raises InputError."""
    wanted = CrossCheckRequest(arm, quick=True)
    outline = draft_experiments(wanted, compute_sizes(arm))
    model = build(reference_model(), arm, outline[0].case.scenario, usual_switches(arm))
    limit = model.largest_stable_step()
    chosen = Preparation([set_stable_step(each, limit) for each in outline], limit, ())
    assert all(Scenario.model_validate(e.case.scenario.model_dump()) for e in outline)
    plan_comparisons(wanted, chosen)


@pytest.mark.parametrize("number", LIMITS)
def test_ends_of_a_range_are_inside_and_planned(number):
    """Other promises (of whole teeth, of gears beside each other) may still refuse them."""
    arm, path, limit = LIMITS[number]
    for value in (limit.least, limit.most, *([0.0] if limit.or_zero else [])):
        reason = ""
        try:
            case = load_case(arm, SCENARIO, {}, [f"{path}={value!r}"])
            if path.startswith("arm."):
                plan(case.arm)
        except InputError as refused:
            reason = refused.allowed
        assert reason != f"must be {limit}"


def test_an_arm_of_a_kilometre_is_planned():
    """A torque beyond the range of a scenario would lift it."""
    plan(load_case("paper-labelled", SCENARIO, {}, ["arm.links.0.length_m=1000.0"]).arm)


@pytest.mark.campaign
def test_drawn_arms_are_planned_or_refused():
    seed = fresh_seed()
    generator, planned = random.Random(seed), 0
    for _ in range(DRAWS // 2):
        arm = any_arm(generator, generator.randint(1, 7), generator.choice(DECADES))
        with suppress(InputError):
            plan(arm)
            planned += 1
    assert planned, seed

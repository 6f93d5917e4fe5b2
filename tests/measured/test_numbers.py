"""Every number of a comparison is that of a second program; every view says the same numbers."""

import json

import jsonschema
import pytest

from crosscheck.provenance import ROOT
from tests.measured import guards
from tests.measured.guards import HEAVY, RIGHT, RUBBING, TILTED, measured

SCHEMA = json.loads((ROOT / "crosscheck/schema/measured.schema.json").read_text())


@pytest.mark.slow
@pytest.mark.parametrize("kind", [RIGHT, HEAVY, RUBBING, TILTED])
def test_every_number_is_that_of_the_second_program(kind):
    found, right = measured(kind)
    data = guards.data_of(found)
    jsonschema.validate(data, SCHEMA)
    for wrong in (
        guards.wrong_smoothing(data, right),
        guards.wrong_levels(data, right),
        guards.wrong_limits(found),
        guards.wrong_estimates(data, right),
        guards.wrong_frictions(data, right),
        guards.wrong_gravities(data, right),
    ):
        assert list(wrong) == []
    assert bool(data["explained_by"]) == (kind == HEAVY)
    assert bool(data["explained_by_friction"]) == (kind == RUBBING)
    assert bool(data["explained_by_gravity"]) == (kind == TILTED)


@pytest.mark.slow
def test_runs_are_those_of_the_second_program():
    found, _ = measured(HEAVY)
    right = guards.right_windows(HEAVY)
    assert list(guards.wrong_windows(guards.data_of(found), right)) == []
    assert list(guards.wrong_run_pictures(found, right)) == []


@pytest.mark.slow
@pytest.mark.parametrize("kind", [RIGHT, HEAVY, RUBBING])
def test_every_view_says_the_same_numbers(kind):
    found, right = measured(kind)
    assert list(guards.wrong_lines(found)) == []
    if kind != RIGHT:  # whose page has no other table
        assert list(guards.wrong_page(found)) == []
    assert list(guards.wrong_pictures(found, right)) == []


WRONG = (
    *(guards.wrong_possible_frictions, guards.wrong_order),
    *(guards.wrong_drive_torques, guards.wrong_witness, guards.wrong_choice),
)


@pytest.mark.parametrize("wrong", WRONG)
def test_choices_order_torques_of_a_drive_and_the_witness_are_right(wrong):
    assert list(wrong()) == []

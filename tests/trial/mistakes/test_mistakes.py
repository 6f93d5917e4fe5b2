"""Mistakes are reported in the right words, never in wrong ones; right texts are not blamed.

A sample in the suite; all of them with CROSSCHECK_DRAWS, as ``make fuzz`` sets it.
``python -m benchmarks.bench_trial --all`` tries all of them.
"""

from dataclasses import replace

import numpy as np
import pytest

from crosscheck.models.arm.arm import Arm
from crosscheck.models.loading import load_scenario
from crosscheck.trial.changes.arms.term_words import guess
from crosscheck.trial.input.equations import Coordinates, Equations
from crosscheck.trial.input.loading import build_equations
from tests.draws import DRAWS
from tests.draws import SAMPLE as SAMPLED
from tests.trial.mistakes.equations import RIGHT, written
from tests.trial.mistakes.score import MISTAKES, scored, supplied, wrong_entries

ENOUGH = 0.9  # of the mistakes, named by their term
SAMPLE = (
    "inertia inside the bracket",
    "sum of masses for a product",
    "centre of mass from the other end",
    "friction without its reaction",
    "mesh forces by the root of the number",
)


@pytest.mark.parametrize("kind", ["relative", "absolute", "spins"])
def test_a_right_text_is_not_blamed(kind):
    assert wrong_entries(supplied(kind)) == []


@pytest.mark.parametrize("name", SAMPLE)
def test_a_mistake_is_named_in_its_entry_by_its_term(name):
    (mistake,) = (each for each in MISTAKES if each.name == name)
    found = scored(mistake)
    assert (found.entry_right, found.verdict) == (True, "right"), found


def test_a_mistake_in_degrees_is_named_by_its_term():
    """A map whose numbers are no quantity of the arm: joint angles in degrees."""
    replaced, unit = (("M[1, 1] = I2 +", "M[1, 1] = I1 +"),), np.pi / 180

    def factory(arm: Arm) -> Equations:
        own = written("absolute", replaced, arm)
        matrix = unit * np.array(own.coordinates.matrix)
        return replace(
            own,
            mass_matrix=lambda x: unit**2 * own.mass_matrix(unit * x),
            bias=lambda x, v: unit * own.bias(unit * x, unit * v),
            force=lambda x, v, torque: unit * own.force(unit * x, unit * v, torque),
            coordinates=Coordinates(matrix=matrix, names=("a", "b")),
        )

    asked = supplied("absolute")
    made_of = build_equations(factory, asked.mechanism, load_scenario("pd"), "degrees")
    (wrong,) = wrong_entries(replace(asked, equations=made_of))
    assert (wrong.place.row, wrong.place.column) == (1, 1)
    assert guess(wrong) == "missing term: 0.000304617 (I_l2 - I_l1); I_l1 where I_l2 belongs?"


@pytest.mark.campaign
def test_mistakes_are_named_and_nobody_is_misled():
    """The first ones in the suite; all of them, and all right texts, in a campaign."""
    assert [kind for kind in RIGHT if DRAWS > SAMPLED and wrong_entries(supplied(kind))] == []
    found = [scored(mistake) for mistake in MISTAKES[: DRAWS // 10]]
    assert [each for each in found if not each.entry_right] == []
    assert [each for each in found if each.verdict == "misleading"] == []
    assert sum(each.verdict == "right" for each in found) >= ENOUGH * len(found)

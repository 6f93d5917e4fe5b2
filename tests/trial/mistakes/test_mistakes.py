"""Reported mistakes are told in the right words, never in wrong ones; right texts are not blamed.

A sample in the suite; all of them with CROSSCHECK_DRAWS, as ``make fuzz`` sets it.
"""

from __future__ import annotations

import pytest

from tests.draws import DRAWS
from tests.trial.mistakes.equations import RIGHT
from tests.trial.mistakes.mistakes import MISTAKES
from tests.trial.mistakes.score import diagnosed, scored, supplied

ENOUGH = 0.9  # of the mistakes, told by their term
SAMPLE = (
    "inertia inside the bracket",
    "sum of masses for a product",
    "centre of mass from the other end",
    "friction without its reaction",
)


@pytest.mark.parametrize("kind", RIGHT)
def test_a_right_text_is_not_blamed(kind: str):
    assert diagnosed(supplied(kind)) == []


@pytest.mark.parametrize("name", SAMPLE)
def test_a_mistake_is_told_in_its_entry_by_its_term(name: str):
    (mistake,) = (each for each in MISTAKES if each.name == name)
    found = scored(mistake)
    assert (found.entry_right, found.verdict) == (True, "right"), found


@pytest.mark.campaign
def test_mistakes_are_told_right_and_nobody_is_misled():
    """The first ones in the suite; all of them in a campaign."""
    found = [scored(mistake) for mistake in MISTAKES[: DRAWS // 10]]
    assert [each for each in found if not each.entry_right] == []
    assert [each for each in found if each.verdict == "misleading"] == []
    assert sum(each.verdict == "right" for each in found) >= ENOUGH * len(found)

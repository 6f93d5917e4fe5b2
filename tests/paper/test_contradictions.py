"""No two places of the page say different things of one quantity in one setting."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from pathlib import Path

import pytest

from crosscheck.paper import report
from crosscheck.paper.cells import LABELLED, LAWS
from crosscheck.paper.claims.rule import Limits, Place, State
from crosscheck.paper.material import Material
from crosscheck.paper.said import Said
from crosscheck.paper.scale import Scale
from crosscheck.studies.study import Study
from tests.paper.contradictions import contradictions

FEW_STARTS = Scale(quick=True, most_starts=4)
ONE = Said("here", "pd: third", Limits(low=10.0), Place(LAWS[0], LABELLED, 0.005, ""), State.YES)


@pytest.mark.slow
def test_the_page_contradicts_itself_nowhere(tmp_path: Path) -> None:
    material = Material(Study(tmp_path, 2), FEW_STARTS)
    made = [report._chapter(material, name) for name in report.QUICK_CHAPTERS]
    said = [one for chapter in made for one in chapter.said]
    told = Counter((one.quantity, *one.place[:3]) for one in said)
    assert max(told.values()) > 1  # else there was nothing to compare
    assert contradictions(said) == []


@pytest.mark.parametrize(
    ("other", "found"),
    [
        (ONE, 0),
        (replace(ONE, where="there", state=State.NO), 1),
        (replace(ONE, where="there", state=State.UNDEFINED), 1),
        (replace(ONE, state=State.NO, place=Place(LAWS[1], LABELLED, 0.005, "")), 0),
        (replace(ONE, state=State.NO, quantity="pd: first"), 0),
        (replace(ONE, limits=Limits(low=5.0), state=State.NO), 1),
        (replace(ONE, limits=Limits(low=5.0), state=State.BISTABLE), 1),
        (replace(ONE, limits=Limits(low=20.0), state=State.NO), 0),
        (replace(ONE, limits=Limits(low=20.0, high=30.0), state=State.YES), 0),
        (replace(ONE, limits=Limits(high=5.0), state=State.YES), 0),  # neither is in the other
    ],
)
def test_a_contradiction_is_seen(other: Said, found: int) -> None:
    assert len(contradictions([ONE, other])) == found


def test_a_free_parameters_choice_is_part_of_the_quantity() -> None:
    other = replace(ONE, place=ONE.place._replace(choice="first"), state=State.NO)
    assert len(contradictions([ONE, other])) == 1

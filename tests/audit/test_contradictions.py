"""What two places of a page say of one quantity in one setting is compared as it should be."""

from dataclasses import replace

import pytest

from crosscheck.audit.errata.erratum import Erratum
from crosscheck.audit.experiments.paper_conditions import LAWS, Condition
from crosscheck.audit.judging.rule import Limits, Place, State, VerdictKind
from tests.audit.contradictions import (
    contradictions,
    held_and_denied,
    taught_otherwise,
)
from tests.audit.stated import Said, Taught

ONE = Said(
    "here",
    "pd: third",
    Limits(low=10.0),
    Place(tuple(Condition(LAWS[0], 0.005).conditions.items())),
    State.YES,
)


OTHER_LAW = Place(tuple(Condition(LAWS[1], 0.005).conditions.items()))


@pytest.mark.parametrize(
    ("changes", "found"),
    [
        ({}, 0),
        ({"state": State.NO}, 1),
        ({"state": State.UNDEFINED}, 1),
        ({"state": State.NO, "place": ONE.place._replace(choice="first")}, 1),  # of the quantity
        ({"state": State.NO, "place": OTHER_LAW}, 0),
        ({"state": State.NO, "quantity": "pd: first"}, 0),
        ({"state": State.NO, "limits": Limits(low=5.0)}, 1),
        ({"state": State.BISTABLE, "limits": Limits(low=5.0)}, 1),
        ({"state": State.NO, "limits": Limits(low=20.0)}, 0),
        ({"limits": Limits(low=20.0, high=30.0)}, 0),
        ({"limits": Limits(high=5.0)}, 0),  # neither is in the other
    ],
)
def test_a_contradiction_is_seen(changes, found):
    assert len(contradictions([ONE, replace(ONE, where="there", **changes)])) == found


@pytest.mark.parametrize(
    ("kind", "denied", "yes", "no", "silent"),
    [
        (VerdictKind.HOLDS, 1, 0, 1, 0),
        (VerdictKind.WHERE_DEFINED, 1, 0, 1, 0),
        (VerdictKind.DEPENDS, 0, 0, 0, 0),
        (VerdictKind.FAILS, 0, 1, 0, 0),
    ],
)
def test_a_claim_is_compared_with_the_sheet_and_with_the_findings(kind, denied, yes, no, silent):
    """One that depends contradicts neither."""
    kinds = {"2.2-10": kind}
    assert len(held_and_denied([Erratum("eq13-rate", denies=("2.2-10",))], kinds)) == denied
    assert held_and_denied([Erratum("eq13-rate")], kinds) == []
    for is_true, found in ((True, yes), (False, no), (None, silent)):
        assert len(taught_otherwise([Taught("finding 1", "2.2-10", is_true)], kinds)) == found

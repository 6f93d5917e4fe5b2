"""The ladder of H2: rungs, closing sums and verdicts."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from crosscheck.paper.hypotheses import ladder_records, ladder_rungs
from crosscheck.paper.hypotheses.ladder_records import attributions, ladder_verdict
from crosscheck.paper.hypotheses.ladder_rungs import ORDERS, Ladder, contributions, rungs, variant
from crosscheck.studies.variant import simulate


def test_both_orders_climb_the_same_rungs():
    assert set(ORDERS["A"]) == set(ORDERS["B"])
    assert {f for members in ladder_rungs.GROUPS.values() for f in members} == set(ORDERS["A"])


@pytest.mark.parametrize("order", sorted(ORDERS))
def test_every_rung_changes_the_model(order):
    made = [variant(features, "pd", "paper-labelled") for features in rungs(ORDERS[order])]
    assert len(set(made)) == len(made)


def test_masses_taken_away_leave_the_links():
    """`carriers` without joint masses is `links`: what the permuted order rests on."""
    links = variant(frozenset(), "constant-torque", "paper-labelled")
    ends = [
        simulate(replace(links, model=f"analytic:{level}", duration_s=0.05))["theta"].values[-1]
        for level in ("links", "carriers")
    ]
    np.testing.assert_allclose(*ends, rtol=1e-13)


def test_contributions_close_on_the_whole_deviation():
    places = list(np.random.default_rng(0).normal(size=(4, 5, 4)))
    steps = contributions(places)
    whole = places[-1] - places[0]
    np.testing.assert_allclose(steps[:, :, :2].sum(axis=0), whole[:, :2], atol=1e-14)
    np.testing.assert_allclose(steps[:, :, 2].sum(axis=0), np.linalg.norm(whole[:, 2:], axis=1))


def _ladder(values: dict[str, float]) -> Ladder:
    order = ORDERS["A"]
    fine = np.array([values.get(name, 0.0) for name in order])[:, None, None] * np.ones((1, 2, 3))
    return Ladder("pd", "paper-labelled", order, np.array([0.0, 1.0]), fine, fine + 1e-6)


def test_shares_sum_to_one_and_uncertainty_is_three_times_the_change():
    made = _ladder({"masses": 3.0, "coupling": -1.0})
    assert sum(made.shares(-1, 0).values()) == pytest.approx(1)
    np.testing.assert_allclose(made.uncertainty, 3e-6)


@pytest.mark.parametrize(("share", "name"), [(0.91, "meshes"), (0.89, "none alone")])
def test_dominant_on_both_sides_of_the_threshold(share, name):
    assert ladder_records.dominant({"meshes": share, "slips": 1 - share}) == name


@pytest.mark.parametrize(
    ("measured", "same"), [(0.019, True), (-0.019, True), (0.021, False), (0.0049, False)]
)
def test_reproduces_within_a_factor_of_two(measured, same):
    assert ladder_records.reproduces(measured, 0.01) is same


@pytest.mark.parametrize(
    ("cause", "h2", "paper"),
    [
        ("diagonal", "holds", "does not hold"),
        ("masses", "does not hold", "does not hold"),
        ("backlash", "does not hold", "holds"),
    ],
)
def test_verdicts_follow_the_cause(cause, h2, paper):
    made = replace(_ladder({cause: 1.0, "slips": 0.01}), scenario="constant-torque")
    verdict = ladder_verdict(attributions(made))
    assert (verdict.as_worded, verdict.papers) == (h2, paper)

"""The ladder of H2: rungs, closing sums and verdicts."""

from dataclasses import replace

import numpy as np
import pytest

from crosscheck.audit.claims.catalogue import BY_ID
from crosscheck.audit.claims.rule import Limits, State
from crosscheck.audit.experiments.variant import simulate
from crosscheck.audit.hypotheses.evidence.level_ablation import (
    CLAIMS,
    GROUPS,
    ORDERS,
    LevelAblation,
    build_variant,
    compute_baseline_deviations,
    compute_deviations,
    compute_residuals,
    contributions,
    iterate_features,
    judge_ablation,
)
from tests.audit.stated import of_ladder


def test_both_orders_climb_the_same_rungs():
    assert set(ORDERS["A"]) == set(ORDERS["B"])
    assert {f for members in GROUPS.values() for f in members} == set(ORDERS["A"])


@pytest.mark.parametrize("order", sorted(ORDERS))
def test_every_rung_changes_the_model(order):
    made = [
        build_variant(features, "pd", "paper-labelled")
        for features in iterate_features(ORDERS[order])
    ]
    assert len(set(made)) == len(made)


def test_masses_taken_away_leave_the_links():
    """`carriers` without joint masses is `links`: what the permuted order rests on."""
    links = build_variant(frozenset(), "constant-torque", "paper-labelled")
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


def _ladder(values: dict[str, float], order: str = "A") -> LevelAblation:
    names = ORDERS[order]
    fine = np.array([values.get(name, 0.0) for name in names])[:, None, None] * np.ones((1, 2, 3))
    time = np.array([0.0, 1.0])
    return LevelAblation(
        "constant-torque", "paper-labelled", order, "links", names, time, fine, fine + 1e-6
    )


def test_shares_sum_to_one_and_uncertainty_is_three_times_the_change():
    made = _ladder({"masses": 3.0, "coupling": -1.0})
    assert sum(made.shares(-1, 0).values()) == pytest.approx(1)
    np.testing.assert_allclose(made.uncertainty, 3e-6)


def test_what_a_level_leaves_is_the_rungs_above_it():
    made = _ladder({"masses": 3.0, "diagonal": 0.5, "coupling": 0.25, "error": 0.125})
    sizes = {
        level: made.start_at_level(level).total[-1, 0] for level in ("links", "carriers", "coupled")
    }
    assert sizes == {"links": 3.875, "carriers": 0.875, "coupled": 0.125}
    assert made.start_at_level("carriers").names[0] == "diagonal"


@pytest.mark.parametrize(("share", "name"), [(0.91, "meshes"), (0.89, "none alone")])
def test_dominant_on_both_sides_of_the_threshold(share, name):
    first, *_ = compute_deviations(_ladder({"backlash": share, "slips": 1 - share}))
    assert first.dominant == name


@pytest.mark.parametrize(
    ("theta_2", "fits"), [(0.0149, True), (-0.0149, True), (0.0151, False), (0.0049, False)]
)
def test_fits_by_the_size_in_the_claims_limits(theta_2, fits):
    found = compute_residuals(
        compute_baseline_deviations([_ladder({"diagonal": theta_2})]), _claims()
    )
    assert {one.fits["theta_2"] for one in found if one.level == "carriers"} == {fits}


def test_the_tip_is_held_against_its_claim_in_millimetres():
    (links, *_) = compute_residuals(
        compute_baseline_deviations([_ladder({"masses": 0.03})]), _claims()
    )
    assert links.fits == {"theta_1": False, "theta_2": False, "tip": True}


def _claims():
    return {quantity: BY_ID[name] for quantity, name in CLAIMS.items()}


@pytest.mark.parametrize(
    ("rest", "h2", "paper"),
    [
        ({"diagonal": 0.01}, True, False),
        ({"diagonal": 0.005, "slips": 0.005}, False, False),
        ({"backlash": 0.01}, False, True),
    ],
)
def test_the_verdict_is_about_what_the_fitting_level_leaves(rest, h2, paper):
    ladder = _ladder({"masses": 1.0, **rest})
    verdict = judge_ablation(
        compute_baseline_deviations([ladder]), compute_deviations(ladder), Limits(0.008, 0.012)
    )
    assert verdict.fitting[0] in ("carriers", "armature", "coupled")
    assert "links" not in verdict.fitting
    assert (verdict.holds, verdict.papers) == (h2, paper)
    assert verdict.causes == ("masses",)


def test_nothing_is_decided_where_no_level_fits():
    ladder = _ladder({"masses": 1.0})
    verdict = judge_ablation(
        compute_baseline_deviations([ladder]), compute_deviations(ladder), Limits(0.008, 0.012)
    )
    assert (verdict.fitting, verdict.holds) == ((), None)


def test_what_is_said_is_what_fits():
    found = compute_residuals(compute_baseline_deviations([_ladder({"diagonal": 0.01})]), _claims())
    stated = {(one.place.choice, one.quantity): one.state for one in of_ladder(found, _claims())}
    assert stated["carriers", "constant torque: deviation_2_carriers_rad"] == State.YES
    assert stated["coupled", "constant torque: deviation_2_coupled_rad"] == State.NO

"""The levels from the rigid arm to the detailed one: closing sums and verdicts."""

import numpy as np
import pytest

from crosscheck.audit.findings.baselines import (
    BaselineFinding,
    RigidResidual,
    compute_contributions,
    measure_residual,
)
from crosscheck.audit.judging.rule import State
from crosscheck.registry import RIGID_LEVELS
from tests.audit.stated import of_ladder


def test_contributions_close_on_the_whole_deviation():
    places = list(np.random.default_rng(0).normal(size=(4, 5, 4)))
    steps = compute_contributions(places)
    whole = places[-1] - places[0]
    np.testing.assert_allclose(steps[:, :, :2].sum(axis=0), whole[:, :2], atol=1e-14)
    np.testing.assert_allclose(steps[:, :, 2].sum(axis=0), np.linalg.norm(whole[:, 2:], axis=1))


STEPS = ("masses", "diagonal", "coupling", "meshes", "slips", "clock")


def _residuals(values: dict[str, float]) -> list[RigidResidual]:
    """What every level leaves if the changes of the model add this much to every quantity."""
    steps = np.array([values.get(name, 0.0) for name in STEPS])[:, None, None] * np.ones((1, 2, 3))
    return [measure_residual("paper-labelled", level, steps) for level in RIGID_LEVELS]


def test_what_a_level_leaves_is_the_changes_above_it():
    found = _residuals({"masses": 3.0, "diagonal": 0.5, "coupling": 0.25, "meshes": 0.125})
    assert {one.level: one.totals["theta_1"] for one in found} == {
        "links": 3.875, "carriers": 0.875, "armature": 0.375, "coupled": 0.125
    }  # fmt: skip
    assert all(sum(one.shares["theta_1"].values()) == pytest.approx(1) for one in found)


@pytest.mark.parametrize(
    ("theta_2", "fits"), [(0.0149, True), (-0.0149, True), (0.0151, False), (0.0049, False)]
)
def test_fits_by_the_size_in_the_claims_limits(theta_2, fits):
    found = _residuals({"diagonal": theta_2})
    assert {one.fits["theta_2"] for one in found if one.level == "carriers"} == {fits}


def test_the_tip_is_held_against_its_claim_in_millimetres():
    (links, *_) = _residuals({"masses": 0.03})
    assert links.fits == {"theta_1": False, "theta_2": False, "tip": True}


@pytest.mark.parametrize(
    ("rest", "inertia", "meshes"),
    [
        ({"diagonal": 0.01}, True, 0.0),
        ({"diagonal": 0.005, "slips": 0.005}, False, 0.0),
        ({"meshes": 0.01}, False, 1.0),
    ],
)
def test_the_verdict_is_about_what_the_fitting_level_leaves(rest, inertia, meshes):
    verdict = BaselineFinding(tuple(_residuals({"masses": 1.0, **rest})))
    assert verdict.fitting[0] in ("carriers", "armature", "coupled")
    assert "links" not in verdict.fitting
    assert (verdict.holds, verdict.most_meshes) == (inertia, meshes)


def test_nothing_is_decided_where_no_level_fits():
    verdict = BaselineFinding(tuple(_residuals({"masses": 1.0})))
    assert (verdict.fitting, verdict.holds) == ((), None)


def test_the_nearest_baseline_is_the_one_that_leaves_the_papers_theta_2():
    found = BaselineFinding(tuple(_residuals({"masses": 1.0, "diagonal": 0.01})))
    assert found.nearest is not None
    assert found.nearest.level == "carriers"
    assert not found.gives_all
    assert BaselineFinding(tuple(_residuals({"masses": 1.0}))).nearest is None


def test_what_is_said_is_what_fits():
    found = _residuals({"diagonal": 0.01})
    stated = {(one.place.choice, one.quantity): one.state for one in of_ladder(found)}
    assert stated["carriers", "constant torque: deviation_2_carriers_rad"] == State.YES
    assert stated["coupled", "constant torque: deviation_2_coupled_rad"] == State.NO

"""The uncertainty of a run covers its error, wherever in a step its teeth meet."""

from collections.abc import Iterator

import pytest
import xarray as xr

from crosscheck.checks.scales import acceptance_limit
from crosscheck.checks.trajectories import largest_difference, size, uncertainty
from crosscheck.models.arm.arm import Arm
from crosscheck.planning import plan
from crosscheck.planning.plan import (
    COARSE_STEP_RATIOS,
    CrossCheckRequest,
    Experiment,
    draft_experiments,
    set_stable_step,
)
from crosscheck.planning.preparation import refine_until_resolved
from crosscheck.planning.sizing import compute_sizes
from crosscheck.registry import build, reference_model
from tests.arms import PAPER, random_arm
from tests.loops import require_items

RENAMED = PAPER.model_copy(update={"name": "probe"})  # its experiments are sized, not the paper's


def pd_motion(arm: Arm) -> Experiment:
    """The sized motion, cut short, at the step that a cross-check finds."""
    wanted = CrossCheckRequest(arm, quick=True)
    outline = draft_experiments(wanted, compute_sizes(arm))
    limit = build(reference_model(), *outline[0].case).largest_stable_step()
    return refine_until_resolved(wanted, set_stable_step(outline[1], limit))


def runs_of(experiment: Experiment) -> Iterator[xr.Dataset]:
    """The reference model's run, and those at coarser steps."""
    for variant in ("", *COARSE_STEP_RATIOS):
        yield build(reference_model(), *experiment.run(reference_model(), variant).case).simulate()


@pytest.mark.parametrize(
    ("arm", "quantity"),
    [(RENAMED, "theta"), (random_arm(8, 2, True), "x_sp"), (random_arm(20, 2, True), "x_pr")],
)
def test_several_coarser_runs_cover_an_error_that_one_misses(arm, quantity, monkeypatch):
    monkeypatch.setattr(plan, "QUICK_STEPS", 1000)
    experiment = pd_motion(arm)
    exact = build(reference_model(), *experiment.case).precise(1e-12)
    fine, *coarser = runs_of(experiment)
    error = largest_difference(fine, exact, quantity)
    by_each = [uncertainty(fine, run, quantity) for run in coarser]
    assert by_each[0] < error <= max(by_each)


def test_a_step_means_something_by_each_of_the_coarser_runs():
    """Of a shoulder with four planets one coarser run is close to the fine one by chance."""
    teeth = {"sun_teeth": 28, "planet_teeth": 36, "ring_teeth": 100, "planet_count": 4}
    shoulder, elbow = PAPER.joints
    four = shoulder.model_copy(update=teeth)
    experiment = pd_motion(PAPER.model_copy(update={"name": "four", "joints": (four, elbow)}))
    fine, *coarser = runs_of(experiment)
    for coarse in require_items(coarser):
        for quantity in ("theta", "x_sp", "x_pr"):
            widest = acceptance_limit(quantity, *experiment.case[:2], size(fine, quantity))
            assert uncertainty(fine, coarse, quantity) < widest.value

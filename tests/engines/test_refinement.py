"""The uncertainty of a run covers its error, wherever in a step its teeth meet."""

import pytest

from crosscheck.checks.trajectories import largest_difference, uncertainty
from crosscheck.models.arm.arm import Arm
from crosscheck.planning import plan
from crosscheck.planning.plan import FEWER, Experiment, Wanted, outlined, resolved
from crosscheck.planning.preparation import settled
from crosscheck.planning.sizing import sizes_of
from crosscheck.registry import build, reference_model
from tests.arms import PAPER, random_arm

RENAMED = PAPER.model_copy(update={"name": "probe"})  # its experiments are sized, not the paper's


def pd_motion(arm: Arm) -> Experiment:
    """The sized motion, cut short, at the step that a cross-check finds."""
    wanted = Wanted(arm, quick=True)
    outline = outlined(wanted, sizes_of(arm))
    limit = build(reference_model(), *outline[0].case).largest_stable_step()
    return settled(wanted, resolved(outline[1], limit))


@pytest.mark.parametrize(
    ("arm", "quantity"),
    [(RENAMED, "theta"), (random_arm(8, 2, True), "x_sp"), (random_arm(20, 2, True), "x_pr")],
)
def test_several_coarser_runs_cover_an_error_that_one_misses(arm, quantity, monkeypatch):
    monkeypatch.setattr(plan, "QUICK_STEPS", 1000)
    experiment = pd_motion(arm)
    exact = build(reference_model(), *experiment.case).precise(1e-12)
    fine, *coarser = (
        build(reference_model(), *experiment.run(reference_model(), variant).case).simulate()
        for variant in ("", *FEWER)
    )
    error = largest_difference(fine, exact, quantity)
    by_each = [uncertainty(fine, run, quantity) for run in coarser]
    assert by_each[0] < error <= max(by_each)

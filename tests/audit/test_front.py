"""The page's beginning: its sentences follow its numbers."""

from itertools import product

import numpy as np
import pytest

from crosscheck.analytic.model import PhysicalModel
from crosscheck.analytic.paper.model import PrintedModel
from crosscheck.audit.errata.engine_comparison import PrintedEquationsQuestion
from crosscheck.audit.experiments import paper_conditions
from crosscheck.audit.experiments.scale import Scale
from crosscheck.audit.experiments.study import Study
from crosscheck.audit.front.chapter import (
    MODELS,
    BaselineFinding,
    StartsStrip,
    ThirdFluctuationFinding,
    draw_third_fluctuations,
)
from crosscheck.audit.front.terms import count_teeth, draw_stage
from crosscheck.audit.hypotheses.evidence import level_ablation
from crosscheck.audit.hypotheses.h2_ablation import claims
from crosscheck.audit.measures.stage import paper_stage
from crosscheck.audit.measures.third_fluctuation import ThirdFluctuation
from crosscheck.audit.measures.thresholds import SEVERE
from crosscheck.audit.page.context import AuditContext
from crosscheck.models.loading import load_arm, load_case

NONE = np.full(10, np.nan)


def thirds(severe: dict[paper_conditions.Law, int]) -> ThirdFluctuationFinding:
    """Ten starts of every law; so many are severe with free planets, none with planets alike."""
    return ThirdFluctuationFinding(0.005, tuple(_strip(cell, severe) for cell in _cells()))


def _cells() -> list[paper_conditions.Condition]:
    return [
        paper_conditions.Condition(law, 0.005, planets=planets)
        for law, planets in product(paper_conditions.LAWS, MODELS)
    ]


def _strip(
    cell: paper_conditions.Condition, severe: dict[paper_conditions.Law, int]
) -> StartsStrip:
    count = severe.get(cell.law, 0) if cell.planets == "free" else 0
    sizes = np.where(np.arange(10) < count, 2 * SEVERE, 1.0)
    return StartsStrip(cell, ThirdFluctuation(sizes, NONE, NONE, NONE, 0))


@pytest.mark.parametrize(
    ("severe", "needs"),
    [
        ({}, False),  # nowhere: nothing to explain
        ({paper_conditions.PRINTED: 10}, True),
        ({paper_conditions.REPAIRED_RATE: 5}, True),
        ({paper_conditions.PRINTED: 1}, False),  # one of ten may be none
        ({paper_conditions.PRINTED: 10, paper_conditions.INTEGRAL: 1}, True),
        ({paper_conditions.PRINTED: 10, paper_conditions.INTEGRAL: 4}, False),
        ({paper_conditions.INTEGRAL: 10}, False),
    ],
)
def test_the_third_fluctuation_needs_the_clock_only_if_it_is_nowhere_without(severe, needs):
    found = thirds(severe)
    assert found.needs_clock is needs
    share = found.share(paper_conditions.PRINTED, "free")
    assert share is not None
    assert share.yes == severe.get(paper_conditions.PRINTED, 0)


def test_every_start_is_drawn():
    one, more = (thirds({paper_conditions.PRINTED: count}) for count in (0, 10))
    assert draw_third_fluctuations(one) != draw_third_fluctuations(more)
    assert draw_third_fluctuations(one) == draw_third_fluctuations(one)


def test_the_printed_equations_are_off_by_what_the_derivation_says():
    """M beside Pinocchio over 200 random states; here beside the derivation over the elbow's turn.

    No state can be further off than the worst pose, and of 200 one comes within 2 % of it.
    """
    found = PrintedEquationsQuestion(paper_conditions.LABELLED, 0.002).answer()
    case = load_case(paper_conditions.LABELLED, "pd", None, [])
    models, worst = (PrintedModel(*case), PhysicalModel(*case)), 0.0
    for elbow in np.linspace(0, 2 * np.pi, 721):
        q = np.array([0, 0, 0, 0, 0, elbow])
        printed, right = (model.mass_matrix(q) for model in models)
        size = np.sqrt(np.outer(np.diag(printed), np.diag(printed)))
        worst = max(worst, float((np.abs(printed - right) / size).max()))
    assert found.mass_matrix is not None
    assert 0.98 * worst < found.mass_matrix <= worst * (1 + 1e-6)  # the grid is this fine
    assert found.acceleration is not None
    assert found.acceleration > found.mass_matrix
    assert all(run.duration_s == 0.002 and run.F_sp_N > 0 for run in found.runs.values())


def _left(level: str, theta_1: float, theta_2: float, tip: float) -> level_ablation.RigidResidual:
    """fits: by what rounds to the paper's digits."""
    sizes = {"theta_1": theta_1, "theta_2": theta_2, "tip": tip}
    found = {
        name: level_ablation.Deviation(
            paper_conditions.LABELLED,
            level_ablation.TORQUE,
            "A",
            level,
            name,
            "largest",
            0.5,
            size,
            (),
            {},
        )
        for name, size in sizes.items()
    }
    fits = {name: claim.limits for name, claim in claims().items()}
    return level_ablation.RigidResidual(
        paper_conditions.LABELLED, level, found, {n: one.fits(fits[n]) for n, one in found.items()}
    )


def test_the_baseline_is_the_one_that_leaves_the_papers_theta_2():
    verdict = level_ablation.AblationVerdict((), {}, {}, ())
    links, last = _left("links", 0.1, 0.4, 0.2), _left("coupled", 2e-7, 1.3e-6, 1e-6)
    carriers, all_three = _left("carriers", 2e-3, 0.013, 8e-3), _left("x", 0.02, 0.01, 0.03)
    assert BaselineFinding((links, carriers, last), verdict, 1.6).nearest is carriers
    assert BaselineFinding((links, last), verdict, None).nearest is None
    assert not BaselineFinding((links, carriers, last), verdict, 1.6).gives_all
    assert BaselineFinding((links, all_three), verdict, 1.6).gives_all


@pytest.mark.parametrize(
    ("return_s", "as_read"), [(1.62, True), (1.36, True), (1.7, False), (1.3, False), (None, None)]
)
def test_the_return_is_the_papers_within_a_tenth(return_s, as_read):
    """The same limits as claim 3.2-20's, so that finding and claim cannot differ by them."""
    verdict = level_ablation.AblationVerdict((), {}, {}, ())
    assert BaselineFinding((), verdict, return_s).returns_as_read is as_read


def test_teeth_pass_as_the_motion_says(tmp_path):
    """Both rates are those of the two counts; at the start neither has counted."""
    passed = count_teeth(AuditContext(Study(tmp_path), Scale(longest_s=0.2)))
    inner = slice(5, -5)
    for count, rate in ((passed.angle, passed.rate), (passed.clock, passed.clock_rate)):
        assert count[0] == 0
        found = np.gradient(count, passed.time)
        assert found[inner] == pytest.approx(rate[inner], abs=2e-3 * np.abs(rate).max())


def test_a_stage_has_all_its_teeth():
    joint = paper_stage(load_arm(paper_conditions.LABELLED)).joint
    outlines = joint.sun_teeth + joint.planet_count * joint.planet_teeth + joint.ring_teeth
    circles = 2 + joint.planet_count
    assert draw_stage(joint).count('id="patch_') >= outlines + circles

"""The rigid arms beside the detailed one: what their answers decide."""

import pytest

from crosscheck.audit.claims.catalogue import BY_ID
from crosscheck.audit.experiments.paper_conditions import AS_MODELLED, READINGS, Condition
from crosscheck.audit.figures.figure_data import ZETA
from crosscheck.audit.findings.baselines import LABELS, BaselineFinding, compare_baselines
from crosscheck.audit.judging.judgement import ClaimJudgement
from crosscheck.audit.judging.rule import Answer, Place
from crosscheck.registry import RIGID_LEVELS

FIT = (0.02, 0.01, 30.0)  # the paper's, in the order of LABELS
LINKS = (0.1, 0.4, 250.0)


def _compare(**left: tuple[float, float, float]) -> BaselineFinding:
    """What these levels leave, in both readings; all others leave the links' amount."""
    judged = {}
    for place, (name, claim) in enumerate((name, BY_ID[name]) for name in LABELS):
        answers = [
            Answer(Place(_conditions(arm, zeta), level), (value,), 1, claim.limits)
            for arm in READINGS
            for level in RIGID_LEVELS
            for zeta, value in ((ZETA, left.get(level, LINKS)[place]), (0.1, FIT[place]))
        ]
        judged[name] = ClaimJudgement(claim, tuple(answers))
    return compare_baselines(judged)


def _conditions(arm, zeta):
    where = Condition(AS_MODELLED.law, zeta, arm, AS_MODELLED.planets, AS_MODELLED.equations)
    return tuple(where.conditions.items())


def test_one_arm_must_leave_all_three_numbers():
    assert _compare(carriers=FIT).gives_all
    for place in range(3):
        off = tuple(2 * x if at == place else x for at, x in enumerate(FIT))
        assert not _compare(carriers=off).gives_all


@pytest.mark.parametrize(
    ("theta_2", "level"), [(0.0149, "carriers"), (0.0151, None), (0.0051, "carriers")]
)
def test_the_nearest_is_the_first_that_leaves_the_papers_theta_2(theta_2, level):
    nearest = _compare(carriers=(0.001, theta_2, 8.0)).nearest
    assert (nearest and nearest.level) == level
    assert nearest is None or nearest.size("3.1-02") == theta_2


@pytest.mark.parametrize(("share", "is_inertia"), [(1e-4, True), (0.099, True), (0.11, False)])
def test_it_is_inertia_if_next_to_nothing_is_the_meshes(share, is_inertia):
    tip_alone = (2e-6, 1e-6, share * 30.0)
    found = _compare(carriers=FIT, coupled=tip_alone)
    assert found.most_meshes == pytest.approx(max(share, 1e-4))
    assert found.is_inertia is is_inertia


def test_nothing_is_decided_where_no_level_fits():
    found = _compare()
    assert (found.fitting, found.nearest, found.is_inertia) == ((), None, None)
    assert not found.gives_all

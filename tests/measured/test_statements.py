"""From which size on something is named of a recording: each limit by SciPy's distributions."""

from dataclasses import replace

import numpy as np
import pytest

from crosscheck.identification.bandwidth import BandResult, combine_bands
from crosscheck.identification.compare import find_threshold
from crosscheck.identification.estimation import fit_linear
from crosscheck.identification.terms import TermEstimate, TorqueTerm
from tests.measured.robots import arm, both_sides, recording

LEVEL = 1e-4  # of all that is named of a side, as the how-to says
ARMATURE = TorqueTerm("armature", "j1", "kg m^2")


def test_a_joint_is_worse_beyond_fishers_chance():
    from scipy.stats import f  # slow to import, in every process that collects tests

    robot = arm()
    identified, scaled = both_sides(robot, recording(robot, "links", seconds=8.0))
    further, left, joints = 6.0, 30.0, len(identified.measured)
    fit = replace(identified.fit, taken=scaled.fit.taken + further, left=np.full(joints, left))
    identified = replace(identified, fit=fit)
    limit = np.sqrt(1 + further / left * f.ppf(1 - LEVEL / joints, further, left))
    for by, joints_worse in ((0.999, ()), (1.001, identified.measured)):
        last = scaled.steps[-1]._replace(rms=by * limit * identified.steps[-1].rms)
        worse = replace(scaled, steps=(*scaled.steps[:-1], last)).find_worse_joints(identified)
        assert tuple(worse) == tuple(joints_worse)


@pytest.mark.parametrize(
    ("apart", "systematic"), [(2.9, 0.0), (5.0, 4.0)], ids=["as noise may be", "more"]
)
def test_what_bands_are_apart_beyond_the_wider_interval_is_an_error(apart, systematic):
    """5^2 = 3^2 + 4^2, of which 3 is the other band's half width."""
    here, there = TermEstimate(ARMATURE, 0.0, 1.0, 2.0), TermEstimate(ARMATURE, apart, 1.5, 3.0)
    (each,) = combine_bands([here], 2.0, [BandResult(1.0, (there,))])
    assert (each.systematic, each.error) == pytest.approx((systematic, np.hypot(1, systematic)))
    assert each.half_width == pytest.approx(2 * np.hypot(1, systematic))


@pytest.mark.parametrize(("sure", "others"), [((), 3), ((1e3,), 2), ((1e3, -1e3), 1)])
def test_what_is_sure_is_none_of_those_that_chance_may_name(sure, others):
    """Holm's steps: the level is shared by those that are left."""
    from scipy.stats import t  # slow to import, in every process that collects tests

    torque = np.random.default_rng(0).standard_normal((600, 1))
    fit = fit_linear(np.ones((600, 1, 1)), torque, np.ones((600, 1), dtype=bool), (0, 600))
    values = (*sure, *[0.5] * (3 - len(sure)))
    estimates = tuple(TermEstimate(ARMATURE, value, 1.0, 2.0) for value in values)
    expected = t.ppf(1 - LEVEL / (2 * others), fit.freedom)
    assert find_threshold(estimates, fit) == pytest.approx(expected, rel=1e-9)

"""Limits of what recordings are said to tell, just within and just beyond; ends of signals."""

from dataclasses import replace

import numpy as np
import pytest

from crosscheck.identification import bodies, engines
from crosscheck.identification.mechanism import SpatialRobot
from crosscheck.identification.refinement import Knowledge, LevelFit, PossibleBodies, Refinement
from crosscheck.identification.sampling import continue_signal
from crosscheck.identification.structure import draw_samples
from crosscheck.planning.comparison import Results
from tests.loops import require_items
from tests.measured import robots
from tests.robots import chains

LIKELIER = 9.21034  # twice the logarithm of 100
UNUSUAL = 29.588  # of chi squared with 10 degrees of freedom: one in a thousand is above (tables)


def test_a_line_goes_on_as_a_line():
    """Turned about its ends a signal keeps value and slope there, so no filter sees a step."""
    time = np.arange(-3.0, 14.0)[:, None]
    lines = np.hstack([time, 5 - 2 * time])
    assert continue_signal(lines[3:-4], 3, 4) == pytest.approx(lines)


def level_fit(level: str, chi_squared: float, surprise: float = 0.0, excess: float = 0.0):
    """A fit of ten links' parameters that came to rest."""
    possible = PossibleBodies(excess, (), ())
    return LevelFit(level, chi_squared, surprise, (), np.ones(10), 10, (), True, possible)


@pytest.mark.parametrize(
    ("apart", "surprise", "excess", "level"),
    [
        (LIKELIER + 0.01, 0.0, 0.0, "coupled"),
        (LIKELIER - 0.01, 0.0, 0.0, None),
        (20.0, UNUSUAL - 0.01, LIKELIER - 0.01, "coupled"),
        (20.0, UNUSUAL + 0.01, 0.0, None),
        (20.0, 0.0, LIKELIER + 0.01, None),
    ],
)
def test_a_level_is_named_where_it_is_a_hundred_times_likelier(apart, surprise, excess, level):
    fits = (level_fit("armature", 500 + apart), level_fit("coupled", 500, surprise, excess))
    found = Refinement(Knowledge(0.5, are_possible=True), fits)
    assert found.level == level
    assert found.is_decided == (level is not None)
    assert not replace(found, fits=(replace(fits[0], settled=False), fits[1])).is_decided


def test_bodies_without_mass_and_thin_ones_are_at_the_border():
    """A cube of 12 kg and 1 m has second moments of 1 kg m^2 along each axis, and three in all."""
    cube = np.array([12.0, 0, 0, 0, 2.0, 0, 2.0, 0, 0, 2.0])
    scale = bodies.find_scale(np.tile(cube, 3))
    sheet = np.array([12.0, 0, 0, 0, 1.0, 0, 1.0, 0, 0, 2.0])
    worse = np.array([12.0, 0, 0, 0, 1.0, 0, 1.0, 0, 0, 2.3])
    found = bodies.find_thickness(np.concatenate([cube, sheet, worse]), scale)
    assert found == pytest.approx([1 / 3, 0.0, -0.05])
    light = np.concatenate([0.1 * cube, 0 * cube, cube])
    light[0] = 0.12
    assert bodies.find_thickness(light, scale)[:2] == pytest.approx([0.01, 0.0])


def test_what_has_no_mass_or_size_is_as_the_others_are():
    """Mass by all links, size by those that have one: a cube's of 12 kg and 1 m."""
    cube, point = np.array([12.0, 0, 0, 0, 2.0, 0, 2.0, 0, 0, 2.0]), 6.0 * np.eye(10)[0]
    point[4] = -1e-18  # as rounding leaves
    scale = bodies.find_scale(np.concatenate([cube, 0 * cube, point]))
    assert scale.mass == pytest.approx([12.0, bodies.LIGHTEST * 6.0, 6.0])
    assert scale.radius == pytest.approx([0.5, 0.5, 0.5])
    assert bodies.find_scale(point).radius.tolist() == [1.0]


@pytest.mark.parametrize(("factor", "verdict"), [(1 + 1e-12, "agree"), (1 + 1e-9, "differ")])
def test_an_engine_that_is_wrong_is_flagged(factor, verdict):
    """Of torques that have no larger terms than themselves: of a body in uniform gravity."""
    own = SpatialRobot(robots.arm())
    rng = np.random.default_rng(0)
    motion = tuple(rng.uniform(-2, 2, (30, 3)) for _ in range(3))
    planned = engines.plan_level(own, own.levels[0], motion)
    (regressor,) = (each for each in planned if each.about.key.right == "regressor:links")
    expected, given = (task.perform() for task in regressor.needs)
    apart = np.where(np.abs(given) > np.abs(given).max() / 2, factor, 1.0)
    results = Results({regressor.needs[0].key: expected, regressor.needs[1].key: apart * given})
    assert regressor.finding(results).verdict == verdict


def test_engines_may_round_a_torque_that_has_no_terms():
    own = SpatialRobot(replace(robots.arm(), gravity=np.zeros(3)))
    planned = next(engines.plan_level(own, own.levels[0], (np.ones((1, 3)), *np.zeros((2, 1, 3)))))
    answers = {each.key: 1e-14 * place for place, each in enumerate(planned.needs)}
    assert planned.finding(Results(answers)).verdict == "agree"


def test_engines_are_asked_along_the_whole_recording():
    own = SpatialRobot(chains.robot(chains.BOB))
    samples = draw_samples(own.robot, np.zeros((0, 1)))
    comparisons = engines.plan_level(own, own.levels[0], (samples.q, samples.v, samples.a))
    for task in require_items(task for each in comparisons for task in each.needs):
        assert task.motion[0] == pytest.approx(samples.q)

"""Links that are possible bodies: what they decide where coupled and armature are one model."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

from crosscheck.identification import bodies, messages
from crosscheck.identification.refinement import Knowledge
from crosscheck.models.robot.identity import find_identity_joints
from crosscheck.models.robot.robot import Robot
from tests.loops import require_items
from tests.measured.robots import RATIO, ROTOR, arm, recording
from tests.measured.second_bodies import fit_possible, pseudo_inertia
from tests.measured.unknowns import SECONDS, refine_alone

LOOSE = 0.5


def thin_arm(thickness: float = 0.001) -> Robot:
    """The arm whose last link turns about its joint with less inertia than J N, which is 0.006."""
    given = arm()
    text = given.urdf.replace('<inertia ixx="0.01"', f'<inertia ixx="{thickness}"')
    assert text != given.urdf
    return arm(text)


@pytest.fixture(scope="module")
def armature():
    """A thin arm, a recording of its armature, and what possible bodies say of it."""
    robot = thin_arm()
    given = recording(robot, "armature", seconds=SECONDS)
    return robot, given, *refine_alone(robot, given, Knowledge(LOOSE, are_possible=True))


def test_a_logarithm_is_what_pinocchio_calls_so():
    rows = np.random.default_rng(0).normal(scale=0.4, size=(2, 10))
    values, slopes = bodies.compute_parameters(rows.ravel())
    theirs = [pin.LogCholeskyParameters(row) for row in rows]
    assert values == pytest.approx(np.concatenate([each.toDynamicParameters() for each in theirs]))
    for number, each in enumerate(theirs):
        part = slice(10 * number, 10 * number + 10)
        assert slopes[part, part] == pytest.approx(each.calculateJacobian(), abs=1e-12)
    assert np.count_nonzero(slopes[:10, 10:]) == 0


def test_curvature_is_the_slope_of_slopes():
    rng = np.random.default_rng(1)
    at, along = rng.normal(scale=0.4, size=20), rng.normal(size=20)
    step = 1e-5
    rows = [
        along @ (bodies.compute_parameters(at + way)[1] - bodies.compute_parameters(at - way)[1])
        for way in step * np.eye(20)
    ]
    right = np.array(rows) / (2 * step)
    assert bodies.compute_curvature(at, along) == pytest.approx(right, abs=1e-7)


def test_a_possible_body_comes_back_from_its_logarithms():
    rows = np.random.default_rng(2).normal(scale=0.4, size=30)
    values, _ = bodies.compute_parameters(rows)
    assert bodies._find_logarithms(values, bodies.find_scale(values)) == pytest.approx(rows)


def test_away_from_the_border_bodies_are_least_squares(monkeypatch):
    """Values and errors are then those of unknowns that no body holds."""
    rng = np.random.default_rng(3)
    is_link = np.repeat([False, True, False], (1, 20, 1))
    truth, slopes = rng.normal(size=22), rng.normal(size=(90, 22))
    rows = rng.normal(scale=0.3, size=20)
    truth[is_link], state = bodies.compute_parameters(rows)[0], truth.copy()
    state[is_link] = bodies.compute_parameters(rows + 0.02)[0]
    state[~is_link] += 0.5
    found = bodies.solve_bodies(slopes @ (truth - state), slopes, state, is_link)
    assert found.state == pytest.approx(truth, abs=1e-7)
    errors = np.sqrt(np.diag(np.linalg.inv(slopes.T @ slopes)))
    assert found.errors == pytest.approx(errors, rel=1e-6)
    monkeypatch.setattr(bodies, "MOST_PASSES", 1)
    assert not bodies.solve_bodies(slopes @ (truth - state), slopes, state, is_link).settled


def test_possible_bodies_decide_where_links_known_to_a_half_do_not(armature):
    robot, given, _, found = armature
    assert find_identity_joints(robot) == ["j1", "j2", "j3"]
    assert refine_alone(robot, given, Knowledge(LOOSE))[1].level is None
    assert found.level == "armature"
    assert found.is_decided
    own, moved = found.fits
    assert own.bodies.explain
    assert own.bodies.excess == pytest.approx(0.0, abs=1e-6)
    assert (own.bodies.impossible, own.bodies.border) == ((), ())
    assert not moved.bodies.explain
    assert (moved.bodies.impossible, moved.bodies.border) == (("j3",), ("j3",))
    words = " ".join(messages._describe_refinement(found, "torques"))
    assert "At armature possible bodies explain the torques" in words
    assert "those moved by j3 would be impossible" in words


def test_where_one_fit_does_not_settle_nothing_is_said(armature):
    first, *others = armature[3].fits
    unsettled = replace(armature[3], fits=(replace(first, settled=False), *others))
    (line,) = messages._describe_refinement(unsettled, "torques")
    assert line.endswith("the fit does not converge.")


def test_possible_bodies_of_either_level_decide_nothing():
    """Truth is coupled: as armature the last link has J N more, and is a body all the same."""
    robot = thin_arm()
    given = recording(robot, "coupled", seconds=SECONDS)
    found = refine_alone(robot, given, Knowledge(LOOSE, are_possible=True))[1]
    assert found.level is None
    assert all(fit.bodies.explain and fit.bodies.border == () for fit in found.fits)


@pytest.mark.parametrize("level", ["armature", "coupled"])
def test_a_second_program_has_the_same_bodies(armature, level):
    """Alternating directions rest to 1e-10 of a body's size, so chi squared agrees to 1e-6."""
    robot, given, bandwidth, found = armature
    (fit,) = (each for each in found.fits if each.level == level)
    ratios = [RATIO] * 3 if level == "coupled" else None
    chi_squared, links, others = fit_possible(robot.urdf, given, bandwidth, LOOSE, ratios)
    assert fit.chi_squared == pytest.approx(chi_squared, abs=1e-6)
    rotors = [each for each in fit.estimates if each.term.kind in ("armature", "rotors")]
    for each, value in zip(rotors, others[9:12], strict=True):
        assert abs(each.value - value) < 1e-3 * each.error
    for own, second in zip(fit.links.reshape(-1, 10), links.reshape(-1, 10), strict=True):
        least, *_, largest = np.linalg.eigvalsh(pseudo_inertia(own))
        assert least > -1e-15 * largest
        size = np.abs(second).max()
        assert own == pytest.approx(second, abs=1e-3 * size)


def test_rotors_of_possible_bodies_are_those_of_truth(armature):
    estimates = armature[3].best.estimates
    for each in require_items(one for one in estimates if one.term.kind == "armature"):
        assert abs(each.value - RATIO**2 * ROTOR) < 1.5 * each.half_width

"""Every number of `cost` beside a second program's, and of its pictures beside the record's."""

import json
from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest

from crosscheck.checks.robot_states import compute_sizes, sample_states
from crosscheck.cost import output, shortcuts
from crosscheck.cost.meshes import motor_torques, tip_distances
from crosscheck.cost.motion import describe_passive
from crosscheck.cost.shortcuts import ShortcutCosts
from crosscheck.models.robot.file import load_robot
from crosscheck.registry import build_robot_model
from tests.robots import chains, two_link
from tests.robots.cost_guard import FILES, found_cost, robot, wrong_motion, wrong_numbers, wrong_tip
from tests.robots.cost_views import wrong_picture


@lru_cache
def found(name: str) -> ShortcutCosts:
    """A robot's cost; engines are compared on one of them."""
    if name == "oblique":
        return found_cost(name, engines=True)
    return replace(found_cost(name), agreement=found("oblique").agreement)


@pytest.mark.parametrize("name", FILES)
def test_a_second_program_finds_the_same_numbers(name):
    assert list(wrong_numbers(name, found(name))) == []
    assert list(wrong_tip(name)) == []


@pytest.mark.parametrize("name", FILES)
def test_pictures_show_the_numbers_of_the_record(name):
    assert list(wrong_picture(found(name))) == []


def test_tolerances_of_what_is_solved_for_are_of_the_worst_pose():
    """Eigenvalues of [[1, c], [c, 1]] are 1 + c and 1 - c."""
    masses = np.array([[[4.0, 2 * c], [2 * c, 1.0]] for c in (0.5, 0.9, 0.2)])
    own = robot("staged")
    assert compute_sizes(own, masses, sample_states(own, 3, 0)).condition == pytest.approx(19.0)


@pytest.mark.parametrize("seed", range(3))
def test_a_motion_uses_its_ranges_rates_and_efforts_whole(seed):
    for own in (robot("oblique"), load_robot("six-joint"), load_robot("sliding")):
        assert list(wrong_motion(own, seed)) == []


def test_a_joint_that_cannot_bear_its_weight_slows_no_motion():
    """Its weight asks for more than its effort on one side alone."""
    own = robot("oblique")
    first = own.joints[0]
    weak = replace(first, limits=replace(first.limits, effort=5.0))
    unlimited = replace(first, limits=replace(first.limits, effort=np.inf))
    for joint in (weak, unlimited):
        assert list(wrong_motion(replace(own, joints=(joint, *own.joints[1:])), 0)) == []


def test_where_programs_differ_no_view_tells_a_cost():
    right = found("oblique")
    worst = replace(right.agreement[0], measured=2e-3, verdict="differ")
    own = replace(right, agreement=(worst, *right.agreement[1:]))
    said = list(output.describe_answers(own))
    assert "mass matrix of links: analytic and pinocchio by 2.0e-03" in said[1]
    assert not any("N m" in line or "%" in line for line in output.describe_result(own))
    data = json.loads(output.cost_json(own))
    assert (data["answers"], data["engines_agree"]) == (said, False)
    assert {"shortcuts", "feed_forward", "pairs", "ratios", "geared"}.isdisjoint(data)
    page = output.cost_page(own)
    assert said[0] in page
    assert (page.count("<table>"), page.count("<h2")) == (1, 2)  # engines, and notes


@pytest.mark.parametrize(
    ("shares", "named"),
    [
        ((0.5, 0.44, 0.46), "torques of a and c are wrong by up to 50 %"),
        ((1.23, 0.7, 1.0), "torques of a and c are wrong by up to 123 %"),
        ((1.23, 0.89, 0.5), "torque of a is wrong by up to 123 %"),
        ((1.23, 1.0, 1.0), "torques of every joint are wrong by up to 123 %"),
    ],
)
def test_joints_nearly_as_wrong_as_the_worst_are_named_beside_it(shares, named):
    """And those whose whole torque is missing, however wrong the worst one is."""
    own, own_shares = found("oblique"), dict(zip("abc", shares, strict=True))
    (first, *_) = own.by_joint
    listed = [
        replace(first, level="links", joint=name, share=share) for name, share in own_shares.items()
    ]
    said = next(output._describe_costs(replace(own, by_joint=listed), ["links"]))
    assert named in said


@pytest.mark.parametrize(
    ("value", "unit", "shown"),
    [
        *((1.11, "m", "1.11 m"), (0.9996, "m", "1 m"), (0.39, "m", "390 mm")),
        *((2.04e-6, "m", "2.04 \u00b5m"), (1e-12, "m", "below 1 nm"), (0.0, "N m", "0 N m")),
        *((12345.0, "N", "12.3 kN"), (4.56e7, "N", "45600 kN"), (-0.0165, "N m", "-16.5 mN m")),
    ],
)
def test_amounts_are_written_as_people_write_them(value, unit, shown):
    assert output.format_quantity(value, unit) == shown


@pytest.mark.parametrize(
    ("share", "shown"),
    [
        *((0.0, "0 %"), (1e-7, "below 0.001 %"), (0.00094, "0.094 %"), (0.018, "1.8 %")),
        *((0.9949, "99 %"), (0.996, "99.6 %"), (1.0, "100 %"), (12.34, "1230 %")),
    ],
)
def test_shares_are_written_in_per_cent(share, shown):
    assert output.format_percent(share) == shown


@pytest.mark.parametrize(
    ("difference", "digits"), [(0.0, 15), (3e-16, 15), (2.5e-15, 14), (2e-11, 10)]
)
def test_digits_that_programs_share(difference, digits):
    assert output.digits_of(difference) == digits


def test_coupling_below_a_least_factor_is_negligible_at_any_ratio():
    """A hundredth is allowed, and a term falls as the ratio rises."""
    terms = [np.array([0.98e-6]), np.array([1.02e-6])]
    found_factors = [shortcuts._negligible_factor(each, np.zeros(1)) for each in terms]
    assert found_factors == pytest.approx([0.0, 1.02e-4])
    own = found("oblique")
    small = replace(own, by_joint=[replace(each, share=0.004) for each in own.by_joint], factor=0.6)
    said = "\n".join(output._describe_coupling(small))
    assert "the only number that" in output.cost_page(replace(own, ratios=()))
    output.draw_torques(replace(own, torques=0 * own.torques))  # of a motion that needs none
    nothing = own.motion.at(own.time[:3]), 0 * own.largest, [*own.names]
    assert shortcuts._compute_rotor_shares(own.robot, *nothing)[1] == shortcuts.MOST_FACTOR
    assert not [*output.describe_direct_joints(replace(own, robot=robot("staged")))]
    bare = replace(own.robot, rotors=())
    assert not [*output._describe_identity(bare)]
    assert not [*output._describe_rotors(replace(own, robot=bare))]
    assert "(0.4 %) would reach 1 % of a joint's largest torque only if all ratios" in said


def test_runs_that_diverge_are_reported():
    model = build_robot_model("analytic", robot("oblique"), "links")
    ends = np.array([[np.inf, 0.0, 0.0], [0.1, 0.2, 0.3]])
    plan = np.tile(model.tip(ends[1:]) - [0.0, 0.0, 2.0], (2, 1))
    assert tip_distances(model, ends, plan) == pytest.approx([np.inf, 2.0])
    lost = np.array([0.1, np.inf, 0.3])
    assert output.describe_distances(lost) == "300 mm off (median of 3 runs, 1 of them diverge)"
    assert output.describe_distances(np.array([0.1, np.inf, np.inf])) == "lost: 2 of 3 runs diverge"
    assert output.format_length(np.inf) == "diverged"


def test_where_there_is_no_motor_a_plan_costs_no_torque():
    """The others hold and move what the plan asks of them, as of a robot with all motors."""
    lost = two_link.URDF.replace("</robot>", '<passive_joint name="j1"/></robot>')
    q, v, a = np.random.default_rng(4).normal(size=(3, 5, 2))
    whole, acrobot = (
        motor_torques(build_robot_model("analytic", chains.robot(text), "links"), (q, v, a))
        for text in (two_link.URDF, lost)
    )
    assert not acrobot[:, 0].any()
    assert np.abs(whole[:, 0]).min() > 0
    np.testing.assert_array_equal(acrobot[:, 1], whole[:, 1])
    along = np.array([[2.0, 0.0], [3.0, 9.0]])  # a radian
    assert [*describe_passive(chains.robot(lost), along)] == ["j1 by 57.3 degrees"]

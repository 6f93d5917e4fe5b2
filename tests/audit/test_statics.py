"""Numbers that follow from the arm's data, against geometry worked out another way; free bases."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from crosscheck.audit.claims.measured import MEASURED
from crosscheck.audit.experiments.study import Study
from crosscheck.audit.measures.stage import paper_stage
from crosscheck.audit.statics import statics as flights
from crosscheck.audit.statics.statics import BASE_MASSES, Statics, gravity_gradient
from crosscheck.audit.statics.teeth import (
    COUNTED,
    approach_rates,
    conversion_error,
    ring_contact_ratio,
    sun_contact_ratio,
    virtual_work,
)
from crosscheck.checks.levels import tip_position
from crosscheck.models.arm.arm import Arm, FreeBase
from crosscheck.models.arm.meshes import replace_by_square_wave
from crosscheck.models.arm.stiffness import SquareStiffness
from crosscheck.models.loading import Case, load_case
from crosscheck.models.robot.robot import Robot
from crosscheck.registry import build, build_robot_model


@pytest.fixture(scope="module")
def numbers(kept: Path) -> dict[str, float | None]:
    (found,) = Study(kept).answer_questions([Statics("paper-labelled")], "statics")
    return found


def test_what_follows_from_the_data_is_what_is_said_to_be_measured(numbers):
    assert {f"base_tip_{mass}_mm" for mass in BASE_MASSES} < set(numbers) <= set(MEASURED)


def test_contact_ratios_are_those_of_involutes_that_touch(labelled):
    """Standard teeth end one module beyond their pitch circles; the path of contact is a line."""
    joint = paper_stage(labelled).joint
    alpha, module = math.radians(joint.pressure_angle_deg), joint.module_m

    def along_the_line(teeth: int, tip: float) -> float:
        """Way from the pitch point to where the tip circle cuts the line of action, by a root."""
        pitch = module * teeth / 2
        ways = np.roots([1.0, 2 * pitch * math.sin(alpha), pitch**2 - tip**2])
        return float(min(abs(ways)))

    sun, planet = (
        along_the_line(teeth, module * (teeth / 2 + 1))
        for teeth in (joint.sun_teeth, joint.planet_teeth)
    )
    ring = along_the_line(joint.ring_teeth, module * (joint.ring_teeth / 2 - 1))
    base_pitch = math.pi * module * math.cos(alpha)
    assert sun_contact_ratio(joint) == pytest.approx((sun + planet) / base_pitch, rel=1e-12)
    assert ring_contact_ratio(joint) == pytest.approx((planet + ring) / base_pitch, rel=1e-12)


def test_no_flank_approaches_another_while_the_stage_rolls(labelled):
    """Willis: the ring at rest, sun at n times the carrier, planet as its pitch circle rolls."""
    joint = paper_stage(labelled).joint
    ratio = joint.ring_teeth / joint.sun_teeth + 1
    planet = 1 - joint.ring_teeth / joint.planet_teeth
    assert approach_rates(joint, ratio, planet, 1.0) == pytest.approx((0.0, 0.0), abs=1e-15)


def test_only_one_way_to_count_the_planets_fits_eq_3(labelled):
    stage = paper_stage(labelled)
    errors = [conversion_error(stage.joint, stage.geometry, how) for how in COUNTED]
    assert errors[0] < 1e-12  # rounding
    assert min(errors[1:]) > 1


def test_eq_6_takes_more_work_than_eq_5(numbers):
    """Two comparisons and a sum against two tanh, six products and quotients, six sums."""
    assert numbers["eq5_work"] == pytest.approx(3 / 14)


def test_gravitys_gradient_is_what_two_masses_on_a_rod_feel(labelled):
    """At 45 degrees to the vertical; the torque of the difference of two inverse-square pulls."""
    mu, orbit, arm = 3.986e14, 6.771e6, 1.0
    ends = orbit + arm * np.exp(1j * math.pi / 4) * np.array([1.0, -1.0])
    pulls = -mu * ends / np.abs(ends) ** 3
    torque = (np.conj(ends - orbit) * pulls).imag.sum()
    share = gravity_gradient(labelled) / (1.5 * mu / orbit**3)  # the arm's inertia
    # The next order in the rod's length over the orbit's radius: 1e-7, and rounding.
    assert abs(torque) == pytest.approx(1.5 * mu / orbit**3 * 2 * arm**2, rel=1e-5)
    links, joint, payload = (27 * 0.5**2, 18.9 * 1.35**2), 18.51, 10 * 1.7**2
    assert share == pytest.approx(sum(links) + joint + payload, rel=1e-12)


def test_a_heavy_base_stays_nearer_to_a_fixed_one(numbers):
    """Beyond 50 times the arm's mass the tip's error falls as one over the base's."""
    errors = np.array([numbers[f"base_tip_{mass}_mm"] for mass in BASE_MASSES])
    assert (np.diff(errors) < 0).all()
    # The next order in the arm's mass over the base's, 1 / 500.
    assert errors[2] / errors[3] == pytest.approx(10, rel=0.02)


@pytest.mark.parametrize(
    ("left_out", "work"),
    [  # N c F E, and N c k_a f^2 / 2, of springs in sun and ring mesh
        ("mesh_stiffness_amplitude_N_per_m", lambda force: 3 * 198 * force * 5e-6),
        ("tooth_error_m", lambda force: 3 * 198 * 2e7 * (force / 1e8) ** 2 / 2),
    ],
)
def test_springs_push_the_angle_by_each_effect_alone(labelled, left_out, work):
    stage = replace(paper_stage(labelled), **{left_out: 0.0})
    r_s = 0.0135 * 3 * math.cos(math.radians(24.6))
    force = 100.0 / (99 / 27 + 1) / r_s / 3
    assert virtual_work(stage, 100.0) == pytest.approx(work(force), rel=1e-9)


def test_the_square_wave_has_eq_8s_mean_and_fundamental(labelled):
    law = replace_by_square_wave(labelled, 15).joints[0].sun_mesh.planet_mesh(0).stiffness
    assert isinstance(law, SquareStiffness)
    phase = 2 * math.pi * (np.arange(4096) + 0.5) / 4096
    wave = np.where(np.mod(phase, 2 * math.pi) < math.pi, law.largest_N_per_m, law.least_N_per_m)
    assert wave.mean() == pytest.approx(1e8)
    # 4096 samples of a step: their sine sum misses 1e-7 of the integral.
    assert 2 * (wave * np.sin(phase)).mean() == pytest.approx(2e7, rel=1e-6)
    assert 2 * (wave * np.cos(phase)).mean() == pytest.approx(0, abs=1)


def test_another_reading_is_another_question():
    assert Statics("paper-labelled").inputs != Statics("paper-swapped").inputs


def _case(scenario: str, duration_s: float = 0.5) -> Case:
    settings = [flights.EVERY, f"scenario.duration_s={duration_s}"]
    return load_case("paper-labelled", scenario, None, settings)


def _robot(arm: Arm, mass: float) -> Robot:
    return flights.free_robot(arm, FreeBase(mass_kg=mass, side_m=2.0))


@pytest.mark.parametrize("scenario", ["constant-torque", "pd"])
def test_a_base_without_end_stands_still(scenario):
    case = _case(scenario)
    fixed = build("pinocchio:coupled", *case).simulate()
    path = flights.tip_path(_robot(case.arm, 1e9), case.scenario)
    # Of the mass ratio of 1e7, and steps of 10 us.
    assert path == pytest.approx(tip_position(fixed, case.arm).values, abs=1e-6)


def test_mass_matrix_of_the_joints_is_the_fixed_arms(labelled):
    angles = np.array([0.4, -1.1])
    free = build_robot_model("analytic", _robot(labelled, 500.0), "coupled")
    mass = free.mass_matrix(np.array([[0.1, 0.2, 0.3, *angles]]))[0]
    fixed = build("pinocchio:coupled", *_case("pd")).mass_matrix(angles)
    np.testing.assert_allclose(mass[3:, 3:], fixed, rtol=1e-12)


def test_all_that_the_base_carries(labelled):
    joints = sum(
        j.sun_mass_kg + 3 * j.planet_mass_kg + j.carrier_mass_kg + j.ring_mass_kg
        for j in labelled.joints
    )
    assert flights.arm_mass(labelled) == pytest.approx(27 + 18.9 + 10 + joints)

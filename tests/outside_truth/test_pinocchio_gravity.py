"""Pinocchio's models on arms unlike the paper's: weights, friction, motors, laws of stiffness.

Against closed forms, elliptic functions, virtual work and each law as it is written.
"""

from __future__ import annotations

from itertools import pairwise
from math import cos, pi, radians, sin, sqrt
from typing import Any

import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from scipy.special import ellipj, ellipk

from crosscheck.models.arm.arm import Arm
from crosscheck.models.errors import InputError
from crosscheck.models.experiment.scenario import Scenario
from crosscheck.models.pinocchio.floating import FloatingBase, PinocchioFloating
from crosscheck.models.pinocchio.gears import PinocchioGears
from crosscheck.models.pinocchio.rigid import (
    PinocchioArmature,
    PinocchioCarriers,
    PinocchioCoupled,
    PinocchioLinks,
)

EPS = np.finfo(float).eps
RIGID = [PinocchioLinks, PinocchioCarriers, PinocchioArmature, PinocchioCoupled]
ALL = [*RIGID, PinocchioGears]
GRAVITY = (1.3, -9.6)

SHOULDER = {"kind": "direct", "motor_mass_kg": 1.7, "rotor_inertia_kg_m2": 0.05}
ELBOW = {"kind": "direct", "motor_mass_kg": 0.9, "rotor_inertia_kg_m2": 0.02}
UPPER = {"length_m": 0.9, "com_m": 0.35, "mass_kg": 4.0, "inertia_kg_m2": 0.21}
FORE = {"length_m": 0.6, "com_m": 0.27, "mass_kg": 2.5, "inertia_kg_m2": 0.13}
PAYLOAD = 1.6

SINE = {"law": "sine", "mean_N_per_m": 1e8, "amplitude_N_per_m": 2e7}
FOURIER = {
    "law": "fourier",
    "mean_N_per_m": 9e7,
    "cosine_N_per_m": [1e7, -3e6, 2e6],
    "sine_N_per_m": [5e6, 4e6],
}
SQUARE = {
    "law": "square",
    "contact_ratio": 1.6,
    "least_N_per_m": 7e7,
    "largest_N_per_m": 1.2e8,
    "harmonics": 9,
}
TABLE = {
    "law": "table",
    "phase_cycles": [0.0, 0.15, 0.3, 0.55, 0.8, 1.0],
    "stiffness_N_per_m": [8e7, 9e7, 1.2e8, 1.1e8, 7e7, 8e7],
}
SOFT = {"law": "sine", "mean_N_per_m": 6e7, "amplitude_N_per_m": 1e7}
PAIRS = [*pairwise([SINE, FOURIER, SQUARE, TABLE, SINE]), (SINE, SOFT)]


def mesh(stiffness: dict[str, Any], **more: Any) -> dict[str, Any]:
    undamped = {"damping_ratio": 0.0, "backlash_m": 40e-6, "tooth_error_m": 6e-6}
    return undamped | {"stiffness": stiffness} | more


GEARS = {
    "kind": "planetary",
    "sun_teeth": 30,
    "planet_teeth": 30,
    "ring_teeth": 90,
    "planet_count": 4,
    "module_m": 0.0025,
    "pressure_angle_deg": 20.0,
    "sun_inertia_kg_m2": 6e-4,
    "planet_equivalent_mass_kg": 0.7,
    "carrier_inertia_kg_m2": 0.025,
    "sun_mass_kg": 0.36,
    "planet_mass_kg": 0.52,
    "carrier_mass_kg": 5.5,
    "ring_mass_kg": 8.0,
    "ring_inertia_kg_m2": 0.11,
    "sun_mesh": mesh(SINE),
    "ring_mesh": mesh(FOURIER, phase_rad=-0.4),
}
COSINE = cos(radians(20))
R_S = R_P = 0.0375 * COSINE


def arm_of(
    joints: list[dict[str, Any]],
    links: list[dict[str, Any]],
    gravity: tuple[float, float] = GRAVITY,
) -> Arm:
    data = {"schema_version": 2, "name": "arm", "payload_mass_kg": PAYLOAD}
    return Arm.model_validate(
        data | {"gravity_m_per_s2": gravity, "joints": joints, "links": links}
    )


def weightless(arm: Arm) -> Arm:
    return arm.model_copy(update={"gravity_m_per_s2": (0.0, 0.0)})


def scenario(
    torque: float | list[float] = 0.0,
    theta: float = 0.0,
    rate: float = 0.0,
    duration: float = 0.1,
    steps: int = 100,
) -> Scenario:
    return Scenario.model_validate(
        {
            "schema_version": 1,
            "name": "free",
            "duration_s": duration,
            "step_s": duration / steps,
            "record_every": 1,
            "start": {"theta_rad": theta, "theta_dot_rad_per_s": rate},
            "drive": {"kind": "constant", "torque_N_m": torque},
        }
    )


MIXED = arm_of(
    [GEARS, SHOULDER, GEARS | {"planet_count": 3, "sun_mesh": mesh(SQUARE)}], [UPPER, FORE, UPPER]
)


@pytest.mark.parametrize("model", ALL)
@pytest.mark.parametrize("theta", [0.0, 0.7, -2.1])
def test_a_single_link_hangs_by_m_g_l_sin(model, theta):
    """Gravity along x: the arm hangs down at zero."""
    arm = arm_of([SHOULDER], [UPPER], (9.81, 0.0))
    found = model(arm, scenario(5.0)).generalized_force(0.0, np.array([theta]), np.zeros(1))
    moment = 4.0 * 0.35 + PAYLOAD * 0.9
    # Of 30 N m, to some roundings.
    np.testing.assert_allclose(found, [5 - moment * 9.81 * sin(theta)], rtol=0, atol=300 * EPS)


@pytest.mark.parametrize("level", RIGID)
def test_a_pendulum_swings_by_the_elliptic_functions(level):
    """One period from 2 rad: theta = 2 asin(k cd(w t)), k = sin(theta_0 / 2), period 4 K / w."""
    inertia = 0.21 + 4.0 * 0.35**2 + PAYLOAD * 0.9**2 + (level is not PinocchioLinks) * 0.05
    w = sqrt((4.0 * 0.35 + PAYLOAD * 0.9) * 9.81 / inertia)
    k = sin(1.0)
    period = 4 * ellipk(k**2) / w
    pendulum = level(
        arm_of([SHOULDER], [UPPER], (9.81, 0.0)), scenario(theta=2.0, duration=period, steps=400)
    )
    run = pendulum.simulate()
    theta = run.theta.values[:, 0]
    _, cn, dn, _ = ellipj(w * run.time.values, k**2)
    # The tolerance of the run, 1e-13, over its twenty steps or so, interpolation included.
    close = {"rtol": 0, "atol": 2e-11}
    np.testing.assert_allclose(theta, 2 * np.arcsin(k * cn / dn), **close)
    np.testing.assert_allclose(theta[::100], [2, 0, -2, 0, 2], **close)
    np.testing.assert_array_equal(run.torque, 0)  # of the motors alone


@pytest.mark.parametrize("model", ALL)
def test_two_direct_joints_have_the_textbook_mass_matrix(model):
    """Motors at the joints, rotors on the next links; without them at level `links`."""
    arm, theta_2 = arm_of([SHOULDER, ELBOW], [UPPER, FORE]), 0.8
    drives = model is not PinocchioLinks
    a = 0.13 + 2.5 * 0.27**2 + PAYLOAD * 0.6**2 + drives * 0.02
    h = 0.9 * (2.5 * 0.27 + PAYLOAD * 0.6) * cos(theta_2)
    at_elbow = (2.5 + PAYLOAD + drives * 0.9) * 0.9**2
    first = 0.21 + 4.0 * 0.35**2 + at_elbow + a + 2 * h + drives * 0.05
    found = model(arm, scenario()).mass_matrix(np.array([-0.3, theta_2]))
    # Some twenty roundings on either side.
    np.testing.assert_allclose(found, [[first, a + h], [a + h, a]], rtol=50 * EPS)


@pytest.mark.parametrize("model", ALL)
def test_force_on_direct_joints_is_drive_friction_and_weight(model):
    joints = [SHOULDER | {"friction_N_m_s_per_rad": 0.8}, ELBOW | {"friction_N_m_s_per_rad": 0.3}]
    q, v = np.array([0.4, -1.1]), np.array([2.0, -3.0])
    motor = 0.9 * (model is not PinocchioLinks)
    first, second = ((-sin(angle), cos(angle)) for angle in (q[0], q[0] + q[1]))
    fore = (2.5 * 0.27 + PAYLOAD * 0.6) * np.dot(GRAVITY, second)
    upper = (4.0 * 0.35 + (2.5 + PAYLOAD + motor) * 0.9) * np.dot(GRAVITY, first)
    expected = [7 - 0.8 * 2 + upper + fore, -4 + 0.3 * 3 + fore]
    found = model(arm_of(joints, [UPPER, FORE]), scenario([7.0, -4.0])).generalized_force(0, q, v)
    # Of 100 N m, to some roundings.
    np.testing.assert_allclose(found, expected, rtol=0, atol=1000 * EPS)


@pytest.mark.parametrize("level", RIGID)
def test_friction_brakes_exponentially(level):
    arm = arm_of([SHOULDER | {"friction_N_m_s_per_rad": 0.8}], [UPPER], (0.0, 0.0))
    run = level(arm, scenario(rate=3.0, duration=2.0)).simulate()
    inertia = 0.21 + 4.0 * 0.35**2 + PAYLOAD * 0.9**2 + (level is not PinocchioLinks) * 0.05
    expected = 3 * np.exp(-0.8 * run.time.values / inertia)
    # As in the swing of the pendulum.
    np.testing.assert_allclose(run.theta_dot.values[:, 0], expected, rtol=0, atol=2e-11)


@pytest.mark.parametrize("model", ALL)
def test_friction_acts_on_joint_angles_alone(model):
    joints = [
        joint.model_copy(update={"friction_N_m_s_per_rad": c})
        for joint, c in zip(MIXED.joints, (0.7, 1.9, 3.1), strict=True)
    ]
    case = MIXED.model_copy(update={"joints": tuple(joints)})
    with_friction, without = (model(arm, scenario()) for arm in (case, MIXED))
    n = len(without.layout)
    q, v = np.zeros(n), np.linspace(1.0, 2.0, n)
    expected = np.zeros(n)
    expected[without.layout.theta] = -np.array([0.7, 1.9, 3.1]) * v[without.layout.theta]
    force = with_friction.generalized_force(0.0, q, v) - without.generalized_force(0.0, q, v)
    # Of weights of 300 N m, to some roundings.
    np.testing.assert_allclose(force, expected, rtol=0, atol=3000 * EPS)


def potential(arm: Arm, theta: np.ndarray, drives: bool) -> float:
    """V [J] of links and payload, and of what sits at the joints if ``drives``."""
    weight, place, heading = np.array(arm.gravity_m_per_s2), np.zeros(2), 0.0
    energy = 0.0
    for joint, link, turn in zip(arm.joints, arm.links, theta, strict=True):
        heading += turn
        along = np.array([cos(heading), sin(heading)])
        if joint.kind == "direct":
            at_joint = joint.motor_mass_kg
        else:
            at_joint = joint.sun_mass_kg + joint.carrier_mass_kg + joint.ring_mass_kg
            at_joint += joint.planet_count * joint.planet_mass_kg
        energy -= drives * at_joint * weight @ place
        energy -= link.mass_kg * weight @ (place + link.com_m * along)
        place = place + link.length_m * along
    return float(energy - arm.payload_mass_kg * weight @ place)


@pytest.mark.parametrize("model", ALL)
@pytest.mark.parametrize("seed", range(3))
def test_weights_are_the_slope_of_their_potential(model, seed):
    """V is a constant and a sine in every angle: (V(+pi/2) - V(-pi/2)) / 2 is its slope."""
    rng = np.random.default_rng(seed)
    heavy, light = (model(arm, scenario(3.0)) for arm in (MIXED, weightless(MIXED)))
    places, n = heavy.layout.theta, len(heavy.layout)
    q, v = rng.normal(size=n), rng.normal(size=n)
    q[~heavy.layout.angular] *= 1e-4
    found = heavy.generalized_force(0.1, q, v) - light.generalized_force(0.1, q, v)
    quarters = pi / 2 * np.eye(3)
    drives = model is not PinocchioLinks
    expected = np.zeros(n)
    expected[places] = [
        potential(MIXED, q[places] - turn, drives) / 2
        - potential(MIXED, q[places] + turn, drives) / 2
        for turn in quarters
    ]
    # Contact forces of 2e4 N, which cancel, on suns of 0.04 m: of a dozen meshes.
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e6 * EPS)
    np.testing.assert_array_equal(heavy.bias(q, v), light.bias(q, v))


@pytest.mark.parametrize("model", ALL)
def test_acceleration_solves_the_equation_of_motion_with_weights(model):
    """By the articulated body algorithm, gravity inside, against M a + bias = f."""
    rng = np.random.default_rng(7)
    arm = model(MIXED, scenario(3.0))
    q, v = rng.normal(size=len(arm.layout)), rng.normal(size=len(arm.layout))
    displaced = ~arm.layout.angular
    q[displaced], v[displaced] = 1e-4 * q[displaced], 1e-3 * v[displaced]
    mass, force = arm.mass_matrix(q), arm.generalized_force(0.1, q, v)
    left = mass @ arm.acceleration(0.1, q, v) + arm.bias(q, v)
    # Rounding of forces, as the condition of M may magnify it, scaled to equal diagonals.
    scale = np.sqrt(np.diag(mass))
    condition = np.linalg.cond(mass / np.outer(scale, scale))
    size = np.abs(force / scale).max() + np.abs(arm.bias(q, v) / scale).max()
    np.testing.assert_allclose(
        left / scale, force / scale, rtol=0, atol=100 * EPS * condition * size
    )


def test_energy_stays_while_a_mixed_arm_falls():
    run = PinocchioCoupled(MIXED, scenario(theta=0.5, duration=0.5)).simulate()
    fallen = np.array([potential(MIXED, theta, True) for theta in run.theta.values])
    total = run.kinetic_energy.values + fallen
    assert run.kinetic_energy.values[-1] > 10
    # Recorded rates are interpolated to 3e-12 rad/s: times momenta of 100 kg m^2/s.
    np.testing.assert_allclose(total, total[0], rtol=0, atol=1e-9)


def test_without_mesh_motion_the_tree_is_the_rigid_arm_on_rolling_gears():
    """M, bias and weights along x = 0 against mimic joints, with a direct joint between."""
    geared, rigid = (model(MIXED, scenario()) for model in (PinocchioGears, PinocchioCoupled))
    theta, theta_dot = np.array([0.3, -1.2, 0.9]), np.array([1.0, 2.0, -1.5])
    along = np.zeros((7, 3))
    along[geared.layout.theta, range(3)] = 1
    q, v = along @ theta, along @ theta_dot
    # Entries of up to 200 kg m^2, sums of some hundred products in another order.
    close = {"rtol": 0, "atol": 200 * 100 * EPS}
    np.testing.assert_allclose(
        along.T @ geared.mass_matrix(q) @ along, rigid.mass_matrix(theta), **close
    )
    close["atol"] *= 10  # rates
    np.testing.assert_allclose(along.T @ geared.bias(q, v), rigid.bias(theta, theta_dot), **close)
    force = rigid.generalized_force(0.0, theta, theta_dot)
    np.testing.assert_allclose(along.T @ geared.generalized_force(0.0, q, v), force, **close)


@pytest.mark.parametrize("model", ALL)
def test_an_inertia_and_a_rod_can_be_given_in_either_form(model):
    as_masses = {
        "sun_inertia_kg_m2": None,
        "sun_equivalent_mass_kg": 6e-4 / R_S**2,
        "planet_equivalent_mass_kg": None,
        "planet_inertia_kg_m2": 0.7 * R_P**2,
        "carrier_inertia_kg_m2": None,
        "carrier_equivalent_mass_kg": 0.025 / (R_S + R_P) ** 2,
    }
    damped = GEARS | {"sun_mesh": mesh(SINE, damping_ratio=0.1)}
    damped |= {"ring_mesh": mesh(SINE, damping_ratio=0.2)}
    body = {"length_m": 0.8, "com_m": 0.3, "mass_kg": 21.6, "inertia_kg_m2": 21.6 * 0.8**2 / 12}
    rod = {"length_m": 0.8, "com_m": 0.3, "cross_section_m2": 0.01, "density_kg_per_m3": 2700.0}
    one, other = (
        model(arm_of([gears], [link]), scenario(3.0))
        for gears, link in ((damped, body), (damped | as_masses, rod))
    )
    q, v = np.array([6e-5, -7e-5, 0.4])[-len(one.layout) :], np.ones(3)[-len(one.layout) :]
    np.testing.assert_allclose(one.mass_matrix(q), other.mass_matrix(q), rtol=50 * EPS)
    forces = (arm.generalized_force(0.0, q, v) for arm in (one, other))
    # Contact forces of 1e4 N and dampers of 1e4 N s/m on either side.
    np.testing.assert_allclose(*forces, rtol=0, atol=1e5 * EPS)


def stiffness(law: dict[str, Any], phase: float) -> float:
    """k [N/m] as ``crosscheck.models.arm.stiffness`` states the law."""
    if law in (SINE, SOFT):
        return law["mean_N_per_m"] + law["amplitude_N_per_m"] * sin(phase)
    if law is FOURIER:
        cosines = 1e7 * cos(phase) - 3e6 * cos(2 * phase) + 2e6 * cos(3 * phase)
        return 9e7 + cosines + 5e6 * sin(phase) + 4e6 * sin(2 * phase)
    if law is SQUARE:
        waves = [(sin(i * (1.2 * pi - phase)) + sin(i * phase)) / (i * pi) for i in range(1, 10)]
        return 7e7 + 5e7 * (0.6 + sum(waves))
    return float(spline()(phase / (2 * pi) % 1))


def spline() -> CubicSpline:
    return CubicSpline(TABLE["phase_cycles"], TABLE["stiffness_N_per_m"], bc_type="periodic")


def mean_stiffness(law: dict[str, Any]) -> float:
    if law is TABLE:
        return float(spline().integrate(0, 1))
    return 7e7 + 5e7 * 0.6 if law is SQUARE else law["mean_N_per_m"]


@pytest.mark.parametrize(("sun", "ring"), PAIRS)
@pytest.mark.parametrize("theta", [0.31, -2.4])
def test_every_mesh_follows_its_own_law(sun, ring, theta):
    """k(phase) f_k(x - E sin(phase)) of each mesh, 90 radians of phase to one of the joint."""
    gears = GEARS | {
        "sun_mesh": mesh(sun, phase_rad=0.9, backlash_m=30e-6),
        "ring_mesh": mesh(ring, phase_rad=-0.4, tooth_error_m=9e-6),
    }
    model = PinocchioGears(arm_of([gears, SHOULDER], [UPPER, FORE], (0.0, 0.0)), scenario())
    x_sp, x_pr = 7e-5, -8e-5
    found = model.generalized_force(0.2, np.array([x_sp, x_pr, theta, 0.3]), np.zeros(4))
    phase_sp, phase_pr = 90 * theta + 0.9, 90 * theta - 0.4
    expected = [
        -4 * stiffness(sun, phase_sp) * (x_sp - 6e-6 * sin(phase_sp) - 30e-6),
        -4 * stiffness(ring, phase_pr) * (x_pr - 9e-6 * sin(phase_pr) + 40e-6),
    ]
    # Waves up to nine times a phase of 216 rad, which rounds to 1e-14; x is a difference of arcs.
    np.testing.assert_allclose(found, [*expected, 0, 0], rtol=1e-12, atol=1e-6)


@pytest.mark.parametrize(("sun", "ring"), PAIRS)
def test_a_damping_ratio_is_of_the_mean_stiffness(sun, ring):
    gears = GEARS | {
        "sun_mesh": mesh(sun, damping_ratio=0.05),
        "ring_mesh": mesh(ring, damping_ratio=0.08),
    }
    model = PinocchioGears(arm_of([gears], [UPPER]), scenario())
    q, v = np.array([1e-5, 2e-5, 0.4]), np.array([0.1, -0.2, 1.0])
    found = model.generalized_force(0.0, q, v) - model.generalized_force(0.0, q, 0 * v)
    d_sp = 2 * 0.05 * sqrt(4 * mean_stiffness(sun) * 6e-4 / R_S**2)
    d_pr = 2 * 0.08 * sqrt(4 * mean_stiffness(ring) * 4 * 0.7)
    # Forces of 1e3 N between contacts without force, next to weights of 30 N m.
    np.testing.assert_allclose(found, [-0.1 * d_sp, 0.2 * d_pr, 0], rtol=1e-13, atol=1e-9)


def test_a_free_flying_base_knows_friction_but_no_gravity():
    joints = [SHOULDER | {"friction_N_m_s_per_rad": 0.8}, ELBOW]
    arm = arm_of(joints, [UPPER, FORE], (0.0, 0.0))
    model = PinocchioFloating(arm, scenario(2.0), FloatingBase(100.0))
    found = model.generalized_force(0.0, np.zeros(5), np.array([1.0, 1.0, 1.0, 0.5, 0.7]))
    np.testing.assert_array_equal(found, [0, 0, 0, 2 - 0.8 * 0.5, 2])
    assert model.coordinates == ("base_x", "base_y", "base_angle", "theta_1", "theta_2")
    with pytest.raises(InputError, match=r"gravity_m_per_s2 = .*must be \(0, 0\)"):
        PinocchioFloating(arm_of(joints, [UPPER, FORE]), scenario(), FloatingBase(100.0))

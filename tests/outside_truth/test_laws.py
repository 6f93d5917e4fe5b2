"""Laws of mechanics in every geared model and, of joints alone, in every rigid one."""

from math import cos, pi, sin

import numpy as np
import pytest

from crosscheck.models.arm.arm import Arm, Link
from crosscheck.models.experiment.scenario import switches
from crosscheck.models.interface import Model
from crosscheck.models.loading import load_arm, load_case
from crosscheck.registry import build, find_level_models, model_names
from tests import arms
from tests.loops import require_items
from tests.mixed_arms import (
    MIXED,
    NONE,
    PAYLOAD,
    ROD_MASS,
    arm_of,
    direct,
    geared,
    random_states,
    scenario,
)
from tests.planet_laws import force_off

EPS = float(np.finfo(float).eps)
every_geared_model = pytest.mark.parametrize("name", model_names("geared"))
every_model = pytest.mark.parametrize("name", [*model_names("geared"), *model_names("rigid")])
LINKS_ALONE = find_level_models("links")
PAPER = "paper-labelled", "constant-torque"


def meshing(sun: str, ring: str, **given: float) -> dict[str, object]:
    """Both meshes damped by their ratios, or by what is given."""
    joint = geared(sun, ring, friction_N_m_s_per_rad=7.0)
    for side, damping in given.items():
        joint[side] = {**joint[side], "damping_ratio": None, "damping_N_s_per_m": damping}
    return joint


EVERY_LAW = arm_of(
    meshing("table", "fourier"),
    direct(friction_N_m_s_per_rad=11.0),
    meshing("square", "sine", ring_mesh=700.0),
    gravity=NONE,
)


@every_geared_model
@pytest.mark.parametrize(
    "laws",
    [
        {},
        {"mesh_work": "conservative"},
        {"damping": "contact"},
        {"dead_zone": "tanh"},
        {"dead_zone": "tanh", "damping": "contact", "ring_rate": "eq13"},
        {"phase": "omega_t"},
        {"phase": "omega_t", "ring_rate": "eq13", "damping": "contact"},
        {"phase": "omega_t", "dead_zone": "tanh"},
    ],
    ids=lambda laws: "-".join(laws.values()) or "usual",
)
def test_every_mesh_follows_its_own_law_and_the_switches(name, laws):
    """Springs of every law, phases, dampers given or of the mean stiffness, friction."""
    model = build(name, EVERY_LAW, scenario(), switches(**laws))
    # Deflections of 1e-5 m out of places near 1 m, times 4e8 N/m; phases of 300 rad.
    assert force_off(model, 5, t=0.4) < 1e-11


def moving_bodies(
    arm: Arm, model: Model, q: np.ndarray, v: np.ndarray
) -> list[tuple[float, complex, float, float]]:
    """(mass, velocity, inertia, spin) of every body in the plane, from Eqs. 2 and 3."""
    bodies: list[tuple[float, complex, float, float]] = []
    velocity, angle, spin = 0j, 0.0, 0.0
    for number, (joint, link) in enumerate(zip(arm.joints, arm.links, strict=True)):
        at, before = model.layout.at("theta", number), spin
        angle, spin = angle + q[at], spin + v[at]
        along = np.exp(1j * angle)
        if joint.kind == "direct":
            bodies.append((joint.motor_mass_kg, velocity, 0.0, 0.0))
            bodies.append((0.0, 0j, joint.rotor_inertia_kg_m2, spin))
        else:
            cosine = np.cos(np.radians(joint.pressure_angle_deg))
            r_s, r_p = (
                joint.module_m * z / 2 * cosine for z in (joint.sun_teeth, joint.planet_teeth)
            )
            x_sp_dot, x_pr_dot = (
                v[model.layout.at(meaning, number)] for meaning in ("x_sp", "x_pr")
            )
            turning, r_cp = v[at], r_s + r_p
            planet_spin = before - (x_pr_dot + r_cp * turning) / r_p
            sun_spin = before + (x_sp_dot + x_pr_dot + 2 * r_cp * turning) / r_s
            on_ground = 0.0 if number == 0 else joint.ring_mass_kg
            ring = 0.0 if number == 0 else joint.ring_inertia_kg_m2
            bodies.append((on_ground, velocity, ring, before))
            sun, carrier, inertia = (
                _inertia(getattr(joint, f"{gear}_inertia_kg_m2"), mass, radius)
                for gear, mass, radius in (
                    ("sun", joint.sun_equivalent_mass_kg, r_s),
                    ("carrier", joint.carrier_equivalent_mass_kg, r_cp),
                    ("planet", joint.planet_equivalent_mass_kg, r_p),
                )
            )
            bodies.append((joint.sun_mass_kg, velocity, sun, sun_spin))
            bodies.append((joint.carrier_mass_kg, velocity, carrier, spin))
            for planet in range(joint.planet_count):
                around = np.exp(2j * np.pi * planet / joint.planet_count)
                moved = velocity + 1j * spin * r_cp / cosine * around * along
                bodies.append((joint.planet_mass_kg, moved, inertia, planet_spin))
        mass, own = _mass_and_inertia(link)
        bodies.append((mass, velocity + 1j * spin * link.com_m * along, own, spin))
        velocity = velocity + 1j * spin * link.length_m * along
    return [*bodies, (arm.payload_mass_kg, velocity, 0.0, 0.0)]


def _inertia(given: float | None, equivalent_mass: float | None, radius: float) -> float:
    return equivalent_mass * radius**2 if given is None else given


def _mass_and_inertia(link: Link) -> tuple[float, float]:
    if link.mass_kg is not None:
        return link.mass_kg, link.inertia_kg_m2
    mass = link.length_m * link.cross_section_m2 * link.density_kg_per_m3
    return mass, mass * link.length_m**2 / 12


@every_geared_model
@pytest.mark.parametrize("arm", [*MIXED, "paper-labelled", "three-unlike"])
def test_mass_matrix_is_the_kinetic_energy_of_the_bodies(name, arm):
    own = MIXED.get(arm) or load_arm(arm)
    model = build(name, own, scenario())
    for q, v in require_items(random_states(model.layout, 5)):
        bodies = moving_bodies(own, model, q, v)
        energy = sum(m * abs(u) ** 2 + inertia * spin**2 for m, u, inertia, spin in bodies) / 2
        # Sums of some thirty positive terms on either side.
        assert v @ model.mass_matrix(q) @ v / 2 == pytest.approx(energy, rel=1e3 * EPS)


@pytest.mark.parametrize("planets", ["lumped", "free"])
def test_kinetic_energy_of_long_arms_is_that_of_their_mass_matrix(planets):
    """A wheel turns with the link before its joint, which from the third joint on is not the first.

    The sum of the links and wheels is recorded, M is of the terms.
    """
    model = build("analytic:physical", arms.arm_of(4), scenario(), switches(planets=planets))
    for q, v in require_items(random_states(model.layout, 3)):
        (energy,) = model.equations.kinetic_energy(q[None], v[None])
        assert energy == pytest.approx(v @ model.mass_matrix(q) @ v / 2, rel=1e4 * EPS)


@every_model
def test_direct_joints_make_the_two_link_arm_of_the_textbooks(name):
    """Motors at the joints, rotors on the next links; without them at level ``links``."""
    model = build(name, arm_of(direct(), direct(), gravity=NONE), scenario([40.0, -15.0]))
    motor, rotor = (0.0, 0.0) if name in LINKS_ALONE else (2.5, 0.07)
    q, v = np.array([0.3, 0.9]), np.array([1.1, -2.0])
    outer = rotor + 0.5 + 6.0 * 0.25**2 + PAYLOAD * 0.7**2
    lever = (6.0 * 0.25 + PAYLOAD * 0.7) * 0.9
    inner = rotor + ROD_MASS * (0.9**2 / 12 + 0.4**2) + (motor + 6.0 + PAYLOAD) * 0.9**2
    c, s = np.cos(q[1]), np.sin(q[1])
    mass = [[inner + outer + 2 * lever * c, outer + lever * c], [outer + lever * c, outer]]
    bias = [-lever * s * (2 * v[0] + v[1]) * v[1], lever * s * v[0] ** 2]
    # A few sums of numbers near 10.
    np.testing.assert_allclose(model.mass_matrix(q), mass, rtol=1e-13)
    np.testing.assert_allclose(model.bias(q, v), bias, rtol=1e-12)
    np.testing.assert_allclose(model.generalized_force(0.0, q, v), [40.0, -15.0], rtol=1e-13)
    acceleration = np.linalg.solve(mass, np.subtract([40.0, -15.0], bias))
    np.testing.assert_allclose(model.acceleration(0.0, q, v), acceleration, rtol=1e-12)


def potential(arm: Arm, theta: np.ndarray, drives: bool) -> float:
    """V [J] of links and payload, and of what sits at the joints if ``drives``."""
    weight, place, heading, energy = np.array(arm.gravity_m_per_s2), np.zeros(2), 0.0, 0.0
    for joint, link, turn in zip(arm.joints, arm.links, theta, strict=True):
        heading += turn
        along = np.array([cos(heading), sin(heading)])
        if joint.kind == "direct":
            at_joint = joint.motor_mass_kg
        else:
            at_joint = joint.sun_mass_kg + joint.carrier_mass_kg + joint.ring_mass_kg
            at_joint += joint.planet_count * joint.planet_mass_kg
        energy -= drives * at_joint * weight @ place
        energy -= _mass_and_inertia(link)[0] * weight @ (place + link.com_m * along)
        place = place + link.length_m * along
    return float(energy - arm.payload_mass_kg * weight @ place)


@every_model
@pytest.mark.parametrize("arm", MIXED)
def test_weights_are_the_slope_of_their_potential(name, arm):
    """V is a constant and a sine in every angle: (V(+pi/2) - V(-pi/2)) / 2 is its slope."""
    heavy = MIXED[arm]
    light = heavy.model_copy(update={"gravity_m_per_s2": (0.0, 0.0)})
    falling, still = (build(name, own, scenario(3.0)) for own in (heavy, light))
    drives, joints = name not in LINKS_ALONE, falling.layout.theta
    states = zip(random_states(falling.layout, 4), (0.0, 0.0, 1.0, 1.0), strict=True)
    for (q, v), size in require_items(states):
        at = np.where(falling.layout.angular, 1.0, size) * q
        found = falling.generalized_force(0.1, at, v) - still.generalized_force(0.1, at, v)
        expected = np.zeros(len(q))
        expected[joints] = [
            (
                potential(heavy, at[joints] - turn, drives)
                - potential(heavy, at[joints] + turn, drives)
            )
            / 2
            for turn in pi / 2 * np.eye(len(joints))
        ]
        # Weights of 300 N on levers of 1 m, rounded; contact forces of 2e4 N, which cancel.
        off = 1e-9 if size else 1e-11
        np.testing.assert_allclose(found, expected, rtol=1e-12, atol=off)
        np.testing.assert_array_equal(falling.bias(at, v), still.bias(at, v))


def test_energy_stays_while_a_mixed_arm_falls():
    arm = arm_of(geared(), direct(), geared())
    run = scenario(duration_s=0.5, step_s=5e-3, record_every=1, start={"theta_rad": 0.5})
    motion = build("pinocchio:coupled", arm, run).simulate()
    fallen = np.array([potential(arm, theta, True) for theta in motion.theta.values])
    total = motion.kinetic_energy.values + fallen
    assert motion.kinetic_energy.values[-1] > 10
    # Recorded rates are interpolated to 3e-12 rad/s: times momenta of 100 kg m^2/s.
    np.testing.assert_allclose(total, total[0], rtol=0, atol=1e-9)


@every_geared_model
def test_without_mesh_motion_it_is_the_rigid_arm_on_rolling_gears(name):
    """M, bias and weights along x = 0 against mimic joints, with a direct joint between."""
    arm = MIXED["geared-direct-geared"]
    model, rigid = (build(each, arm, scenario()) for each in (name, "pinocchio:coupled"))
    theta, theta_dot = np.array([0.3, -1.2, 0.9]), np.array([1.0, 2.0, -1.5])
    along = np.zeros((len(model.layout), 3))
    along[model.layout.theta, range(3)] = 1
    q, v = along @ theta, along @ theta_dot
    # Entries of up to 200 kg m^2, sums of some hundred products in another order.
    close = {"rtol": 0, "atol": 200 * 100 * EPS}
    mass, bias = along.T @ model.mass_matrix(q) @ along, along.T @ model.bias(q, v)
    np.testing.assert_allclose(mass, rigid.mass_matrix(theta), **close)
    close["atol"] *= 10  # rates
    np.testing.assert_allclose(bias, rigid.bias(theta, theta_dot), **close)
    force = rigid.generalized_force(0.0, theta, theta_dot)
    np.testing.assert_allclose(along.T @ model.generalized_force(0.0, q, v), force, **close)


@every_geared_model
def test_motor_torque_reaches_the_coordinates_by_the_suns(name):
    """T/n on the sun is T / (n r_s) on both displacements and T on the joint angle."""
    found = build(name, *load_case(*PAPER)).generalized_force(0.0, np.zeros(6), np.zeros(6))
    on_mesh = 100 / (99 / 27 + 1) / (0.0405 * cos(np.radians(24.6)))
    # A dozen roundings.
    np.testing.assert_allclose(found, [on_mesh, on_mesh, 100] * 2, rtol=20 * EPS)


# Rigid arm at t = 0.5 s [rad], from rest at zero, labelled reading: 100 N m on both joints, then
# PD 1000/400 to 30 degrees. Obtained twice independently with DOP853 at rtol 1e-12: by a
# hand-derived Lagrangian and by another rigid body code.
PUBLISHED = {
    "links": (-0.130090761282, 2.571391736575, 0.329302979666, 0.358033620235),
    "carriers": (-0.174473943705, 2.218547500412, 0.305579834134, 0.355461982810),
    "armature": (-0.175055362718, 2.206518617024, 0.305537812591, 0.355457539297),
    "coupled": (-0.174928501234, 2.205756855379, 0.305535475794, 0.355462200345),
}


@pytest.mark.parametrize("name", model_names("rigid"))
def test_rigid_levels_to_every_printed_digit(name):
    angles = []
    for experiment in ("constant-torque", "pd"):
        settings = ["scenario.duration_s=0.5", "scenario.step_s=1e-4"]
        case = load_case("paper-labelled", experiment, settings=settings)
        angles += list(build(name, *case).simulate()["theta"].values[-1])
    # Half of the last digit.
    assert angles == pytest.approx(PUBLISHED[name.partition(":")[2]], abs=5e-13)

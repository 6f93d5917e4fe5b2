"""The Exudyn tree against mechanics that owes nothing to it: closed forms and conservation laws."""

from __future__ import annotations

import numpy as np
import pytest

from crosscheck.models.arm.arm import Arm
from crosscheck.models.errors import Diverged
from crosscheck.models.exudyn.tree.laws import mesh_law
from crosscheck.models.exudyn.tree.mesh import elastic_forces
from crosscheck.models.exudyn.tree.tree import ExudynTree, paper_from_tree, tree_from_paper
from crosscheck.models.loading import load_case

TIGHT = "arm.joints.*.*_mesh.backlash_m=0.0"
SMOOTH = (
    "arm.joints.*.*_mesh.stiffness.amplitude_N_per_m=0.0",
    "arm.joints.*.*_mesh.tooth_error_m=0.0",
    "arm.joints.*.*_mesh.damping_ratio=0.0",
    "scenario.drive.torque_N_m=0.0",
)
WEIGHTLESS_GEARS = tuple(
    f"arm.joints.*.{wheel}_kg=1e-12"
    for gear in ("sun", "planet", "carrier", "ring")
    for wheel in (f"{gear}_mass", f"{gear}_equivalent_mass")
    if wheel != "ring_equivalent_mass"
)
EPSILON = np.finfo(float).eps


def tree(*settings: str, **switches: str) -> ExudynTree:
    case = load_case("paper-labelled", "constant-torque", switches, settings)
    return ExudynTree(*case)


def first_joint_only(model: ExudynTree) -> ExudynTree:
    data = model.arm.model_dump()
    arm = Arm.model_validate({**data, "joints": data["joints"][:1], "links": data["links"][:1]})
    return ExudynTree(arm, model.scenario, model.switches)


def random_states(count: int = 5) -> list[tuple[np.ndarray, np.ndarray]]:
    """States with every mesh somewhere in or around its clearance."""
    draw = np.random.default_rng(7)
    scale = np.array([1e-4, 1e-4, 1.0] * 2)
    return [(scale * draw.normal(size=6), scale * draw.normal(size=6)) for _ in range(count)]


def moving_bodies(
    arm: Arm, q: np.ndarray, v: np.ndarray
) -> list[tuple[float, complex, complex, float, float]]:
    """(mass, position, velocity, inertia, spin) of every body in the plane, from Eqs. 2 and 3."""
    bodies: list[tuple[float, complex, complex, float, float]] = []
    origin, velocity, angle, spin = 0j, 0j, 0.0, 0.0

    def add(mass: float, arm_from_origin: complex, rate: float, inertia: float, own: float) -> None:
        moved = velocity + 1j * rate * arm_from_origin
        bodies.append((mass, origin + arm_from_origin, moved, inertia, own))

    for place, (joint, link) in enumerate(zip(arm.joints, arm.links, strict=True)):
        cosine = np.cos(np.radians(joint.pressure_angle_deg))
        r_s, r_p = (joint.module_m * z / 2 * cosine for z in (joint.sun_teeth, joint.planet_teeth))
        r_cp, (x_sp_dot, x_pr_dot, theta_dot) = r_s + r_p, v[3 * place : 3 * place + 3]
        planet_spin = spin - (x_pr_dot + r_cp * theta_dot) / r_p
        sun_spin = spin + (x_sp_dot + x_pr_dot + 2 * r_cp * theta_dot) / r_s
        if place:
            add(joint.ring_mass_kg, 0j, 0.0, joint.ring_inertia_kg_m2, spin)
        angle, spin = angle + q[3 * place + 2], spin + theta_dot
        along = np.exp(1j * angle)
        add(joint.sun_mass_kg, 0j, 0.0, joint.sun_equivalent_mass_kg * r_s**2, sun_spin)
        add(joint.carrier_mass_kg, 0j, 0.0, joint.carrier_equivalent_mass_kg * r_cp**2, spin)
        for planet in range(joint.planet_count):
            around = np.exp(2j * np.pi * planet / joint.planet_count)
            inertia = joint.planet_equivalent_mass_kg * r_p**2
            add(joint.planet_mass_kg, r_cp / cosine * around * along, spin, inertia, planet_spin)
        mass = link.length_m * link.cross_section_m2 * link.density_kg_per_m3
        add(mass, link.com_m * along, spin, mass * link.length_m**2 / 12, spin)
        velocity, origin = (
            velocity + 1j * spin * link.length_m * along,
            origin + link.length_m * along,
        )
    add(arm.payload_mass_kg, 0j, 0.0, 0.0, spin)
    return bodies


def kinetic_energy(arm: Arm, q: np.ndarray, v: np.ndarray) -> float:
    bodies = moving_bodies(arm, q, v)
    return sum(m * abs(u) ** 2 + inertia * spin**2 for m, _, u, inertia, spin in bodies) / 2


def angular_momentum(arm: Arm, q: np.ndarray, v: np.ndarray) -> float:
    bodies = moving_bodies(arm, q, v)
    return sum(m * (r.conjugate() * u).imag + inertia * spin for m, r, u, inertia, spin in bodies)


def test_the_map_to_the_tree_and_back_changes_nothing():
    for planets in ("lumped", "free"):
        model = tree(planets=planets)
        arm, layout = model.arm, model.layout
        back_and_forth = paper_from_tree(arm, layout) @ tree_from_paper(arm, layout)
        # A handful of products of base radii and their inverses.
        np.testing.assert_allclose(back_and_forth, np.eye(len(layout)), rtol=0, atol=20 * EPSILON)


def test_the_map_holds_the_papers_definitions_of_the_mesh_displacements():
    model = first_joint_only(tree())
    r_s, r_p, r_cp = 36.82406e-3, 49.09875e-3, 85.92281e-3
    x_sp, x_pr, theta = 3e-4, -2e-4, 0.7
    link, sun, planet = (tree_from_paper(model.arm, model.layout) @ [x_sp, x_pr, theta])[:3]
    theta_p = -(link + planet)
    # The radii above are given to seven digits and the rotations are near 1 rad.
    assert r_s * sun - r_p * theta_p - r_cp * link == pytest.approx(x_sp, abs=3e-8)
    assert r_p * theta_p - r_cp * link == pytest.approx(x_pr, abs=3e-8)


def test_mass_matrix_is_the_kinetic_energy_of_the_bodies():
    for settings in ((), ("arm.joints.1.ring_inertia_kg_m2=0.18",)):
        model = tree(*settings)
        for q, v in random_states():
            energy = v @ model.mass_matrix(q) @ v / 2
            # Sums of some twenty positive terms on either side.
            assert energy == pytest.approx(kinetic_energy(model.arm, q, v), rel=1e3 * EPSILON)


def test_without_gears_it_is_the_two_link_arm_of_the_textbooks():
    model = tree(*WEIGHTLESS_GEARS)
    m_1, m_2, m_t, l_1, l_2 = 27.0, 18.9, 10.0, 1.0, 0.7
    q, v = np.array([0, 0, 0.3, 0, 0, 0.9]), np.array([0, 0, 1.1, 0, 0, -2.0])
    outer = (m_2 / 3 + m_t) * l_2**2
    lever = (m_2 / 2 + m_t) * l_1 * l_2
    c, s = np.cos(q[5]), np.sin(q[5])
    inner = m_1 * l_1**2 / 3 + (m_2 + m_t) * l_1**2
    mass = [[inner + outer + 2 * lever * c, outer + lever * c], [outer + lever * c, outer]]
    bias = [-lever * s * (2 * v[2] + v[5]) * v[5], lever * s * v[2] ** 2]
    # Gears of 1e-12 kg are left, and a few sums.
    np.testing.assert_allclose(model.mass_matrix(q)[2::3, 2::3], mass, rtol=1e-13)
    np.testing.assert_allclose(model.bias(q, v)[2::3], bias, rtol=1e-13)


def test_force_is_minus_the_gradient_of_the_spring_energy():
    model = tree(*SMOOTH)

    def energy(q: np.ndarray) -> float:
        x = q.reshape(2, 3)[:, :2]
        return float(3 * 1e8 * np.sum(np.maximum(abs(x) - 50e-6, 0) ** 2) / 2)

    for q, _ in random_states():
        steps = np.diag(np.array([1e-8, 1e-8, 1e-3] * 2))
        gradient = [(energy(q + h) - energy(q - h)) / (2 * h.sum()) for h in steps]
        force = model.generalized_force(0.0, q, np.zeros(6))
        # Central differences of a parabola are exact: energies of 10 J, rounded, over 2e-8 m.
        np.testing.assert_allclose(force, -np.array(gradient), rtol=0, atol=1e-6)


def test_power_of_the_forces_is_the_rate_of_the_kinetic_energy():
    model = tree()
    for q, v in random_states():
        a, eps = model.acceleration(0.2, q, v), 1e-6
        later, earlier = (model.mass_matrix(q + h * v) for h in (eps, -eps))
        rate = v @ model.mass_matrix(q) @ a + v @ (later - earlier) @ v / (4 * eps)
        power = v @ model.generalized_force(0.2, q, v)
        # Central differences leave eps^2 of 20 J/s and 1e-16 of 100 J over eps.
        assert rate == pytest.approx(power, abs=1e-7)


def test_only_the_ground_changes_the_angular_momentum():
    model = tree("scenario.drive.torque_N_m=[130.0, -70.0]")
    arm, ratio, r_r = model.arm, 99 / 27 + 1, 36.82406e-3 + 2 * 49.09875e-3
    for q, v in random_states():
        a, eps = model.acceleration(0.0, q, v), 1e-6
        later, earlier = (angular_momentum(arm, q + h * v, v + h * a) for h in (eps, -eps))
        law = mesh_law(arm.joints[0], model.switches, "ring", 0)
        spring = elastic_forces(law.array, np.zeros(1), q[1:2], q[2:3], v[2:3])[0]
        ring = 3 * spring + 2437.212 * v[1]
        # Momenta near 100 N m s rounded, over 2e-6 s; r_r and the damping have seven digits.
        assert (later - earlier) / (2 * eps) == pytest.approx(
            130 / ratio + ring * r_r, rel=1e-6, abs=1e-6
        )


def test_mesh_modes_with_the_carrier_locked():
    model = first_joint_only(tree(*SMOOTH, TIGHT))
    q = np.zeros(3)
    stiffness = [-model.generalized_force(0.0, h, q)[:2] / 1e-6 for h in 1e-6 * np.eye(3)[:2]]
    squares = np.linalg.eigvals(np.linalg.solve(model.mass_matrix(q)[:2, :2], stiffness))
    # The reference values have five digits.
    np.testing.assert_allclose(np.sqrt(np.sort(squares)) / (2 * np.pi), [1709.9, 4466.6], atol=0.05)


def test_rk44_has_order_four_while_the_teeth_stay_in_contact():
    settings = (
        "scenario.duration_s=0.002",
        "scenario.start.sun_planet_offset_m=2.2e-6",
        "scenario.start.planet_ring_offset_m=2.2e-6",
    )
    runs = []
    for every in (2, 4, 8, 32):
        step = f"scenario.step_s={2e-5 / every}"
        run = tree(*settings, step, f"scenario.record_every={every}").simulate()
        assert run.F_sp.values.min() > 0 < run.F_pr.values.min()
        runs.append(np.stack([run.x_sp, run.x_pr]))
    errors = [abs(run - runs[-1]).max() for run in runs[:-1]]
    # The fastest mode turns by 0.28 rad in the largest step, whose square is the next term's share.
    np.testing.assert_allclose(np.log2(np.divide(errors[:-1], errors[1:])), 4, atol=0.1)


def classic_rk4(model: ExudynTree, h: float, steps: int) -> tuple[np.ndarray, np.ndarray]:
    """The textbook method on the model's own accelerations, its clock k h."""
    state = np.array([paper_from_tree(model.arm, model.layout) @ part for part in model.start()])

    def rate(t: float, s: np.ndarray) -> np.ndarray:
        return np.array([s[1], model.acceleration(t, s[0], s[1])])

    for k in range(steps):
        k_1 = rate(k * h, state)
        k_2 = rate((k + 0.5) * h, state + h / 2 * k_1)
        k_3 = rate((k + 0.5) * h, state + h / 2 * k_2)
        k_4 = rate((k + 1) * h, state + h * k_3)
        state = state + h / 6 * (k_1 + 2 * k_2 + 2 * k_3 + k_4)
    return state[0], state[1]


@pytest.mark.parametrize("phase", ["angle", "omega_t"])
def test_connectors_and_motors_act_at_the_times_of_the_stages(phase):
    settings = ("scenario.step_s=1e-5", "scenario.duration_s=0.003", "scenario.record_every=7")
    case = load_case("paper-labelled", "back-and-forth", {"phase": phase}, settings)
    model = ExudynTree(*case)
    run = model.simulate()
    q, v = classic_rk4(model, 1e-5, 300)
    end = run.isel(time=-1)
    np.testing.assert_allclose(run.time, 1e-5 * np.arange(0, 301), rtol=4 * EPSILON)
    # 300 steps round rotations below 0.1 rad to 1e-17 each; rates follow with the modes' 3e4 rad/s.
    np.testing.assert_allclose(end.theta, q[2::3], rtol=0, atol=1e-15)
    np.testing.assert_allclose(end.theta_dot, v[2::3], rtol=0, atol=1e-12)
    np.testing.assert_allclose(end.x_sp, q[0::3, None] * np.ones(3), rtol=0, atol=1e-15)


def test_records_belong_to_the_recorded_state():
    model = tree("scenario.duration_s=0.002", "scenario.step_s=2e-6", "scenario.record_every=1")
    run = model.simulate()
    assert dict(run.sizes) == {"time": 1001, "joint": 2, "planet": 3}
    for record, rate in ((run.theta, run.theta_dot), (run.theta_dot, run.theta_ddot)):
        differences = (record.values[2:] - record.values[:-2]) / 4e-6
        # Mesh modes of 3e4 rad/s: central differences are off by (3e4 * 2e-6)^2 / 6 of the largest;
        # twice that for the kinks of the clearance.
        off = abs(differences - rate.values[1:-1]).max()
        assert off < 1.2e-3 * abs(rate).max()
    np.testing.assert_array_equal(run.torque, 100.0)
    law = mesh_law(model.arm.joints[0], model.switches, "sun", 0).array
    x, theta = run.x_sp.values[:, 0, 0], run.theta.values[:, 0]
    forces = elastic_forces(law, run.time.values, x, theta, run.theta_dot.values[:, 0])
    np.testing.assert_array_equal(run.F_sp[:, 0, 0], forces)


def test_too_large_a_step_diverges_in_silence_and_says_when(capfd):
    model = tree("scenario.duration_s=0.1", "scenario.step_s=2e-4", TIGHT)
    assert model.largest_stable_step() < 2e-4
    with pytest.raises(Diverged, match="exudyn:tree: diverged at t = 0"):
        model.simulate()
    assert capfd.readouterr() == ("", "")


def test_largest_stable_step_is_where_the_motion_begins_to_grow():
    linear = (
        TIGHT,
        *SMOOTH,
        "scenario.start.sun_planet_offset_m=1e-6",
    )
    limit = first_joint_only(tree(*linear)).largest_stable_step()
    peaks = []
    for step in (0.98 * limit, 1.02 * limit):
        settings = (*linear, f"scenario.step_s={step}", f"scenario.duration_s={100 * step}")
        run = first_joint_only(tree(*settings)).simulate()
        peaks.append(float(abs(run.x_sp).max()))
    # |R| = 1.15 two percent beyond the limit: 100 steps leave no doubt.
    assert peaks[0] < 1e-5 < 1e-3 < peaks[1]

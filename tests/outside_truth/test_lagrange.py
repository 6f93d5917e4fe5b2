"""The derivation against closed forms and against identities of mechanics."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from crosscheck.analytic.model import PhysicalModel, RigidCoupled
from crosscheck.analytic.stability import contact_eigenvalues
from crosscheck.models.arm.arm import Planetary
from crosscheck.models.arm.stiffness import SineStiffness
from crosscheck.models.loading import load_arm, load_case, load_scenario
from tests.arms import PAPER, arms, geared_arms
from tests.loops import require_items

seeds = st.integers(0, 2**32 - 1)


def test_two_link_mass_matrix_in_closed_form(labelled):
    """M11 = a11 + a2 + a3 + 2 a4 c + M_s r_s^2 + 3 M_p r_p^2 and so on, by hand for two joints."""
    M_s, M_p, M_c, m_p, m_j, payload = 0.5, 0.66, 5.8, 0.61, 0.39 + 3 * 0.61 + 6.29 + 10, 10
    r_s, r_p, r_cp, r_c = 0.0368240624, 0.0490987499, 0.0859228123, 0.0945
    carrier = M_c * r_cp**2 + 3 * m_p * r_c**2
    a1 = (4 * M_s + 3 * M_p) * r_cp**2
    a2 = carrier + 27 / 12 + 27 * 0.25 + 18.9 + m_j + payload
    a3 = carrier + 18.9 * 0.49 / 12 + 18.9 * 0.35**2 + payload * 0.49
    a4 = 18.9 * 0.35 + payload * 0.7
    cosine = np.cos(0.7)
    m12 = a3 + a4 * cosine + 2 * M_s * r_s * r_cp - 3 * M_p * r_p * r_cp
    m11 = a1 + a2 + a3 + 2 * a4 * cosine + M_s * r_s**2 + 3 * M_p * r_p**2
    model = RigidCoupled(labelled, load_scenario("pd"))
    # Radii above are rounded to 1e-10 m.
    expected = np.array([[m11, m12], [m12, a1 + a3]])
    assert model.mass_matrix(np.array([0.3, 0.7])) == pytest.approx(expected, abs=1e-8)


def _state(model: PhysicalModel, seed: int) -> tuple[np.ndarray, np.ndarray]:
    generator = np.random.default_rng(seed)
    q, v = generator.uniform(-1, 1, (2, len(model.coordinates)))
    mesh = ~model.layout.angular
    q[mesh] *= 1e-4
    v[mesh] *= 1e-2
    return q, v


@settings(max_examples=20)  # each new number of joints derives its equations once
@given(arms, seeds)
def test_mass_matrix_is_symmetric_and_positive_definite(arm, seed):
    model = PhysicalModel(arm, load_scenario("pd"))
    mass = model.mass_matrix(_state(model, seed)[0])
    assert np.array_equal(mass, mass.T)
    assert np.linalg.eigvalsh(mass).min() > 0


@settings(max_examples=20)
@given(arms, seeds)
def test_inertial_forces_do_no_work_of_their_own(arm, seed):
    """d(v'Mv/2)/dt = v'(M a + bias): the bias is that of the mass matrix."""
    model = PhysicalModel(arm, load_scenario("pd"))
    q, v = _state(model, seed)
    h = 1e-6
    change = (model.mass_matrix(q + h * v) - model.mass_matrix(q - h * v)) / (2 * h)
    size = np.abs(v) @ np.abs(model.mass_matrix(q)) @ np.abs(v)
    # Central difference: h^2 of truncation and eps / h of rounding.
    assert v @ change @ v / 2 == pytest.approx(v @ model.bias(q, v), abs=1e-9 * size + 1e-12)


def _springs(joint: Planetary) -> Planetary:
    """A joint whose meshes are springs with play and nothing else; no friction."""
    meshes = {}
    for name, mesh in (("sun_mesh", joint.sun_mesh), ("ring_mesh", joint.ring_mesh)):
        stiffness = SineStiffness(law="sine", mean_N_per_m=9e7, amplitude_N_per_m=0.0)
        undamped = {"damping_ratio": 0.0, "damping_N_s_per_m": None, "tooth_error_m": 0.0}
        meshes[name] = mesh.model_copy(update={"stiffness": stiffness, **undamped})
    return joint.model_copy(update={"friction_N_m_s_per_rad": 0.0, **meshes})


@settings(max_examples=15)
@given(geared_arms, seeds)
def test_mesh_forces_are_the_slope_of_a_potential(arm, seed):
    """Constant stiffness, no tooth error, no damping: F = -dV/dq with V = N k f_k^2 / 2."""
    joints = tuple(_springs(joint) for joint in arm.joints)
    still = load_case("paper-labelled", "constant-torque", settings=["scenario.drive.torque_N_m=0"])
    weightless = {"joints": joints, "gravity_m_per_s2": (0.0, 0.0)}
    model = PhysicalModel(arm.model_copy(update=weightless), still.scenario)
    q, v = _state(model, seed)

    def potential(displacement: np.ndarray) -> float:
        energy = 0.0
        for number, joint in enumerate(joints):
            for name, mesh in (("x_sp", joint.sun_mesh), ("x_pr", joint.ring_mesh)):
                x = displacement[model.layout.at(name, number)]
                beyond = max(abs(x) - mesh.backlash_m, 0.0)
                energy += joint.planet_count * mesh.stiffness.mean_N_per_m * beyond**2 / 2
        return energy

    h = 1e-9
    slope = [(potential(q + h * e) - potential(q - h * e)) / (2 * h) for e in np.eye(q.size)]
    # Second difference at the kink of the dead zone: at most N k h / 2.
    assert model.generalized_force(0.0, q, v) == pytest.approx(-np.array(slope), abs=1.0)


def test_modes_of_one_stage_with_the_carrier_locked():
    """Two springs in a row on sun and planets: 1709.9 and 4466.6 Hz for the paper's stage."""
    N, k, M_s, M_p = 3, 1e8, 0.5, 0.66
    mass = np.array([[M_s, M_s], [M_s, M_s + N * M_p]])
    squares = np.linalg.eigvals(np.linalg.solve(mass, N * k * np.eye(2)))
    frequencies = np.sort(np.sqrt(squares.real)) / (2 * np.pi)
    assert frequencies == pytest.approx([1709.9, 4466.6], abs=0.05)
    # A link a million times heavier locks the carrier.
    heavy = {"density_kg_per_m3": 2.7e9}
    joint = _springs(PAPER.joints[0])
    links = (PAPER.links[0].model_copy(update=heavy),)
    arm = PAPER.model_copy(update={"links": links, "joints": (joint,)})
    model = PhysicalModel(arm, load_scenario("constant-torque"))
    poles = contact_eigenvalues(model.terms, model.gears, model.drive, np.zeros(3), np.full(2, 1e8))
    modes = np.sort(np.abs(poles[poles.imag > 1])) / (2 * np.pi)
    assert modes == pytest.approx(frequencies, rel=1e-6)


def test_the_phase_law_counts_time_only_under_omega_t(labelled):
    """A mechanism cannot know what time it is; omega_t makes the mesh force depend on it."""
    scenario = load_scenario("constant-torque")
    for phase, depends in (("angle", False), ("omega_t", True)):
        case = load_case("paper-labelled", "constant-torque", {"phase": phase})
        model = PhysicalModel(labelled, scenario, case.switches)
        q, v = np.array([1e-4, 1e-4, 0.3] * 2), np.array([0, 0, 0.5] * 2)
        forces = [model.generalized_force(t, q, v) for t in (0.0, 1.0, 5.0)]
        assert (np.ptp(forces, axis=0).max() > 1.0) == depends


def test_both_readings_load_and_differ():
    labelled, swapped = load_arm("paper-labelled"), load_arm("paper-swapped")
    pairs = ("sun", "planet", "carrier")
    for part in require_items(pairs):
        assert getattr(labelled.joints[0], f"{part}_mass_kg") == getattr(
            swapped.joints[0], f"{part}_equivalent_mass_kg"
        )

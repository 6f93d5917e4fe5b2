"""Eqs. 2-15 against what they must satisfy on their own account."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from crosscheck.analytic.paper import mesh_frequency
from crosscheck.analytic.paper.kinematics import gear_angles, mesh_displacements, stage_geometry
from crosscheck.analytic.paper.mesh_force import (
    EXACT,
    dead_zone,
    dead_zone_tanh,
    is_in_contact,
    mesh_force,
    tooth_error,
    total_error,
)
from crosscheck.analytic.paper.stiffness import (
    fundamental_stiffness,
    square_wave,
    square_wave_series,
)
from crosscheck.models.loading import load_arm

JOINT = load_arm("paper-labelled").joints[0]
GEOMETRY = stage_geometry(JOINT)
angles = st.floats(-10, 10)


def test_geometry_of_the_paper():
    # Radii in mm from module 3 mm, 27/36/99 teeth, 24.6 degrees; digits as far as printed.
    assert 1e3 * GEOMETRY.r_s == pytest.approx(36.82406, abs=5e-6)
    assert 1e3 * GEOMETRY.r_p == pytest.approx(49.09875, abs=5e-6)
    assert 1e3 * GEOMETRY.r_cp == pytest.approx(85.92281, abs=5e-6)
    assert GEOMETRY.r_cp == pytest.approx(GEOMETRY.r_s + GEOMETRY.r_p, rel=1e-15)
    assert GEOMETRY.n == pytest.approx(4.6667, abs=5e-5)


@given(angles, angles, angles)
def test_gear_angles_invert_mesh_displacements(theta_s, theta_p, theta_c):
    radii = GEOMETRY.r_s, GEOMETRY.r_p, GEOMETRY.r_cp
    x_sp, x_pr = mesh_displacements(theta_s, theta_p, theta_c, *radii)
    # Rounding of sums of arcs up to 2 m.
    assert gear_angles(x_sp, x_pr, theta_c, *radii) == pytest.approx((theta_s, theta_p), abs=1e-12)


@given(angles)
def test_rigid_gears_turn_by_the_ratio(theta_c):
    radii = GEOMETRY.r_s, GEOMETRY.r_p, GEOMETRY.r_cp
    theta_s, _ = gear_angles(0.0, 0.0, theta_c, *radii)
    assert theta_s == pytest.approx(GEOMETRY.n * theta_c, rel=1e-14, abs=1e-14)


@given(st.floats(-1e-3, 1e-3), st.floats(0, 1e-4))
def test_dead_zone_is_odd_and_shortens_by_b(x, b):
    assert dead_zone(x, b) == -dead_zone(-x, b)
    assert dead_zone(x, b) == pytest.approx(np.sign(x) * max(abs(x) - b, 0.0), abs=1e-18)


def test_tanh_dead_zone_converges_to_the_exact_one():
    b = 5e-5
    errors = []
    for sigma in (1e6, 1e7, 1e8):
        x = b + np.linspace(-10, 10, 20001) / sigma
        errors.append(np.abs(dead_zone_tanh(x, b, sigma) - dead_zone(x, b)).max())
    # The error is a fixed curve of sigma (x - b), so it shrinks with 1 / sigma.
    assert errors[0] / errors[1] == pytest.approx(10, rel=1e-3)
    assert errors[1] / errors[2] == pytest.approx(10, rel=1e-3)


def test_tanh_dead_zone_attracts_outside_contact():
    """Eq. 6 is not monotone: 0.139 / sigma of pull just outside the teeth (physics of the law)."""
    sigma, b = 1e7, 5e-5
    x = np.linspace(b - 1e-6, b, 100001)
    assert -dead_zone_tanh(x, b, sigma).min() * sigma == pytest.approx(0.139, abs=5e-4)


def test_stiffness_series_converges_to_the_square_wave():
    cycle = (np.arange(500) + 0.5) / 500
    series = square_wave_series(cycle, 1.0, 2.0, 1.6, 4000)
    away = np.minimum(np.abs(cycle - 0.6), np.minimum(cycle, 1 - cycle)) > 0.01
    exact = square_wave(cycle, 1.0, 2.0, 1.6)
    # The remainder of a Fourier series of n terms at a distance d from a jump is about 1/(n d).
    assert np.abs(series - exact)[away].max() < 1 / (4000 * 0.01 * np.pi)


def test_only_contact_ratio_one_and_a_half_gives_eq_8():
    """Then, with k_max - k_min = pi k_a / 2, the first harmonic of Eq. 7 has no phase."""
    cycle, k_m, k_a = np.linspace(0, 1, 101), 1e8, 2e7
    k_min, k_max = k_m - np.pi * k_a / 4, k_m + np.pi * k_a / 4
    series = square_wave_series(cycle, k_min, k_max, 1.5, 1)
    assert series == pytest.approx(
        fundamental_stiffness(np.sin(2 * np.pi * cycle), k_m, k_a), rel=1e-12
    )


def test_meshing_rates():
    assert mesh_frequency.sun_mesh_rate(JOINT, GEOMETRY) == pytest.approx(99, rel=1e-14)
    assert mesh_frequency.ring_mesh_rate(JOINT, GEOMETRY, "eq13") == pytest.approx(27, rel=1e-14)
    assert mesh_frequency.ring_mesh_rate(JOINT, GEOMETRY, "corrected") == pytest.approx(
        99, rel=1e-14
    )


@given(st.floats(-5, 5))
def test_both_meshes_of_a_stage_have_one_frequency(theta_c_dot):
    """Teeth pass sun and ring mesh equally often: seen from the carrier, z_r teeth per turn."""
    ring = mesh_frequency.meshing_frequency(0.0, theta_c_dot, JOINT.ring_teeth)
    sun = mesh_frequency.sun_mesh_frequency(0.0, 0.0, theta_c_dot, GEOMETRY, JOINT.sun_teeth)
    corrected = mesh_frequency.ring_mesh_rate(JOINT, GEOMETRY, "corrected") * theta_c_dot
    assert abs(ring) == pytest.approx(abs(sun), abs=1e-12)
    assert abs(ring) == pytest.approx(abs(corrected), abs=1e-12)


@given(angles, angles)
def test_the_tooth_errors_own_phase_is_a_lead(lead, phase):
    """At minus the lead it is where an error without one begins, and from there on the same."""
    moved = total_error(phase - lead, 5e-6, lead, -2e-6)
    assert moved == pytest.approx(-2e-6 + 5e-6 * np.sin(phase), abs=1e-19)


@given(st.floats(-1, 1), st.floats(-2e-4, 2e-4))
def test_mesh_force_pushes_only_in_contact(sine, x):
    gap = x - tooth_error(sine, 5e-6)
    force = mesh_force(EXACT, gap, fundamental_stiffness(sine, 1e8, 2e7), 5e-5, 1e8)
    assert (force != 0) == bool(is_in_contact(gap, 5e-5)) or abs(force) < 1e-6
    assert force * gap >= 0

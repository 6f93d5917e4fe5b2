"""Mesh modes: the frequencies at which the teeth ring."""

from __future__ import annotations

from typing import Literal

import numpy as np

from crosscheck.checks.scales import base_radius
from crosscheck.findings import About, Finding, checked
from crosscheck.models.arm.arm import Planetary
from crosscheck.models.arm.stiffness import SquareStiffness, StiffnessLaw, TableStiffness

TOLERANCE = 1e-6
BASIS = "1e-6: engines linearise by finite differences of forces of 1e4 N at 1e-7 relative steps"
# A carrier is locked by a link this many times heavier: the modes move by about its inverse.
LOCK = 1e9


def modes_among(about: About, few: np.ndarray, many: np.ndarray) -> Finding:
    """Each of some modes [Hz] must be one of the others; of as many, each its own."""
    if len(few) == len(many):
        distance = np.abs(np.sort(few) - np.sort(many)) / np.sort(few)
    else:
        distance = np.abs(few[:, None] - many[None, :]).min(axis=1) / few
    measured = float(distance.max())
    return checked(
        about,
        measured=measured,
        tolerance=TOLERANCE,
        basis=BASIS,
        relative=measured,
        note="modes [Hz]: " + ", ".join(f"{mode:.2f}" for mode in few),
    )


def closed_form_modes(joint: Planetary) -> np.ndarray:
    """Both modes [Hz] of a stage with its carrier locked, ascending.

    With u = r_s theta_s and w = r_p theta_p: M_s u'' = -K_s (u - w) and
    N M_p w'' = K_s (u - w) - K_r w, K = N k of sun and ring mesh, so omega^2 solves a quadratic.
    """
    sun, planet = equivalent_mass(joint, "sun"), equivalent_mass(joint, "planet")
    first = joint.sun_mesh.of_planet(0), joint.ring_mesh.of_planet(0)
    K_s, K_r = (joint.planet_count * mean_stiffness(mesh.stiffness) for mesh in first)
    planets = joint.planet_count * planet
    mean = (K_s / sun + (K_s + K_r) / planets) / 2
    root = np.sqrt(mean**2 - K_s * K_r / (sun * planets))
    return np.sqrt(np.array([mean - root, mean + root])) / (2 * np.pi)


def free_modes(joint: Planetary) -> np.ndarray:
    """All modes [Hz] of a stage of free planets with its carrier locked, ascending, (N + 1,).

    M_s u'' = -sum of k_sn (u - w_n), M_p w_n'' = k_sn (u - w_n) - k_rn w_n; unlike planets too.
    """
    count = joint.planet_count
    roots = np.sqrt([equivalent_mass(joint, "sun"), *[equivalent_mass(joint, "planet")] * count])
    matrix = np.zeros((count + 1, count + 1))
    for n in range(count):
        k_s = mean_stiffness(joint.sun_mesh.of_planet(n).stiffness)
        k_r = mean_stiffness(joint.ring_mesh.of_planet(n).stiffness)
        matrix[0, 0] += k_s
        matrix[n + 1, n + 1] = k_s + k_r
        matrix[0, n + 1] = matrix[n + 1, 0] = -k_s
    return np.sqrt(np.linalg.eigvalsh(matrix / np.outer(roots, roots))) / (2 * np.pi)


def mean_stiffness(law: StiffnessLaw) -> float:
    """Over a period of the mesh [N/m]."""
    if isinstance(law, TableStiffness):
        from scipy.interpolate import CubicSpline  # a third of a second, for tables alone

        spline = CubicSpline(law.phase_cycles, law.stiffness_N_per_m, bc_type="periodic")
        return float(spline.integrate(0, 1))
    if isinstance(law, SquareStiffness):
        share = law.contact_ratio - 1
        return law.least_N_per_m * (1 - share) + law.largest_N_per_m * share
    return law.mean_N_per_m


def equivalent_mass(joint: Planetary, gear: Literal["sun", "planet"]) -> float:
    """J / r^2 [kg], r the base radius."""
    sun = gear == "sun"
    mass = joint.sun_equivalent_mass_kg if sun else joint.planet_equivalent_mass_kg
    inertia = joint.sun_inertia_kg_m2 if sun else joint.planet_inertia_kg_m2
    teeth = joint.sun_teeth if sun else joint.planet_teeth
    return mass if mass is not None else (inertia or 0.0) / base_radius(joint, teeth) ** 2

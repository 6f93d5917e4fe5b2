"""Mesh modes: the frequencies at which the teeth ring."""

from __future__ import annotations

import numpy as np

from crosscheck.findings import About, Finding, checked
from models.arm import Joint

TOLERANCE = 1e-6
BASIS = "1e-6: engines linearise by finite differences of forces of 1e4 N at 1e-7 relative steps"
# A carrier is locked by a link this many times heavier: the modes move by about its inverse.
LOCK = 1e9


def modes_among(about: About, few: np.ndarray, many: np.ndarray) -> Finding:
    """Each of some modes [Hz] must be one of the others."""
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


def closed_form_modes(joint: Joint) -> np.ndarray:
    """Both modes [Hz] of a stage with its carrier locked, ascending.

    With u = r_s theta_s and w = r_p theta_p: M_s u'' = -K (u - w) and N M_p w'' = K (u - w) - K w,
    K = N k, so omega^2 solves a quadratic.
    """
    stiffness = joint.planet_count * joint.mesh_stiffness_N_per_m
    sun = stiffness / joint.sun_equivalent_mass_kg
    planets = stiffness / (joint.planet_count * joint.planet_equivalent_mass_kg)
    mean, product = (sun + 2 * planets) / 2, sun * planets
    root = np.sqrt(mean**2 - product)
    return np.sqrt(np.array([mean - root, mean + root])) / (2 * np.pi)

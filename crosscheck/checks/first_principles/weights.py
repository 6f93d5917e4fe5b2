"""Gravity torques of an arm, from the places of its masses alone."""

from __future__ import annotations

import numpy as np

from crosscheck.models.arm.arm import Arm, Direct, Link, Planetary


def weight_moments(arm: Arm, theta: np.ndarray) -> np.ndarray:
    """Moment [N m] about every joint's axis of the weight of all that it carries, (joints,).

    theta (joints,): relative angles. Sun, planets and ring of a joint balance on its axis.
    """
    masses, places, owners = _masses(arm, theta)
    axes, pull = places[len(theta) : 2 * len(theta)], complex(*arm.gravity_m_per_s2)
    joint_moments = []
    for joint, axis in enumerate(axes):
        moments = masses * (np.conj(places - axis) * pull).imag
        joint_moments.append(float(moments[owners >= joint].sum()))
    return np.array(joint_moments)


def weight_energy(arm: Arm, theta: np.ndarray) -> np.ndarray:
    """Potential energy of all masses in gravity [J], shape (times,), theta (times, joints)."""
    pull = complex(*arm.gravity_m_per_s2)
    placed_masses = (_masses(arm, angles) for angles in theta)
    return np.array(
        [-float((m * (np.conj(places) * pull).real).sum()) for m, places, _ in placed_masses]
    )


def _masses(arm: Arm, theta: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Masses [kg], their complex places [m], and the first joint that carries each.

    The order is links, joints, and the payload.
    """
    directions = np.exp(1j * np.cumsum(theta))
    lengths = np.array([link.length_m for link in arm.links])
    ends = np.cumsum(lengths * directions)
    axes = np.array([0.0, *ends[:-1]])
    coms = axes + np.array([link.com_m for link in arm.links]) * directions
    masses = [*map(link_mass, arm.links), *map(joint_mass, arm.joints), arm.payload_mass_kg]
    joints = range(len(axes))
    owners = np.array([*joints, *joints, len(axes)])
    return np.array(masses), np.array([*coms, *axes, ends[-1]]), owners


def joint_mass(joint: Planetary | Direct) -> float:
    """Mass of all that is centred on a joint's axis [kg]."""
    if isinstance(joint, Direct):
        return joint.motor_mass_kg
    planets = joint.planet_count * joint.planet_mass_kg
    return joint.sun_mass_kg + planets + joint.carrier_mass_kg + joint.ring_mass_kg


def link_mass(link: Link) -> float:
    """Mass of a link [kg]: of a rod by its section and density, or as given."""
    if link.mass_kg is not None:
        return link.mass_kg
    section, density = link.cross_section_m2 or 0.0, link.density_kg_per_m3 or 0.0
    return section * density * link.length_m

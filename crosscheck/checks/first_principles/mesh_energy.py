"""What the springs of an arm's teeth hold, from its data alone: 1/2 k f^2 of every mesh."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from crosscheck.checks.scales import geared_joints
from crosscheck.models.arm import stiffness
from crosscheck.models.arm.arm import Arm, Planetary
from crosscheck.models.experiment.scenario import Switches


class MeshSpring(NamedTuple):
    """The spring of one mesh along a way: clearance b [m], k [N/m] and x - e [m], both (times,)."""

    backlash: float
    stiffness: np.ndarray
    gap: np.ndarray


def mesh_springs(
    arm: Arm, chosen: Switches, theta: np.ndarray, x_sp: np.ndarray, x_pr: np.ndarray
) -> Iterator[MeshSpring]:
    """The spring of every mesh of every planet, with the mesh phase by the angle.

    theta (times, joints) [rad]; x_sp, x_pr (times, joints, planets) [m].
    """
    for number, joint in geared_joints(arm):
        # Teeth that pass a planet per turn of the carrier, at sun and ring; or as Eq. 13 has them.
        printed = chosen.ring_rate == "eq13"
        rates = joint.ring_teeth, joint.sun_teeth if printed else joint.ring_teeth
        for planet in range(joint.planet_count):
            contacts = joint.sun_mesh.planet_mesh(planet), joint.ring_mesh.planet_mesh(planet)
            phases = _constants(joint, planet)
            for mesh, rate, constant, x in zip(contacts, rates, phases, (x_sp, x_pr), strict=True):
                phase = rate * theta[:, number] + constant
                wave = np.sin(phase + mesh.tooth_error_phase_rad)
                gap = x[:, number, planet] - mesh.static_error_m - mesh.tooth_error_m * wave
                yield MeshSpring(mesh.backlash_m, stiffness_at(mesh.stiffness, phase), gap)


def spring_energy(spring: MeshSpring) -> np.ndarray:
    """Energy 1/2 k f^2 [J], (times,): what of x - e is beyond the clearance is pressed in."""
    pressed = np.maximum(np.abs(spring.gap) - spring.backlash, 0.0)
    return spring.stiffness * pressed**2 / 2


def _constants(joint: Planetary, planet: int) -> tuple[float, float]:
    """Constants added to a planet's phases at sun and ring [rad], given or by the teeth.

    A planet further round meets a sun tooth later and, the carrier moving into the ring, a ring
    tooth sooner; at the ring the planet's other flank carries, half of its teeth further.
    """
    turn = 2 * math.pi * planet / joint.planet_count
    sun, ring = (mesh.planet_mesh(planet).phase_rad for mesh in (joint.sun_mesh, joint.ring_mesh))
    start = joint.sun_mesh.planet_mesh(0).phase_rad or 0.0
    if ring is None:
        half = 0.0 if joint.planet_teeth % 2 else math.pi
        ring = start + math.fmod(joint.ring_teeth * turn, 2 * math.pi) + half
    return math.fmod(-joint.sun_teeth * turn, 2 * math.pi) if sun is None else sun, ring


def stiffness_at(law: stiffness.StiffnessLaw, phase: np.ndarray) -> np.ndarray:
    """Stiffness k [N/m] of a law at phases [rad], of the phases' shape."""
    if isinstance(law, stiffness.SineStiffness):
        return law.mean_N_per_m + law.amplitude_N_per_m * np.sin(phase)
    if isinstance(law, stiffness.FourierStiffness):
        k = np.full(phase.shape, law.mean_N_per_m)
        for order, size in enumerate(law.cosine_N_per_m, 1):
            k += size * np.cos(order * phase)
        for order, size in enumerate(law.sine_N_per_m, 1):
            k += size * np.sin(order * phase)
        return k
    if isinstance(law, stiffness.SquareStiffness):  # Eq. 7
        overlap = law.contact_ratio - 1
        series = np.full(phase.shape, overlap)
        for i in range(1, law.harmonics + 1):
            shifted = np.sin(i * (2 * np.pi * overlap - phase))
            series += (shifted + np.sin(i * phase)) / (i * np.pi)
        return law.least_N_per_m + (law.largest_N_per_m - law.least_N_per_m) * series
    from scipy.interpolate import CubicSpline  # a third of a second, for tables alone

    spline = CubicSpline(law.phase_cycles, law.stiffness_N_per_m, bc_type="periodic")
    return np.asarray(spline(np.mod(phase / (2 * np.pi), 1.0)))


def highest_harmonic(law: stiffness.StiffnessLaw) -> int:
    """The highest order of a law's waves, or how many pieces its period has."""
    if isinstance(law, stiffness.SineStiffness):
        return 1
    if isinstance(law, stiffness.FourierStiffness):
        return max(len(law.cosine_N_per_m), len(law.sine_N_per_m), 1)
    if isinstance(law, stiffness.SquareStiffness):
        return law.harmonics
    return len(law.phase_cycles)

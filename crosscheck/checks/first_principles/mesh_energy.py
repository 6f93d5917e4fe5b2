"""Energy stored in an arm's teeth, from its data alone: 1/2 k f^2 of every mesh."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from crosscheck.checks.scales import geared_joints
from crosscheck.models.arm import stiffness
from crosscheck.models.arm.arm import Arm
from crosscheck.models.arm.gears import PlanetaryStage
from crosscheck.models.experiment.scenario import Switches

POINTS = np.array([0, -2, -1, 1, 2])


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
    printed = chosen.ring_rate == "eq13"
    for number, joint in geared_joints(arm):
        for planet in range(joint.planet_count):
            x = x_sp[:, number, planet], x_pr[:, number, planet]
            yield from planet_springs(joint, planet, theta[:, number], x, printed=printed)


def planet_springs(
    stage: PlanetaryStage,
    planet: int,
    theta: np.ndarray,
    displacements: tuple[np.ndarray, np.ndarray],
    *,
    printed: bool = False,
) -> Iterator[MeshSpring]:
    """The springs of a planet with sun and ring, where the joint has turned by theta [rad].

    displacements: x_sp and x_pr [m], of theta's shape; printed: the ring's phase as Eq. 13 has it.
    """
    # Teeth that pass a planet per turn of the carrier, at sun and ring.
    rates = stage.ring_teeth, stage.sun_teeth if printed else stage.ring_teeth
    contacts = stage.sun_mesh.planet_mesh(planet), stage.ring_mesh.planet_mesh(planet)
    phases = _constants(stage, planet)
    for mesh, rate, constant, x in zip(contacts, rates, phases, displacements, strict=True):
        phase = rate * theta + constant
        wave = np.sin(phase + mesh.tooth_error_phase_rad)
        gap = x - mesh.static_error_m - mesh.tooth_error_m * wave
        yield MeshSpring(mesh.backlash_m, stiffness_at(mesh.stiffness, phase), gap)


def spring_energy(spring: MeshSpring) -> np.ndarray:
    """Energy 1/2 k f^2 [J], (times,): what of x - e is beyond the clearance is pressed in."""
    pressed = np.maximum(np.abs(spring.gap) - spring.backlash, 0.0)
    return spring.stiffness * pressed**2 / 2


def energy_slope(spring: MeshSpring, step: float | np.ndarray) -> np.ndarray:
    """Slope of the energy at the first of ``POINTS`` steps along ways, teeth on that one's flank.

    The spring's arrays are (5,) or (5, ways); a central difference of fourth order.
    """
    flank = spring.backlash * np.sign(spring.gap[0])
    energy = spring.stiffness * (spring.gap - flank) ** 2 / 2
    slope = np.array([0, 1, -8, 8, -1]) @ energy / (12 * step)
    return np.where(np.abs(spring.gap[0]) > spring.backlash, slope, 0.0)


def _constants(joint: PlanetaryStage, planet: int) -> tuple[float, float]:
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
    """The highest harmonic of a law, or the number of pieces in its period."""
    if isinstance(law, stiffness.SineStiffness):
        return 1
    if isinstance(law, stiffness.FourierStiffness):
        return max(len(law.cosine_N_per_m), len(law.sine_N_per_m), 1)
    if isinstance(law, stiffness.SquareStiffness):
        return law.harmonics
    return len(law.phase_cycles)

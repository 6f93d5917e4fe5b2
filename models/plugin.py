"""What an engine from outside may take from the program: numbers of bodies, and tooth contacts.

An engine that has bodies and no gears need only say how far the teeth have come together; the force
law is here. No model of the program's own uses any of this, so that agreement with them still
says something of the law as well. Two plug-ins that both use it say nothing of it to each other.
"""

from __future__ import annotations

import cmath
from collections.abc import Iterator
from dataclasses import dataclass
from math import cos, pi, radians, sin, sqrt, tanh, tau
from typing import NamedTuple

import numpy as np

from crosscheck.models.arm import stiffness as stiffness_laws
from crosscheck.models.arm.arm import Arm, Link, Planetary
from crosscheck.models.arm.layout import Layout
from crosscheck.models.arm.mesh import PlanetMesh
from crosscheck.models.experiment.scenario import Scenario, Switches


class GearNumbers(NamedTuple):
    """Numbers of a joint's gears: base radii [m], and inertias about their own axes [kg m^2].

    carrier_radius [m] is how far the planets' centres are from the joint's axis; planet_inertia is
    that of one planet.
    """

    sun_radius: float
    planet_radius: float
    ring_radius: float
    carrier_radius: float
    sun_inertia: float
    planet_inertia: float
    carrier_inertia: float


def gear_numbers(joint: Planetary) -> GearNumbers:
    """Radii of a joint's gears from the teeth, and their inertias.

    An inertia not given is the equivalent mass times radius squared; the radius of a carrier's is
    both base radii together.
    """
    tooth = joint.module_m * cos(radians(joint.pressure_angle_deg)) / 2
    radii = tooth * joint.sun_teeth, tooth * joint.planet_teeth, tooth * joint.ring_teeth
    inertias = (
        _inertia(joint.sun_inertia_kg_m2, joint.sun_equivalent_mass_kg, radii[0]),
        _inertia(joint.planet_inertia_kg_m2, joint.planet_equivalent_mass_kg, radii[1]),
        _inertia(joint.carrier_inertia_kg_m2, joint.carrier_equivalent_mass_kg, sum(radii[:2])),
    )
    carrier = joint.module_m * (joint.sun_teeth + joint.planet_teeth) / 2
    return GearNumbers(*radii, carrier, *inertias)


def link_mass(link: Link) -> tuple[float, float]:
    """Mass [kg], and inertia [kg m^2] about its centre of mass, of a body or a uniform rod."""
    if link.mass_kg is not None:
        return link.mass_kg, link.inertia_kg_m2 or 0.0
    mass = (link.density_kg_per_m3 or 0.0) * (link.cross_section_m2 or 0.0) * link.length_m
    return mass, mass * link.length_m**2 / 12


class Motors:
    """The drives of an arm, where the motors are, by the law of an experiment."""

    def __init__(self, arm: Arm, scenario: Scenario) -> None:
        from crosscheck.models.experiment.drive import (  # a quarter of a second for numba
            drive_data,
            joint_torque,
        )

        self._law, self._output = drive_data(scenario, len(arm.joints)), joint_torque
        # Turns of the sun per turn of the carrier, both seen from the ring.
        self._ratios = [
            1 + joint.ring_teeth / joint.sun_teeth if isinstance(joint, Planetary) else 1.0
            for joint in arm.joints
        ]

    def torques(self, t: float, theta: np.ndarray, theta_rate: np.ndarray) -> np.ndarray:
        """Torques (joints,) [N m] by the previous link on what every motor turns.

        That is the sun, or the link of a joint without gears. At time t [s], by joint angles and
        their rates (joints,) [rad], [rad/s], relative to the previous link.
        """
        law, gains, times, torques = self._law
        joints = zip(gains, torques, theta, theta_rate, self._ratios, strict=True)
        return np.array([self._output(law, g, times, r, t, q, v) / n for g, r, q, v, n in joints])


def _inertia(given: float | None, equivalent_mass: float | None, radius: float) -> float:
    return given if given is not None else (equivalent_mass or 0.0) * radius**2


@dataclass(frozen=True)
class Waves:
    """k = mean + the real part of a sum over n = 1, 2, ... of wave_n exp(i n phase) [N/m]."""

    mean: float
    waves: tuple[complex, ...]

    def __call__(self, phase: float) -> tuple[float, float]:
        """k [N/m] and dk/dphase [N/m] at a phase [rad]."""
        turned = [(n, w * cmath.exp(1j * n * phase)) for n, w in enumerate(self.waves, 1)]
        return self.mean + sum(w.real for _, w in turned), -sum(n * w.imag for n, w in turned)


class Table:
    """The periodic cubic spline through a table's rows."""

    def __init__(self, law: stiffness_laws.TableStiffness) -> None:
        from scipy.interpolate import CubicSpline  # half a second, for tables alone

        self._curve = CubicSpline(law.phase_cycles, law.stiffness_N_per_m, bc_type="periodic")
        self._slope = self._curve.derivative()
        self.mean = float(self._curve.integrate(0.0, 1.0))

    def __call__(self, phase: float) -> tuple[float, float]:
        """k [N/m] and dk/dphase [N/m] at a phase [rad]."""
        cycles = phase / tau
        return float(self._curve(cycles)), float(self._slope(cycles)) / tau


def stiffness_curve(law: stiffness_laws.StiffnessLaw) -> Waves | Table:
    """Stiffness k over the mesh phase, by any of the laws.

    The square wave is ``largest`` for contact_ratio - 1 of a period (Eq. 7): its transform is cut.
    """
    if isinstance(law, stiffness_laws.TableStiffness):
        return Table(law)
    if isinstance(law, stiffness_laws.SineStiffness):
        return Waves(law.mean_N_per_m, (-1j * law.amplitude_N_per_m,))
    if isinstance(law, stiffness_laws.FourierStiffness):
        count = max(len(law.cosine_N_per_m), len(law.sine_N_per_m))
        waves = np.zeros(count, dtype=complex)
        waves[: len(law.cosine_N_per_m)] += law.cosine_N_per_m
        waves[: len(law.sine_N_per_m)] -= 1j * np.array(law.sine_N_per_m)
        return Waves(law.mean_N_per_m, tuple(waves.tolist()))
    swing, part = law.largest_N_per_m - law.least_N_per_m, law.contact_ratio - 1
    cut = (
        swing * (1 - cmath.exp(-1j * tau * n * part)) / (1j * pi * n)
        for n in range(1, law.harmonics + 1)
    )
    return Waves(law.least_N_per_m + swing * part, tuple(cut))


class Motion(NamedTuple):
    """What a contact must know: time [s], how far its teeth have come together, its joint's angle.

    approach [m] is positive where the central gear pushes the planet ahead, theta [rad] relative to
    the previous link; with their rates.
    """

    time: float
    approach: float
    approach_rate: float
    theta: float
    theta_rate: float


@dataclass(frozen=True)
class ToothContact:
    """A planet's contact with its sun, or with its ring.

    Args:
        joint: Number of the joint, from 0.
        planet: Number of the planet, from 0.
        with_sun: Whether the contact is with the sun; else it is with the ring.
        cycles: Periods of the mesh phase per turn of the joint.
        phase: Mesh phase at theta = 0 [rad].
        damping: Damping of this contact alone [N s/m].
        mesh: Backlash and tooth errors of the contact.
        stiffness: Stiffness [N/m] and its slope [N/m] by the mesh phase [rad].
        laws: Switches, which choose the laws of the contact.
    """

    joint: int
    planet: int
    with_sun: bool
    cycles: int
    phase: float
    damping: float
    mesh: PlanetMesh
    stiffness: Waves | Table
    laws: Switches

    def displacement(self, layout: Layout) -> np.ndarray:
        """Row (n,) that gives the teeth's approach by the coordinates of a layout."""
        return layout.displacement("x_sp" if self.with_sun else "x_pr", self.joint, self.planet)

    def motion(self, t: float, q: np.ndarray, v: np.ndarray, layout: Layout) -> Motion:
        """Motion of the contact at time t [s], by coordinates of a layout and their rates (n,)."""
        row, theta = self.displacement(layout), layout.at("theta", self.joint)
        return Motion(t, float(row @ q), float(row @ v), float(q[theta]), float(v[theta]))

    def force(self, motion: Motion) -> float:
        """Force k f(x - e) + d x' [N] of Eq. 15, positive where the planet is pushed ahead."""
        phase, gap = self._teeth(motion)
        stiffness, _ = self.stiffness(phase)
        damped = self.laws.damping == "always" or abs(gap) > self.mesh.backlash_m
        return stiffness * self._reach(gap) + damped * self.damping * motion.approach_rate

    def torque(self, motion: Motion) -> float:
        """Torque [N m] of the spring on its joint besides the force: -dV/dtheta at the same x.

        V = k f^2 / 2; zero unless the switch mesh_work says that it does work on the angle.
        """
        if self.laws.mesh_work == "paper":
            return 0.0
        phase, gap = self._teeth(motion)
        stiffness, slope = self.stiffness(phase)
        reach = self._reach(gap)
        widening = -self.mesh.tooth_error_m * cos(phase + self.mesh.tooth_error_phase_rad)
        return -self.cycles * (slope * reach**2 / 2 + stiffness * reach * widening)

    def _teeth(self, motion: Motion) -> tuple[float, float]:
        """Mesh phase [rad], and the gap x - e [m]."""
        by_angle = self.laws.phase == "angle"
        turned = motion.theta if by_angle else motion.theta_rate * motion.time
        phase, mesh = self.cycles * turned + self.phase, self.mesh
        wave = mesh.tooth_error_m * sin(phase + mesh.tooth_error_phase_rad)
        return phase, motion.approach - mesh.static_error_m - wave

    def _reach(self, gap: float) -> float:
        """What of the gap lies beyond the backlash [m], by Eq. 5 or as Eq. 6 rounds its corners."""
        play, sharpness = self.mesh.backlash_m, self.mesh.tanh_sharpness_per_m
        if self.laws.dead_zone == "exact":
            return max(gap - play, 0.0) + min(gap + play, 0.0)
        above, below = tanh(sharpness * (gap - play)), tanh(sharpness * (gap + play))
        return ((1 + above) * (gap - play) + (1 - below) * (gap + play)) / 2


def tooth_contacts(arm: Arm, laws: Switches) -> Iterator[ToothContact]:
    """All tooth contacts of an arm: joint by joint, planet by planet, the sun's and the ring's."""
    for number, joint in enumerate(arm.joints):
        if isinstance(joint, Planetary):
            for planet in range(joint.planet_count):
                for with_sun in (True, False):
                    yield _contact(number, joint, planet, with_sun, laws)


def _contact(
    number: int, joint: Planetary, planet: int, with_sun: bool, laws: Switches
) -> ToothContact:
    """The tooth contact of a planet with the sun or the ring of a joint.

    Seen from the carrier, sun and ring pass z_r teeth per turn; Eq. 13 has z_s for the ring.
    """
    mesh = (joint.sun_mesh if with_sun else joint.ring_mesh).planet_mesh(planet)
    papers = not with_sun and laws.ring_rate == "eq13"
    cycles = joint.sun_teeth if papers else joint.ring_teeth
    phase = mesh.phase_rad
    if phase is None:
        phase = _phase_from_teeth(joint, planet, with_sun)
    curve = stiffness_curve(mesh.stiffness)
    damping = _damping(joint, mesh, curve.mean, with_sun)
    return ToothContact(number, planet, with_sun, cycles, phase, damping, mesh, curve, laws)


def _phase_from_teeth(joint: Planetary, planet: int, with_sun: bool) -> float:
    """Mesh phase [rad] at theta = 0: each planet sits z_s / N of the sun's pitches after the first.

    So it does of the ring's, as N divides z_s + z_r. Across a planet the same push meets opposite
    flanks: half its pitches lie between, less half of one.
    """
    place = -joint.sun_teeth * planet % joint.planet_count / joint.planet_count
    if with_sun:
        return tau * place
    first = joint.sun_mesh.planet_mesh(0).phase_rad or 0.0
    return tau * (place + (joint.planet_teeth - 1) % 2 / 2) + first


def _damping(joint: Planetary, mesh: PlanetMesh, stiffness: float, with_sun: bool) -> float:
    """Damping [N s/m] of one of N planets: an N-th of d, or of 2 zeta sqrt(N k M)."""
    count, gears = joint.planet_count, gear_numbers(joint)
    if mesh.damping_ratio is None:
        return (mesh.damping_N_s_per_m or 0.0) / count
    sun = gears.sun_inertia / gears.sun_radius**2
    planets = count * gears.planet_inertia / gears.planet_radius**2
    mass = sun if with_sun else planets
    return 2 * mesh.damping_ratio * sqrt(count * stiffness * mass) / count

"""What springs and dampers of single planets do, from first principles, for any geared arm.

Written down from the laws alone, mesh by mesh: phases by counting teeth in whole numbers, and
energies that take complex coordinates, whose imaginary part then is an exact derivative.
"""

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from math import pi, sqrt

import numpy as np
from hypothesis import strategies as st
from scipy.interpolate import CubicSpline

from crosscheck.models.arm import stiffness
from crosscheck.models.arm.arm import Arm, Planetary
from crosscheck.models.arm.layout import Layout
from crosscheck.models.arm.mesh import Mesh, PlanetMesh
from crosscheck.models.experiment.scenario import Switches
from tests.any_arms import any_links, direct_joints, planetary_joints
from tests.mixed_arms import NONE, arm_of

STEP = 1e-40  # of complex steps: its square is nothing beside any energy


@dataclass(frozen=True)
class Contact:
    """One planet's mesh: x = row . q [m], phase = rate theta + phase, theta = q[angle]."""

    mesh: PlanetMesh
    row: np.ndarray
    angle: int
    rate: int
    phase: float
    damping: float

    def phase_at(self, turned: complex) -> complex:
        """Phase [rad] at a joint angle, or at its rate times the time."""
        return self.rate * turned + self.phase

    def reach(self, x: complex, phase: complex) -> complex:
        """f_k(x - e) [m], Eq. 5."""
        gap = x - self.error(phase)
        b = self.mesh.backlash_m
        return gap - b if gap.real > b else gap + b if gap.real < -b else 0 * gap

    def rounded_reach(self, x: complex, phase: complex) -> complex:
        """The same by Eq. 6, which has hyperbolic tangents for corners."""
        gap, b, sharpness = (
            x - self.error(phase),
            self.mesh.backlash_m,
            self.mesh.tanh_sharpness_per_m,
        )
        left, right = np.tanh(sharpness * (gap - b)), np.tanh(sharpness * (gap + b))
        return gap + gap / 2 * (left - right) - b / 2 * (left + right)

    def error(self, phase: complex) -> complex:
        """e [m] at a phase."""
        turning = np.sin(phase + self.mesh.tooth_error_phase_rad)
        return self.mesh.static_error_m + self.mesh.tooth_error_m * turning

    def energy(self, q: np.ndarray) -> complex:
        """k f_k^2 / 2 [J] with phases by the joint's angle."""
        phase = self.phase_at(q[self.angle])
        return stiffness_at(self.mesh.stiffness, phase) * self.reach(self.row @ q, phase) ** 2 / 2


def contacts(arm: Arm, chosen: Switches, layout: Layout) -> list[Contact]:
    """Every planet's meshes in the coordinates of a layout."""
    return [
        _contact(joint, number, planet, inner, chosen, layout)
        for number, joint in enumerate(arm.joints)
        for planet in range(joint.planet_count)
        for inner in (True, False)
        if isinstance(joint, Planetary)
    ]


def _contact(
    joint: Planetary, number: int, planet: int, inner: bool, chosen: Switches, layout: Layout
) -> Contact:
    side: Mesh = joint.sun_mesh if inner else joint.ring_mesh
    mesh = side.planet_mesh(planet)
    return Contact(
        mesh=mesh,
        row=layout.displacement("x_sp" if inner else "x_pr", number, planet),
        angle=layout.at("theta", number),
        rate=joint.ring_teeth if inner or chosen.ring_rate == "corrected" else joint.sun_teeth,
        phase=_teeth_phase(joint, planet, inner) if mesh.phase_rad is None else mesh.phase_rad,
        damping=_damping(joint, mesh, inner),
    )


def _teeth_phase(joint: Planetary, planet: int, inner: bool) -> float:
    """Parker and Lin (2004): delays z_s n / N, -z_r n / N and, for even z_p, half a pitch."""
    turn = Fraction(planet, joint.planet_count)
    if inner:
        return 2 * pi * float(-joint.sun_teeth * turn % 1)
    half = Fraction(1 - joint.planet_teeth % 2, 2)
    sun = joint.sun_mesh.planet_mesh(0).phase_rad
    return 2 * pi * float((joint.ring_teeth * turn + half) % 1) + (sun or 0.0)


def _damping(joint: Planetary, mesh: PlanetMesh, inner: bool) -> float:
    """d of one planet [N s/m]."""
    planets = joint.planet_count
    if mesh.damping_N_s_per_m is not None:
        return mesh.damping_N_s_per_m / planets
    half = joint.module_m / 2 * np.cos(np.radians(joint.pressure_angle_deg))
    mass = joint.sun_equivalent_mass_kg if inner else joint.planet_equivalent_mass_kg
    if mass is None:
        own = joint.sun_inertia_kg_m2 if inner else joint.planet_inertia_kg_m2
        mass = own / (half * (joint.sun_teeth if inner else joint.planet_teeth)) ** 2
    all_planets = planets * mean_stiffness(mesh.stiffness) * mass * (1 if inner else planets)
    return 2 * mesh.damping_ratio * sqrt(all_planets) / planets


def spring_energy(found: list[Contact], q: np.ndarray) -> complex:
    """Of all meshes [J]."""
    return sum((contact.energy(q) for contact in found), 0j)


def slope(energy: Callable[[np.ndarray], complex], q: np.ndarray) -> np.ndarray:
    """Its gradient, shape (n,), by complex steps."""
    steps = 1j * STEP * np.eye(len(q))
    return np.array([energy(q + step).imag / STEP for step in steps])


def mesh_forces(
    found: list[Contact], chosen: Switches, t: float, q: np.ndarray, v: np.ndarray
) -> np.ndarray:
    """Minus row (k f + d x') of all meshes, springs and dampers, shape (n,)."""
    force = np.zeros(len(q))
    for contact in found:
        turned = q[contact.angle] if chosen.phase == "angle" else v[contact.angle] * t
        phase = contact.phase_at(turned)
        reach = contact.reach(contact.row @ q, phase)
        acts = chosen.damping == "always" or reach != 0
        damping = acts * contact.damping * (contact.row @ v)
        if chosen.dead_zone == "tanh":
            reach = contact.rounded_reach(contact.row @ q, phase)
        elastic = stiffness_at(contact.mesh.stiffness, phase) * reach
        force -= contact.row * (elastic + damping)
    return force


def expected_force(
    arm: Arm, chosen: Switches, layout: Layout, t: float, q: np.ndarray, v: np.ndarray
) -> np.ndarray:
    """Meshes and friction on an arm without weight or drive, shape (n,)."""
    found = contacts(arm, chosen, layout)
    force = mesh_forces(found, chosen, t, q, v)
    if chosen.mesh_work == "conservative":
        force[layout.theta] -= slope(lambda at: spring_energy(found, at), q)[layout.theta]
    friction = np.array([joint.friction_N_m_s_per_rad for joint in arm.joints])
    force[layout.theta] -= friction * v[layout.theta]
    return force


def stiffness_at(law: stiffness.StiffnessLaw, phase: complex) -> complex:
    """k [N/m] as the law's description has it."""
    if isinstance(law, stiffness.SineStiffness):
        return law.mean_N_per_m + law.amplitude_N_per_m * np.sin(phase)
    if isinstance(law, stiffness.TableStiffness):
        return _spline_at(law, phase / (2 * pi))
    if isinstance(law, stiffness.FourierStiffness):
        cosines = (c * np.cos(n * phase) for n, c in enumerate(law.cosine_N_per_m, 1))
        sines = (s * np.sin(n * phase) for n, s in enumerate(law.sine_N_per_m, 1))
        return law.mean_N_per_m + sum(cosines) + sum(sines)
    swing, overlap = law.largest_N_per_m - law.least_N_per_m, law.contact_ratio - 1
    waves = (
        (np.sin(i * (2 * pi * overlap - phase)) + np.sin(i * phase)) / (i * pi)
        for i in range(1, law.harmonics + 1)
    )
    return law.least_N_per_m + swing * (overlap + sum(waves))


@lru_cache
def _spline(law: stiffness.TableStiffness) -> CubicSpline:
    return CubicSpline(law.phase_cycles, law.stiffness_N_per_m, bc_type="periodic")


def _spline_at(law: stiffness.TableStiffness, cycles: complex) -> complex:
    spline = _spline(law)
    within = cycles - np.floor(cycles.real)
    piece = min(int(np.searchsorted(spline.x, within.real, "right")), len(spline.x) - 1) - 1
    return np.polyval(spline.c[:, piece], within - spline.x[piece])


def mean_stiffness(law: stiffness.StiffnessLaw) -> float:
    """Over a period [N/m]."""
    if isinstance(law, stiffness.TableStiffness):
        return float(_spline(law).integrate(0, 1))
    if isinstance(law, stiffness.SineStiffness | stiffness.FourierStiffness):
        return law.mean_N_per_m
    swing = law.largest_N_per_m - law.least_N_per_m
    return law.least_N_per_m + swing * (law.contact_ratio - 1)


def rounding(found: list[Contact]) -> float:
    """What a displacement rounds to, a difference of arcs of a metre, times all springs [N]."""
    springs = sum(mean_stiffness(contact.mesh.stiffness) for contact in found)
    return float(100 * np.finfo(float).eps * springs)


@st.composite
def unlike_arms(draw: st.DrawFn, most_joints: int = 2) -> Arm:
    """Arms without weight whose 2 to 6 planets differ in everything that may differ."""
    unlike = planetary_joints(unlike=True)
    joints = [draw(unlike), *draw(st.lists(unlike | direct_joints(), max_size=most_joints - 1))]
    return arm_of(*joints, links=[draw(any_links()) for _ in joints], gravity=NONE)
